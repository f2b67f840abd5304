//! 32-bit loads and stores, and the table branches (ARM ARM A5.3.7 to A5.3.10).

use super::instruction::{Index, Instruction, Multiple, Register, Size};
use super::rule::Rule;
use super::{
    Table, anywhere, bit, bits, last, refuse_if, refuse_sp_and_pc, register, should_be, undefined,
};

/// LDM, STM, PUSH, POP (A5.3.5).
pub fn multiple(word: u32) -> Table {
    let kind = match bits(word, 23, 2) {
        0b01 => Multiple::IncrementAfter,
        0b10 => Multiple::DecrementBefore,
        _ => return undefined(Rule::Unallocated),
    };
    let n = register(word, 16);
    let write_back = bit(word, 21);
    let list = bits(word, 0, 16) as u16;
    let load = bit(word, 20);
    should_be(word, if load { 1 << 13 } else { 1 << 15 | 1 << 13 }, 0)?;
    refuse_if(n == Register::PC, Rule::StackPointerOrPc)?;
    refuse_if(list.count_ones() < 2, Rule::ShortList)?;
    let transferred = write_back && list >> n.index() & 1 != 0;
    refuse_if(transferred, Rule::WriteBackOfTransferred)?;
    if !load {
        return anywhere(Instruction::StoreMultiple {
            n,
            kind,
            write_back,
            list,
        });
    }
    refuse_if(list >> 14 == 0b11, Rule::PcAndLr)?;
    let load = Instruction::LoadMultiple {
        n,
        kind,
        write_back,
        list,
    };
    if list >> 15 != 0 {
        last(load)
    } else {
        anywhere(load)
    }
}

/// LDRD, STRD, exclusive accesses and table branches (A5.3.6).
pub fn dual_or_exclusive(word: u32) -> Table {
    let (op1, load) = (bits(word, 23, 2), bit(word, 20));
    match (op1, bit(word, 21)) {
        (0b00, false) => {
            let offset = bits(word, 0, 8) as u16 * 4;
            exclusive(word, load, Size::Word, register(word, 8), offset)
        }
        (0b01, false) => match bits(word, 4, 4) {
            0b0000 | 0b0001 if load => table_branch(word),
            0b0100 => exclusive(word, load, Size::Byte, register(word, 0), 0),
            0b0101 => exclusive(word, load, Size::HalfWord, register(word, 0), 0),
            _ => undefined(Rule::Unallocated),
        },
        _ => dual(word, load),
    }
}

/// LDREX and STREX of all sizes; `d` is the status register of this encoding.
fn exclusive(word: u32, load: bool, size: Size, d: Register, offset: u16) -> Table {
    let (t, n) = (register(word, 12), register(word, 16));
    let narrow = size != Size::Word;
    if narrow {
        should_be(word, 0xF00, 0xF00)?;
    }
    refuse_sp_and_pc(&[t])?;
    refuse_if(n == Register::PC, Rule::StackPointerOrPc)?;
    if load {
        refuse_if(d != Register::PC, Rule::ShouldBe)?;
        return anywhere(Instruction::LoadExclusive { size, t, n, offset });
    }
    refuse_sp_and_pc(&[d])?;
    refuse_if(d == n || d == t, Rule::SameRegister)?;
    anywhere(Instruction::StoreExclusive {
        size,
        d,
        t,
        n,
        offset,
    })
}

fn table_branch(word: u32) -> Table {
    should_be(word, 0xFF00, 0xF000)?;
    let (n, m) = (register(word, 16), register(word, 0));
    refuse_if(n == Register::SP, Rule::StackPointerOrPc)?;
    refuse_sp_and_pc(&[m])?;
    last(Instruction::TableBranch {
        n,
        m,
        half_words: bit(word, 4),
    })
}

fn dual(word: u32, load: bool) -> Table {
    let (t, t2, n) = (register(word, 12), register(word, 8), register(word, 16));
    let index = index(bit(word, 24), bit(word, 21));
    let offset = signed_offset(bits(word, 0, 8) as i16 * 4, bit(word, 23));
    let write_back = index != Index::Offset;
    refuse_sp_and_pc(&[t, t2])?;
    refuse_if(
        n == Register::PC && (write_back || !load),
        Rule::StackPointerOrPc,
    )?;
    refuse_if(
        write_back && (n == t || n == t2),
        Rule::WriteBackOfTransferred,
    )?;
    if !load {
        return anywhere(Instruction::StoreDual {
            t,
            t2,
            n,
            index,
            offset,
        });
    }
    refuse_if(t == t2, Rule::SameRegister)?;
    anywhere(Instruction::LoadDual {
        t,
        t2,
        n,
        index,
        offset,
    })
}

/// From the bits P and W; the encoding without both belongs to another instruction.
fn index(p: bool, w: bool) -> Index {
    match (p, w) {
        (true, false) => Index::Offset,
        (true, true) => Index::Pre,
        (false, _) => Index::Post,
    }
}

