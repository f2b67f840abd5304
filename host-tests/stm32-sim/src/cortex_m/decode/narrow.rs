//! 16-bit instructions (ARM ARM A5.2).

use super::instruction::{
    Carry, Condition, DataOp, Extend, Instruction, Rearrange, Register, SetFlags, Shift, Size,
};
use super::narrow_load_store::{load_store_immediate, load_store_register, multiple, push_pop};
use super::rule::Rule;
use super::{
    Table, anywhere, bit, bits, last, outside, refuse_if, register, should_be, signed, undefined,
};

/// Decodes an instruction of 16 bits (table A5-1).
pub fn decode(word: u32) -> Table {
    match bits(word, 10, 6) {
        0b00_0000..=0b00_1111 => immediate(word),
        0b01_0000 => data_processing(word),
        0b01_0001 => special_data(word),
        0b01_0010 | 0b01_0011 => anywhere(Instruction::LoadLiteral {
            size: Size::Word,
            t: low(word, 8),
            offset: (bits(word, 0, 8) * 4) as i16,
        }),
        0b01_0100..=0b01_0111 => load_store_register(word),
        0b01_1000..=0b10_0111 => load_store_immediate(word),
        0b10_1000 | 0b10_1001 => anywhere(Instruction::Address {
            d: low(word, 8),
            offset: (bits(word, 0, 8) * 4) as i32,
        }),
        0b10_1010 | 0b10_1011 => adjust_sp(DataOp::Add, low(word, 8), bits(word, 0, 8)),
        0b10_1100..=0b10_1111 => miscellaneous(word),
        0b11_0000..=0b11_0011 => multiple(word),
        0b11_0100..=0b11_0111 => conditional(word),
        // Encodings that start with 11101 or 1111 are 32-bit instructions and not passed to this function.
        _ => last(Instruction::Branch {
            offset: signed(bits(word, 0, 11) << 1, 12),
        }),
    }
}

/// One of R0 to R7.
pub fn low(word: u32, position: u32) -> Register {
    Register::new(bits(word, position, 3))
}

/// A5.2.1: shift by immediate, add, subtract, move, compare.
fn immediate(word: u32) -> Table {
    let (d, n) = (low(word, 0), low(word, 3));
    let flags = SetFlags::OutsideIt;
    let with_number = |op, d, n, value| {
        anywhere(Instruction::DataImmediate {
            op,
            d,
            n,
            flags,
            carry: Carry::Keep,
            value,
        })
    };
    let with_register = |op| {
        let m = low(word, 6);
        anywhere(Instruction::DataRegister { op, d, n, m, flags })
    };
    let (wide_d, byte) = (low(word, 8), bits(word, 0, 8));
    match bits(word, 9, 5) {
        0b0_0000..=0b0_1011 => shift_by_immediate(word, d, n),
        0b0_1100 => with_register(DataOp::Add),
        0b0_1101 => with_register(DataOp::Sub),
        0b0_1110 => with_number(DataOp::Add, d, n, bits(word, 6, 3)),
        0b0_1111 => with_number(DataOp::Sub, d, n, bits(word, 6, 3)),
        0b1_0000..=0b1_0011 => with_number(DataOp::Mov, wide_d, wide_d, byte),
        0b1_0100..=0b1_0111 => anywhere(Instruction::CompareImmediate {
            op: DataOp::Sub,
            n: wide_d,
            carry: Carry::Keep,
            value: byte,
        }),
        0b1_1000..=0b1_1011 => with_number(DataOp::Add, wide_d, wide_d, byte),
        _ => with_number(DataOp::Sub, wide_d, wide_d, byte),
    }
}

