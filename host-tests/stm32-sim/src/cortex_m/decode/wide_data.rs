//! 32-bit data processing with an immediate or a shifted register (ARM ARM A5.3.1, A5.3.3, A5.3.11).

use super::instruction::{Carry, DataOp, Instruction, Register, SetFlags, Shift};
use super::rule::Rule;
use super::{
    Table, anywhere, bit, bits, refuse_if, refuse_sp_and_pc, register, should_be, undefined,
};

/// The second operand of a data-processing instruction.
#[derive(Clone, Copy)]
enum Operand {
    Immediate {
        value: u32,
        carry: Carry,
    },
    Shifted {
        m: Register,
        shift: Shift,
        amount: u8,
    },
}

impl Operand {
    /// True if it may change SP: an immediate, or a register shifted left by 0 to 3 (A7.7.6, A7.7.176).
    fn may_change_sp(self) -> bool {
        match self {
            Self::Immediate { .. } => true,
            Self::Shifted { shift, amount, .. } => shift == Shift::Lsl && amount <= 3,
        }
    }

    /// The instruction that writes a register.
    fn data(self, op: DataOp, d: Register, n: Register, flags: SetFlags) -> Table {
        anywhere(match self {
            Self::Immediate { value, carry } => Instruction::DataImmediate {
                op,
                d,
                n,
                flags,
                carry,
                value,
            },
            Self::Shifted {
                m,
                shift: Shift::Lsl,
                amount: 0,
            } => Instruction::DataRegister { op, d, n, m, flags },
            Self::Shifted { m, shift, amount } => Instruction::DataShifted {
                op,
                d,
                n,
                m,
                flags,
                shift,
                amount,
            },
        })
    }

    /// The instruction that only writes the flags.
    fn compare(self, op: DataOp, n: Register) -> Table {
        anywhere(match self {
            Self::Immediate { value, carry } => Instruction::CompareImmediate {
                op,
                n,
                carry,
                value,
            },
            Self::Shifted {
                m,
                shift: Shift::Lsl,
                amount: 0,
            } => Instruction::CompareRegister { op, n, m },
            Self::Shifted { m, shift, amount } => Instruction::CompareShifted {
                op,
                n,
                m,
                shift,
                amount,
            },
        })
    }
}

/// A5.3.1: a modified immediate.
pub fn modified_immediate(word: u32) -> Table {
    let (value, carry) =
        expand(bits(word, 26, 1) << 11 | bits(word, 12, 3) << 8 | bits(word, 0, 8))?;
    data_processing(word, Operand::Immediate { value, carry })
}

/// A5.3.11: a shifted register.
pub fn shifted_register(word: u32) -> Table {
    let m = register(word, 0);
    let amount = (bits(word, 12, 3) << 2 | bits(word, 6, 2)) as u8;
    let (shift, amount) = immediate_shift(bits(word, 4, 2), amount);
    let table = data_processing(word, Operand::Shifted { m, shift, amount });
    if matches!(table, Err(Instruction::Undefined(_))) {
        return table;
    }
    should_be(word, 1 << 15, 0)?;
    let plain_move = bits(word, 21, 4) == 0b0010
        && register(word, 16) == Register::PC
        && (shift, amount) == (Shift::Lsl, 0);
    if !plain_move {
        refuse_sp_and_pc(&[m])?;
    }
    table
}

