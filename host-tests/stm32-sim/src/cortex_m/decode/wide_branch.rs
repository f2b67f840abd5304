//! 32-bit branches and miscellaneous control (ARM ARM A5.3.4 to A5.3.6).

use super::instruction::{Condition, Instruction, Register};
use super::rule::Rule;
use super::{
    Table, anywhere, bit, bits, last, narrow, outside, refuse_if, refuse_sp_and_pc, register,
    should_be, signed, undefined,
};

/// Decodes branches and miscellaneous control (table A5-13).
pub fn decode(word: u32) -> Table {
    match (bit(word, 14), bit(word, 12)) {
        (false, true) => last(Instruction::Branch { offset: far(word) }),
        (true, true) => last(Instruction::BranchLink { offset: far(word) }),
        // BLX with an immediate exists in the ARM state only.
        (true, false) => undefined(Rule::Unallocated),
        (false, false) if bits(word, 23, 3) != 0b111 => outside(Instruction::BranchIf {
            condition: Condition::from_code(bits(word, 22, 4)),
            offset: near(word),
        }),
        (false, false) => control(word),
    }
}

/// The offset of B T3.
fn near(word: u32) -> i32 {
    let offset = bits(word, 26, 1) << 20
        | bits(word, 11, 1) << 19
        | bits(word, 13, 1) << 18
        | bits(word, 16, 6) << 12
        | bits(word, 0, 11) << 1;
    signed(offset, 21)
}

/// The offset of B T4 and BL.
fn far(word: u32) -> i32 {
    let sign = bits(word, 26, 1);
    let i1 = 1 ^ sign ^ bits(word, 13, 1);
    let i2 = 1 ^ sign ^ bits(word, 11, 1);
    let offset =
        sign << 24 | i1 << 23 | i2 << 22 | bits(word, 16, 10) << 12 | bits(word, 0, 11) << 1;
    signed(offset, 25)
}

/// The encodings that are no branch: MSR, hints, barriers, MRS, UDF.
fn control(word: u32) -> Table {
    match bits(word, 20, 7) {
        0b011_1000 | 0b011_1001 => move_to_special(word),
        0b011_1010 => {
            if bits(word, 8, 3) != 0 {
                return undefined(Rule::Unallocated);
            }
            should_be(word, 0x000F_2800, 0x000F_0000)?;
            // DBG and unallocated hints do nothing. The numbers below 16 are those of the 16-bit hints.
            narrow::hint(bits(word, 0, 8))
        }
        0b011_1011 => {
            let instruction = match bits(word, 4, 4) {
                0b0010 => Instruction::ClearExclusive,
                option @ 0b0100..=0b0110 => Instruction::Barrier {
                    instructions: option == 0b0110,
                },
                _ => return undefined(Rule::Unallocated),
            };
            should_be(word, 0x000F_2F00, 0x000F_0F00)?;
            if instruction == Instruction::ClearExclusive {
                should_be(word, 0xF, 0xF)?;
            }
            anywhere(instruction)
        }
        0b011_1110 | 0b011_1111 => move_from_special(word),
        0b111_1111 => undefined(Rule::PermanentlyUndefined),
        _ => undefined(Rule::Unallocated),
    }
}

/// The numbers of special registers that exist (B5.2.2).
fn special(word: u32) -> Result<u8, Instruction> {
    let special = bits(word, 0, 8) as u8;
    let exists = matches!(special, 0..=3 | 5..=9 | 16..=20);
    refuse_if(!exists, Rule::SpecialRegister)?;
    Ok(special)
}

fn move_from_special(word: u32) -> Table {
    should_be(word, 0x001F_2000, 0x000F_0000)?;
    let d = register(word, 8);
    refuse_sp_and_pc(&[d])?;
    let special = special(word)?;
    anywhere(Instruction::MoveFromSpecial { d, special })
}

/// MSR. Mask bit 0 selects the GE bits of the DSP extension, bit 1 all others.
fn move_to_special(word: u32) -> Table {
    should_be(word, 0x0010_2300, 0)?;
    let n: Register = register(word, 16);
    refuse_sp_and_pc(&[n])?;
    refuse_if(bits(word, 10, 2) != 0b10, Rule::SpecialMask)?;
    let special = special(word)?;
    anywhere(Instruction::MoveToSpecial { n, special })
}