/// LSL, LSR, ASR by an immediate. LSL by 0 is MOVS, which must be outside IT blocks (A7.7.77, T2).
fn shift_by_immediate(word: u32, d: Register, m: Register) -> Table {
    let amount = bits(word, 6, 5) as u8;
    let (shift, amount) = match (bits(word, 11, 2), amount) {
        (0, 0) => {
            return outside(Instruction::DataRegister {
                op: DataOp::Mov,
                d,
                n: d,
                m,
                flags: SetFlags::Yes,
            });
        }
        (0, amount) => (Shift::Lsl, amount),
        (1, 0) => (Shift::Lsr, 32),
        (1, amount) => (Shift::Lsr, amount),
        (_, 0) => (Shift::Asr, 32),
        (_, amount) => (Shift::Asr, amount),
    };
    anywhere(Instruction::DataShifted {
        op: DataOp::Mov,
        d,
        n: d,
        m,
        flags: SetFlags::OutsideIt,
        shift,
        amount,
    })
}

/// A5.2.2: data processing.
fn data_processing(word: u32) -> Table {
    let (d, m) = (low(word, 0), low(word, 3));
    let flags = SetFlags::OutsideIt;
    let data = |op| {
        anywhere(Instruction::DataRegister {
            op,
            d,
            n: d,
            m,
            flags,
        })
    };
    let shifted = |shift| {
        anywhere(Instruction::ShiftByRegister {
            shift,
            d,
            n: d,
            m,
            flags,
        })
    };
    let compare = |op| anywhere(Instruction::CompareRegister { op, n: d, m });
    match bits(word, 6, 4) {
        0b0000 => data(DataOp::And),
        0b0001 => data(DataOp::Eor),
        0b0010 => shifted(Shift::Lsl),
        0b0011 => shifted(Shift::Lsr),
        0b0100 => shifted(Shift::Asr),
        0b0101 => data(DataOp::Adc),
        0b0110 => data(DataOp::Sbc),
        0b0111 => shifted(Shift::Ror),
        0b1000 => compare(DataOp::And),
        0b1001 => anywhere(Instruction::DataImmediate {
            op: DataOp::Rsb,
            d,
            n: m,
            flags,
            carry: Carry::Keep,
            value: 0,
        }),
        0b1010 => compare(DataOp::Sub),
        0b1011 => compare(DataOp::Add),
        0b1100 => data(DataOp::Orr),
        0b1101 => anywhere(Instruction::Multiply {
            d,
            n: m,
            m: d,
            flags,
        }),
        0b1110 => data(DataOp::Bic),
        _ => data(DataOp::Mvn),
    }
}

/// A5.2.3: ADD, CMP, MOV with high registers, BX, BLX.
fn special_data(word: u32) -> Table {
    let d = Register::new(bits(word, 7, 1) << 3 | bits(word, 0, 3));
    let m = register(word, 3);
    match bits(word, 8, 2) {
        0b00 => {
            let both = d == Register::PC && m == Register::PC;
            refuse_if(both, Rule::StackPointerOrPc)?;
            if d == Register::PC {
                return last(Instruction::AddToPc { m });
            }
            anywhere(Instruction::DataRegister {
                op: DataOp::Add,
                d,
                n: d,
                m,
                flags: SetFlags::No,
            })
        }
        0b01 => {
            refuse_if(d.index() < 8 && m.index() < 8, Rule::BothLow)?;
            let pc = d == Register::PC || m == Register::PC;
            refuse_if(pc, Rule::StackPointerOrPc)?;
            anywhere(Instruction::CompareRegister {
                op: DataOp::Sub,
                n: d,
                m,
            })
        }
        0b10 if d == Register::PC => last(Instruction::MoveToPc { m }),
        0b10 => anywhere(Instruction::DataRegister {
            op: DataOp::Mov,
            d,
            n: d,
            m,
            flags: SetFlags::No,
        }),
        _ => {
            should_be(word, 0b111, 0)?;
            if !bit(word, 7) {
                return last(Instruction::BranchExchange { m });
            }
            refuse_if(m == Register::PC, Rule::StackPointerOrPc)?;
            last(Instruction::BranchLinkExchange { m })
        }
    }
}

