//! 32-bit instructions (ARM ARM A5.3): selects the table. The first half-word is in the high bits.

use super::rule::Rule;
use super::{Table, bit, bits, undefined};
use super::{wide_branch, wide_data, wide_load_store, wide_register};

/// Decodes an instruction of 32 bits (table A5-9).
pub fn decode(word: u32) -> Table {
    let op2 = bits(word, 20, 7);
    match (bits(word, 27, 2), op2 >> 5) {
        (0b01, 0b00) if op2 & 0b100 == 0 => wide_load_store::multiple(word),
        (0b01, 0b00) => wide_load_store::dual_or_exclusive(word),
        (0b01, 0b01) => wide_data::shifted_register(word),
        (0b10, _) if bit(word, 15) => wide_branch::decode(word),
        (0b10, _) if bit(word, 25) => wide_data::plain_immediate(word),
        (0b10, _) => wide_data::modified_immediate(word),
        (0b11, 0b00) => wide_load_store::single(word),
        (0b11, 0b01) if op2 & 0b11_0000 == 0b10_0000 => wide_register::data_processing(word),
        (0b11, 0b01) if op2 & 0b11_1000 == 0b11_0000 => wide_register::multiply(word),
        (0b11, 0b01) => wide_register::long_multiply(word),
        _ => undefined(Rule::NoCoprocessor),
    }
}
