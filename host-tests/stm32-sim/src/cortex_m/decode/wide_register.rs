//! 32-bit instructions with register operands only: shifts, extensions, reversals, multiplications, divisions (ARM ARM A5.3.12 to
//! A5.3.17).

use super::instruction::{Extend, Instruction, Rearrange, Register, SetFlags, Shift};
use super::rule::Rule;
use super::{
    Table, anywhere, bit, bits, refuse_if, refuse_sp_and_pc, register, should_be, undefined,
};

/// Data processing with registers (A5.3.12).
pub fn data_processing(word: u32) -> Table {
    if bits(word, 12, 4) != 0b1111 {
        return undefined(Rule::Unallocated);
    }
    let (op1, op2) = (bits(word, 20, 4), bits(word, 4, 4));
    match (op1, op2) {
        (0b0000..=0b0111, 0b0000) => shift(word),
        (0b0000..=0b0101, 0b1000..=0b1111) => extend(word),
        (0b1000..=0b1011, 0b1000..=0b1011) => rearrange(word),
        (0b1000..=0b1111, 0b0000..=0b0111) => undefined(Rule::DspExtension),
        _ => undefined(Rule::Unallocated),
    }
}

/// LSL, LSR, ASR, ROR by a register.
fn shift(word: u32) -> Table {
    let (d, n, m) = (register(word, 8), register(word, 16), register(word, 0));
    refuse_sp_and_pc(&[d, n, m])?;
    anywhere(Instruction::ShiftByRegister {
        shift: match bits(word, 21, 2) {
            0 => Shift::Lsl,
            1 => Shift::Lsr,
            2 => Shift::Asr,
            _ => Shift::Ror,
        },
        d,
        n,
        m,
        flags: SetFlags::from_bit(bit(word, 20)),
    })
}

/// SXTH, UXTH, SXTB, UXTB; the forms with Rn add and belong to the DSP extension.
fn extend(word: u32) -> Table {
    let kind = match bits(word, 20, 3) {
        0b000 => Extend::SignedHalfWord,
        0b001 => Extend::HalfWord,
        0b100 => Extend::SignedByte,
        0b101 => Extend::Byte,
        _ => return undefined(Rule::DspExtension),
    };
    if register(word, 16) != Register::PC {
        return undefined(Rule::DspExtension);
    }
    should_be(word, 1 << 6, 0)?;
    let (d, m) = (register(word, 8), register(word, 0));
    refuse_sp_and_pc(&[d, m])?;
    anywhere(Instruction::ExtendRegister {
        kind,
        d,
        m,
        rotation: 8 * bits(word, 4, 2) as u8,
    })
}

/// A5.3.15: REV and similar, CLZ.
fn rearrange(word: u32) -> Table {
    let kind = match (bits(word, 20, 2), bits(word, 4, 2)) {
        (0b01, 0b00) => Rearrange::ReverseBytes,
        (0b01, 0b01) => Rearrange::ReverseBytesOfHalfWords,
        (0b01, 0b10) => Rearrange::ReverseBits,
        (0b01, _) => Rearrange::ReverseSignedHalfWord,
        (0b11, 0b00) => Rearrange::CountLeadingZeros,
        (0b00, _) | (0b10, 0b00) => return undefined(Rule::DspExtension),
        _ => return undefined(Rule::Unallocated),
    };
    let (d, m) = (register(word, 8), register(word, 0));
    refuse_if(register(word, 16) != m, Rule::InconsistentRegister)?;
    refuse_sp_and_pc(&[d, m])?;
    anywhere(Instruction::RearrangeBits { kind, d, m })
}

/// A5.3.16: MUL, MLA, MLS.
pub fn multiply(word: u32) -> Table {
    let (a, d) = (register(word, 12), register(word, 8));
    let (n, m) = (register(word, 16), register(word, 0));
    match (bits(word, 20, 3), bits(word, 4, 4)) {
        (0b000, 0b0000) if a == Register::PC => {
            refuse_sp_and_pc(&[d, n, m])?;
            let flags = SetFlags::No;
            anywhere(Instruction::Multiply { d, n, m, flags })
        }
        (0b000, 0b0000) => {
            refuse_sp_and_pc(&[d, n, m, a])?;
            anywhere(Instruction::MultiplyAdd { d, n, m, a })
        }
        (0b000, 0b0001) => {
            refuse_sp_and_pc(&[d, n, m, a])?;
            anywhere(Instruction::MultiplySubtract { d, n, m, a })
        }
        (0b001..=0b111, 0b0000..=0b0011) => undefined(Rule::DspExtension),
        _ => undefined(Rule::Unallocated),
    }
}

/// A5.3.17: products of 64 bits, and the divisions.
pub fn long_multiply(word: u32) -> Table {
    let (low, high) = (register(word, 12), register(word, 8));
    let (n, m) = (register(word, 16), register(word, 0));
    let op1 = bits(word, 20, 3);
    match (op1, bits(word, 4, 4)) {
        (0b000 | 0b010 | 0b100 | 0b110, 0b0000) => {
            refuse_sp_and_pc(&[low, high, n, m])?;
            refuse_if(low == high, Rule::SameRegister)?;
            anywhere(Instruction::MultiplyLong {
                signed: op1 & 0b010 == 0,
                accumulate: op1 & 0b100 != 0,
                low,
                high,
                n,
                m,
            })
        }
        (0b001 | 0b011, 0b1111) => {
            should_be(word, 0xF << 12, 0xF << 12)?;
            refuse_sp_and_pc(&[high, n, m])?;
            anywhere(Instruction::Divide {
                signed: op1 == 0b001,
                d: high,
                n,
                m,
            })
        }
        (0b100, 0b1000..=0b1101) | (0b101, 0b1100 | 0b1101) | (0b110, 0b0110) => {
            undefined(Rule::DspExtension)
        }
        _ => undefined(Rule::Unallocated),
    }
}