fn signed_offset(magnitude: i16, up: bool) -> i16 {
    if up { magnitude } else { -magnitude }
}

/// A single load or store, or a memory hint (A5.3.7 to A5.3.10).
pub fn single(word: u32) -> Table {
    let (load, signed) = (bit(word, 20), bit(word, 24));
    if signed && !load {
        return undefined(Rule::AdvancedSimd);
    }
    let size = match (bits(word, 21, 2), signed) {
        (0b00, false) => Size::Byte,
        (0b00, true) => Size::SignedByte,
        (0b01, false) => Size::HalfWord,
        (0b01, true) => Size::SignedHalfWord,
        (0b10, false) => Size::Word,
        _ => return undefined(Rule::Unallocated),
    };
    let n = register(word, 16);
    match (load, n == Register::PC) {
        (true, true) => literal(word, size),
        (true, false) => address(word, size, true),
        (false, true) => undefined(Rule::StoreToPc),
        (false, false) => address(word, size, false),
    }
}

/// A load relative to PC.
fn literal(word: u32, size: Size) -> Table {
    let t = register(word, 12);
    if is_hint(size, t) {
        return anywhere(Instruction::Nop);
    }
    let offset = signed_offset(bits(word, 0, 12) as i16, bit(word, 23));
    transferred(size, t)?;
    ending(t, Instruction::LoadLiteral { size, t, offset })
}

/// A load or store with a base register: the four ways to form the address.
fn address(word: u32, size: Size, load: bool) -> Table {
    let (t, n, m) = (register(word, 12), register(word, 16), register(word, 0));
    let hint = load && is_hint(size, t);
    if bit(word, 23) {
        return offset(size, t, n, bits(word, 0, 12) as i16, load);
    }
    if bits(word, 6, 6) == 0 {
        refuse_sp_and_pc(&[m])?;
        if hint {
            return anywhere(Instruction::Nop);
        }
        transferred(size, t)?;
        let shift = bits(word, 4, 2) as u8;
        if load {
            return ending(
                t,
                Instruction::LoadRegister {
                    size,
                    t,
                    n,
                    m,
                    shift,
                },
            );
        }
        refuse_if(t == Register::PC, Rule::StackPointerOrPc)?;
        return anywhere(Instruction::StoreRegister {
            size,
            t,
            n,
            m,
            shift,
        });
    }
    let byte = bits(word, 0, 8) as i16;
    let (p, up, w) = (bit(word, 10), bit(word, 9), bit(word, 8));
    match (bit(word, 11), p, up, w) {
        (true, true, false, false) => offset(size, t, n, -byte, load),
        // LDRT, STRT and similar: unprivileged access.
        (true, true, true, false) => {
            refuse_sp_and_pc(&[t])?;
            offset(size, t, n, byte, load)
        }
        (true, _, _, true) => indexed(size, t, n, index(p, w), signed_offset(byte, up), load),
        _ => undefined(Rule::Unallocated),
    }
}

/// `[Rn, #offset]`.
fn offset(size: Size, t: Register, n: Register, offset: i16, load: bool) -> Table {
    if load && is_hint(size, t) {
        return anywhere(Instruction::Nop);
    }
    transferred(size, t)?;
    if load {
        return ending(t, Instruction::LoadOffset { size, t, n, offset });
    }
    refuse_if(t == Register::PC, Rule::StackPointerOrPc)?;
    anywhere(Instruction::StoreOffset { size, t, n, offset })
}

/// With write-back of the base. Hints have no such form.
fn indexed(size: Size, t: Register, n: Register, index: Index, offset: i16, load: bool) -> Table {
    transferred(size, t)?;
    let only_words = size != Size::Word || !load;
    refuse_if(t == Register::PC && only_words, Rule::StackPointerOrPc)?;
    refuse_if(t == n, Rule::WriteBackOfTransferred)?;
    if !load {
        return anywhere(Instruction::StoreIndexed {
            size,
            t,
            n,
            index,
            offset,
        });
    }
    ending(
        t,
        Instruction::LoadIndexed {
            size,
            t,
            n,
            index,
            offset,
        },
    )
}

/// Loads of bytes and half-words to PC are preloads or unallocated hints, and do nothing (A5.3.8, A5.3.9).
fn is_hint(size: Size, t: Register) -> bool {
    size != Size::Word && t == Register::PC
}

/// SP can only be transferred as a word.
fn transferred(size: Size, t: Register) -> Result<(), Instruction> {
    refuse_if(
        size != Size::Word && t == Register::SP,
        Rule::StackPointerOrPc,
    )
}

/// A load to PC branches.
fn ending(t: Register, instruction: Instruction) -> Table {
    if t == Register::PC {
        last(instruction)
    } else {
        anywhere(instruction)
    }
}