/// SP plus or minus a number of words.
fn adjust_sp(op: DataOp, d: Register, words: u32) -> Table {
    anywhere(Instruction::DataImmediate {
        op,
        d,
        n: Register::SP,
        flags: SetFlags::No,
        carry: Carry::Keep,
        value: words * 4,
    })
}

/// A5.2.5: miscellaneous.
fn miscellaneous(word: u32) -> Table {
    match bits(word, 8, 4) {
        0b0000 => {
            let op = if bit(word, 7) {
                DataOp::Sub
            } else {
                DataOp::Add
            };
            adjust_sp(op, Register::SP, bits(word, 0, 7))
        }
        0b0001 | 0b0011 | 0b1001 | 0b1011 => outside(Instruction::CompareBranch {
            n: low(word, 0),
            zero: !bit(word, 11),
            offset: (bits(word, 9, 1) << 6 | bits(word, 3, 5) << 1) as u8,
        }),
        0b0010 => {
            let kind = match bits(word, 6, 2) {
                0 => Extend::SignedHalfWord,
                1 => Extend::SignedByte,
                2 => Extend::HalfWord,
                _ => Extend::Byte,
            };
            anywhere(Instruction::ExtendRegister {
                kind,
                d: low(word, 0),
                m: low(word, 3),
                rotation: 0,
            })
        }
        0b0100 | 0b0101 => push_pop(word, 14),
        0b0110 if bits(word, 5, 3) == 0b011 => change_state(word),
        0b1010 => {
            let kind = match bits(word, 6, 2) {
                0 => Rearrange::ReverseBytes,
                1 => Rearrange::ReverseBytesOfHalfWords,
                3 => Rearrange::ReverseSignedHalfWord,
                _ => return undefined(Rule::Unallocated),
            };
            anywhere(Instruction::RearrangeBits {
                kind,
                d: low(word, 0),
                m: low(word, 3),
            })
        }
        0b1100 | 0b1101 => push_pop(word, 15),
        0b1110 => anywhere(Instruction::Breakpoint(bits(word, 0, 8) as u8)),
        0b1111 if bits(word, 0, 4) != 0 => if_then(word),
        0b1111 => hint(bits(word, 4, 4)),
        _ => undefined(Rule::Unallocated),
    }
}

/// CPS (B5.2.1).
fn change_state(word: u32) -> Table {
    should_be(word, 0b1100, 0)?;
    refuse_if(bits(word, 0, 2) == 0, Rule::ChangesNothing)?;
    outside(Instruction::ChangeState {
        disable: bit(word, 4),
        primask: bit(word, 1),
        faultmask: bit(word, 0),
    })
}

/// IT (A7.7.38).
fn if_then(word: u32) -> Table {
    let (condition, mask) = (bits(word, 4, 4), bits(word, 0, 4));
    let always_with_else = condition == 0b1110 && mask.count_ones() != 1;
    refuse_if(condition == 0b1111 || always_with_else, Rule::ItCondition)?;
    outside(Instruction::IfThen {
        state: bits(word, 0, 8) as u8,
    })
}

/// Hints; unallocated hints do nothing.
pub fn hint(number: u32) -> Table {
    anywhere(match number {
        2 => Instruction::WaitForEvent,
        3 => Instruction::WaitForInterrupt,
        4 => Instruction::SendEvent,
        _ => Instruction::Nop,
    })
}

/// A5.2.6: conditional branch, UDF, SVC.
fn conditional(word: u32) -> Table {
    match bits(word, 8, 4) {
        0b1110 => undefined(Rule::PermanentlyUndefined),
        0b1111 => anywhere(Instruction::SupervisorCall),
        code => outside(Instruction::BranchIf {
            condition: Condition::from_code(code),
            offset: signed(bits(word, 0, 8) << 1, 9),
        }),
    }
}