/// Tables A5-10 and A5-22, which differ only in PKH.
fn data_processing(word: u32, operand: Operand) -> Table {
    let set = bit(word, 20);
    let (n, d) = (register(word, 16), register(word, 8));
    let flags = SetFlags::from_bit(set);
    let no_first = n == Register::PC;
    let no_result = d == Register::PC && set;
    let strict = |op| {
        refuse_sp_and_pc(&[d, n])?;
        operand.data(op, d, n, flags)
    };
    let compare_strict = |op| {
        refuse_sp_and_pc(&[n])?;
        operand.compare(op, n)
    };
    match bits(word, 21, 4) {
        0b0000 if no_result => compare_strict(DataOp::And),
        0b0000 => strict(DataOp::And),
        0b0001 => strict(DataOp::Bic),
        0b0010 if no_first => move_register(operand, d, flags),
        0b0010 => strict(DataOp::Orr),
        0b0011 if no_first => {
            refuse_sp_and_pc(&[d])?;
            operand.data(DataOp::Mvn, d, n, flags)
        }
        0b0011 => strict(DataOp::Orn),
        0b0100 if no_result => compare_strict(DataOp::Eor),
        0b0100 => strict(DataOp::Eor),
        0b0110 if matches!(operand, Operand::Shifted { .. }) => undefined(Rule::DspExtension),
        0b1000 => add_or_subtract(DataOp::Add, operand, d, n, set),
        0b1010 => strict(DataOp::Adc),
        0b1011 => strict(DataOp::Sbc),
        0b1101 => add_or_subtract(DataOp::Sub, operand, d, n, set),
        0b1110 => strict(DataOp::Rsb),
        _ => undefined(Rule::Unallocated),
    }
}

/// MOV: without flags, SP is permitted as one operand of a plain MOV (A7.7.77, T3).
fn move_register(operand: Operand, d: Register, flags: SetFlags) -> Table {
    match operand {
        Operand::Shifted {
            m,
            shift: Shift::Lsl,
            amount: 0,
        } => {
            let wrong = if flags == SetFlags::Yes {
                d.is_sp_or_pc() || m.is_sp_or_pc()
            } else {
                d == Register::PC || m == Register::PC || (d == Register::SP && m == Register::SP)
            };
            refuse_if(wrong, Rule::StackPointerOrPc)?;
        }
        _ => refuse_sp_and_pc(&[d])?,
    }
    operand.data(DataOp::Mov, d, d, flags)
}

/// ADD, SUB, CMN, CMP: these may also change SP, but only with SP as the first operand.
fn add_or_subtract(op: DataOp, operand: Operand, d: Register, n: Register, set: bool) -> Table {
    refuse_if(n == Register::PC, Rule::StackPointerOrPc)?;
    if d == Register::PC && set {
        return operand.compare(op, n);
    }
    refuse_if(d == Register::PC, Rule::StackPointerOrPc)?;
    if d == Register::SP {
        refuse_if(n != Register::SP, Rule::StackPointerOrPc)?;
        refuse_if(!operand.may_change_sp(), Rule::StackShift)?;
    }
    operand.data(op, d, n, SetFlags::from_bit(set))
}

/// A5.3.3: a plain immediate.
pub fn plain_immediate(word: u32) -> Table {
    let (n, d) = (register(word, 16), register(word, 8));
    let twelve = bits(word, 26, 1) << 11 | bits(word, 12, 3) << 8 | bits(word, 0, 8);
    let sixteen = (bits(word, 16, 4) << 12 | twelve) as u16;
    match bits(word, 20, 5) {
        0b00000 => add_plain(DataOp::Add, d, n, twelve),
        0b00100 => {
            refuse_sp_and_pc(&[d])?;
            anywhere(Instruction::DataImmediate {
                op: DataOp::Mov,
                d,
                n: d,
                flags: SetFlags::No,
                carry: Carry::Keep,
                value: sixteen.into(),
            })
        }
        0b01010 => add_plain(DataOp::Sub, d, n, twelve),
        0b01100 => {
            refuse_sp_and_pc(&[d])?;
            anywhere(Instruction::MoveTop { d, value: sixteen })
        }
        0b10000 | 0b10010 | 0b11000 | 0b11010 => saturate(word, d, n),
        0b10100 | 0b11100 => {
            should_be(word, 1 << 26 | 1 << 5, 0)?;
            refuse_sp_and_pc(&[d, n])?;
            let (lsb, width) = (low_bit(word), bits(word, 0, 5) as u8 + 1);
            refuse_if(lsb + width > 32, Rule::BitField)?;
            anywhere(Instruction::BitFieldExtract {
                signed: !bit(word, 23),
                d,
                n,
                lsb,
                width,
            })
        }
        0b10110 => insert(word, d, n),
        _ => undefined(Rule::Unallocated),
    }
}

