//! Decodes half-words to instructions: a pure function, which also detects forbidden encodings and the rule for each.
//!
//! The tables are those of chapter A5 of the ARM ARM (ARMv7-M Architecture Reference Manual, DDI 0403E), one function per table;
//! the conditions on registers are from the page of the instruction in A7.7.

pub mod dsp;
pub mod instruction;
pub mod rule;

mod narrow;
mod narrow_load_store;
mod operand;
mod wide;
mod wide_branch;
mod wide_data;
mod wide_load_store;
mod wide_register;

use instruction::{Decoded, Instruction, ItRule, Register};
use rule::Rule;

/// True when a half-word is the first of two (A5.1).
pub const fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// Decodes the instruction that starts with this half-word; `second` is used only if [`is_wide`].
pub fn decode(first: u16, second: u16) -> Decoded {
    let (length, result) = if is_wide(first) {
        let word = u32::from(first) << 16 | u32::from(second);
        (4, wide::decode(word))
    } else {
        (2, narrow::decode(u32::from(first)))
    };
    let (instruction, it) = match result {
        Ok(plain) => (plain.instruction, plain.it),
        Err(refused) => (refused, ItRule::Anywhere),
    };
    Decoded {
        instruction,
        length,
        it,
    }
}

/// A table entry: an instruction and its permitted position in an IT block.
struct Plain {
    instruction: Instruction,
    it: ItRule,
}

/// Forbidden encodings are returned as errors, so that conditions can be checked with `?`.
type Table = Result<Plain, Instruction>;

/// An instruction that is permitted at any position.
const fn anywhere(instruction: Instruction) -> Table {
    Ok(Plain {
        instruction,
        it: ItRule::Anywhere,
    })
}

/// A branch: in an IT block only as the last instruction.
const fn last(instruction: Instruction) -> Table {
    Ok(Plain {
        instruction,
        it: ItRule::Last,
    })
}

/// An instruction that is not permitted in an IT block.
const fn outside(instruction: Instruction) -> Table {
    Ok(Plain {
        instruction,
        it: ItRule::Outside,
    })
}

/// An UNDEFINED encoding.
const fn undefined<T>(rule: Rule) -> Result<T, Instruction> {
    Err(Instruction::Undefined(rule))
}

/// UNPREDICTABLE if `wrong`.
const fn refuse_if(wrong: bool, rule: Rule) -> Result<(), Instruction> {
    if wrong {
        Err(Instruction::Unpredictable(rule))
    } else {
        Ok(())
    }
}

/// UNPREDICTABLE if one of these is SP or PC.
fn refuse_sp_and_pc(registers: &[Register]) -> Result<(), Instruction> {
    let wrong = registers.iter().any(|register| register.is_sp_or_pc());
    refuse_if(wrong, Rule::StackPointerOrPc)
}

/// UNPREDICTABLE unless the bits under the mask, those in parentheses, have this value.
const fn should_be(word: u32, mask: u32, value: u32) -> Result<(), Instruction> {
    refuse_if(word & mask != value, Rule::ShouldBe)
}

/// `count` bits starting at bit `low`.
const fn bits(word: u32, low: u32, count: u32) -> u32 {
    word >> low & ((1 << count) - 1)
}

const fn bit(word: u32, index: u32) -> bool {
    word >> index & 1 != 0
}

/// The register with the number in the four bits starting at `low`.
const fn register(word: u32, low: u32) -> Register {
    Register::new(word >> low)
}

/// A number of `count` bits, sign-extended.
const fn signed(value: u32, count: u32) -> i32 {
    ((value << (32 - count)) as i32) >> (32 - count)
}
