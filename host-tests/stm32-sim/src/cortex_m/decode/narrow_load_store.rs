//! 16-bit loads and stores (ARM ARM A5.2.4, and those of A5.2 and A5.2.5 with several registers).

use super::instruction::{Instruction, Multiple, Register, Size};
use super::narrow::low;
use super::rule::Rule;
use super::{Table, anywhere, bit, bits, last, refuse_if};

/// A5.2.4, the forms with two registers.
pub fn load_store_register(word: u32) -> Table {
    let (t, n, m) = (low(word, 0), low(word, 3), low(word, 6));
    let store = |size| {
        anywhere(Instruction::StoreRegister {
            size,
            t,
            n,
            m,
            shift: 0,
        })
    };
    let load = |size| {
        anywhere(Instruction::LoadRegister {
            size,
            t,
            n,
            m,
            shift: 0,
        })
    };
    match bits(word, 9, 3) {
        0b000 => store(Size::Word),
        0b001 => store(Size::HalfWord),
        0b010 => store(Size::Byte),
        0b011 => load(Size::SignedByte),
        0b100 => load(Size::Word),
        0b101 => load(Size::HalfWord),
        0b110 => load(Size::Byte),
        _ => load(Size::SignedHalfWord),
    }
}

/// A5.2.4, the forms with an offset.
pub fn load_store_immediate(word: u32) -> Table {
    let number = bits(word, 6, 5) as i16;
    let (t, n) = (low(word, 0), low(word, 3));
    let (size, t, n, offset) = match bits(word, 12, 4) {
        0b0110 => (Size::Word, t, n, number * 4),
        0b0111 => (Size::Byte, t, n, number),
        0b1000 => (Size::HalfWord, t, n, number * 2),
        _ => {
            let offset = bits(word, 0, 8) as i16 * 4;
            (Size::Word, low(word, 8), Register::SP, offset)
        }
    };
    if bit(word, 11) {
        anywhere(Instruction::LoadOffset { size, t, n, offset })
    } else {
        anywhere(Instruction::StoreOffset { size, t, n, offset })
    }
}

/// PUSH and POP; bit 8 selects LR or PC.
pub fn push_pop(word: u32, extra: u32) -> Table {
    let list = (bits(word, 0, 8) | bits(word, 8, 1) << extra) as u16;
    refuse_if(list == 0, Rule::ShortList)?;
    let n = Register::SP;
    if !bit(word, 11) {
        return anywhere(Instruction::StoreMultiple {
            n,
            kind: Multiple::DecrementBefore,
            write_back: true,
            list,
        });
    }
    let pop = Instruction::LoadMultiple {
        n,
        kind: Multiple::IncrementAfter,
        write_back: true,
        list,
    };
    if list >> 15 != 0 {
        last(pop)
    } else {
        anywhere(pop)
    }
}

/// STM and LDM, always upwards from the base.
pub fn multiple(word: u32) -> Table {
    let n = low(word, 8);
    let list = bits(word, 0, 8) as u16;
    refuse_if(list == 0, Rule::ShortList)?;
    let kind = Multiple::IncrementAfter;
    let listed = list >> n.index() & 1 != 0;
    if bit(word, 11) {
        return anywhere(Instruction::LoadMultiple {
            n,
            kind,
            write_back: !listed,
            list,
        });
    }
    // The stored value of a base that is not the lowest register is UNKNOWN (A7.7.159).
    let lowest = list.trailing_zeros() as usize == n.index();
    refuse_if(listed && !lowest, Rule::WriteBackOfTransferred)?;
    anywhere(Instruction::StoreMultiple {
        n,
        kind,
        write_back: true,
        list,
    })
}