/// ADDW and SUBW; with PC they are ADR.
fn add_plain(op: DataOp, d: Register, n: Register, value: u32) -> Table {
    if n == Register::PC {
        refuse_sp_and_pc(&[d])?;
        let offset = value as i32;
        let offset = if op == DataOp::Sub { -offset } else { offset };
        return anywhere(Instruction::Address { d, offset });
    }
    let sp_from_sp = d == Register::SP && n == Register::SP;
    refuse_if(d.is_sp_or_pc() && !sp_from_sp, Rule::StackPointerOrPc)?;
    anywhere(Instruction::DataImmediate {
        op,
        d,
        n,
        flags: SetFlags::No,
        carry: Carry::Keep,
        value,
    })
}

fn saturate(word: u32, d: Register, n: Register) -> Table {
    let amount = low_bit(word);
    let right = bit(word, 21);
    if right && amount == 0 {
        return undefined(Rule::DspExtension);
    }
    should_be(word, 1 << 26 | 1 << 5, 0)?;
    refuse_sp_and_pc(&[d, n])?;
    let signed = !bit(word, 23);
    anywhere(Instruction::Saturate {
        signed,
        d,
        n,
        bits: bits(word, 0, 5) as u8 + u8::from(signed),
        shift: if right { Shift::Asr } else { Shift::Lsl },
        amount,
    })
}

fn insert(word: u32, d: Register, n: Register) -> Table {
    should_be(word, 1 << 26 | 1 << 5, 0)?;
    refuse_sp_and_pc(&[d])?;
    refuse_if(n == Register::SP, Rule::StackPointerOrPc)?;
    let (lsb, msb) = (low_bit(word), bits(word, 0, 5) as u8);
    refuse_if(msb < lsb, Rule::BitField)?;
    let width = msb - lsb + 1;
    anywhere(if n == Register::PC {
        Instruction::BitFieldClear { d, lsb, width }
    } else {
        Instruction::BitFieldInsert { d, n, lsb, width }
    })
}

/// imm3:imm2.
fn low_bit(word: u32) -> u8 {
    (bits(word, 12, 3) << 2 | bits(word, 6, 2)) as u8
}

/// DecodeImmShift (A7.4.2).
fn immediate_shift(kind: u32, amount: u8) -> (Shift, u8) {
    match (kind, amount) {
        (0, amount) => (Shift::Lsl, amount),
        (1, 0) => (Shift::Lsr, 32),
        (1, amount) => (Shift::Lsr, amount),
        (2, 0) => (Shift::Asr, 32),
        (2, amount) => (Shift::Asr, amount),
        (_, 0) => (Shift::Rrx, 1),
        (_, amount) => (Shift::Ror, amount),
    }
}

/// ThumbExpandImm_C (A5.3.2).
fn expand(number: u32) -> Result<(u32, Carry), Instruction> {
    let byte = number & 0xFF;
    if number >> 10 != 0 {
        let value = (0x80 | number & 0x7F).rotate_right(number >> 7);
        let carry = if value >> 31 != 0 {
            Carry::Set
        } else {
            Carry::Clear
        };
        return Ok((value, carry));
    }
    refuse_if(number >> 8 != 0 && byte == 0, Rule::RepeatedZero)?;
    let value = match number >> 8 {
        0 => byte,
        1 => byte * 0x0001_0001,
        2 => byte * 0x0100_0100,
        _ => byte * 0x0101_0101,
    };
    Ok((value, Carry::Keep))
}
