//! Comparison of an object dictionary with the tables of a manual.

use super::Tester;
use super::canopen::{abort, write_request};
use super::sweep::every;
use plumbline::node::Node;

const READ_ONLY: u32 = 0x0601_0002;
const WRITE_ONLY: u32 = 0x0601_0001;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const NO_OBJECT: u32 = 0x0602_0000;
const TOO_LONG: u32 = 0x0607_0012;
const TOO_SHORT: u32 = 0x0607_0013;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const REFUSED: std::ops::RangeInclusive<u32> = 0x0609_0030..=0x0609_0032;

/// The access of an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Access {
    /// A master can only read it.
    Ro,
    /// A setting: accepts what is read from it.
    Rw,
    /// A part of a fixed mapping: accepts its own value.
    Fixed,
    /// A read-only COB-ID: accepts its own value.
    Own,
    /// A write does more than change the value.
    Command,
    /// A command that cannot be read.
    Wo,
}

/// A row of a manual's table: index, sub-index, size in bytes (0: a text), access, and the value as delivered or [`MEASURED`].
pub type Row = (u16, u8, u8, Access, u32);

/// In place of a value that is measured.
pub const MEASURED: u32 = u32::MAX;

/// The values of a setting.
pub struct Values {
    pub index: u16,
    pub sub: u8,
    pub size: u8,
    /// The values that are written: both sides of each limit.
    pub tried: &'static [std::ops::RangeInclusive<u32>],
    /// Whether a number is accepted by a write.
    pub accepted: fn(u32) -> bool,
}

/// Each value of a byte.
pub const BYTE: &[std::ops::RangeInclusive<u32>] = &[0..=255];
/// The values of two bytes.
pub const WORD: &[std::ops::RangeInclusive<u32>] = &[0..=1100, 1101..=65_533, 65_534..=65_535];

/// The values of a range; of a long one only some.
fn thinned(range: &std::ops::RangeInclusive<u32>) -> impl Iterator<Item = u32> + use<> {
    let is_long = range.end() - range.start() > 0x1000;
    range.clone().step_by(if is_long { every(97) } else { 1 })
}

fn begin_read(index: u16, sub: u8) -> String {
    let [low, high] = index.to_le_bytes();
    format!("40{low:02X}{high:02X}{sub:02X}00000000")
}

fn object(index: u16, sub: u8) -> String {
    let [low, high] = index.to_le_bytes();
    format!("{low:02X}{high:02X}{sub:02X}")
}

impl<N: Node> Tester<N> {
    /// Reads each object: type and value as delivered.
    pub fn assert_dictionary(&mut self, rows: &[Row]) {
        for &(index, sub, size, access, value) in rows {
            let name = format!("{index:04X}h:{sub:02X}");
            if access == Access::Wo {
                assert_eq!(self.read(index, sub), Err(WRITE_ONLY), "{name}");
            } else if size > 0 {
                let [a, b, c, d] = value.to_le_bytes();
                let expected = format!(
                    "{:02X}{}{a:02X}{b:02X}{c:02X}{d:02X}",
                    0x43 | (4 - size) << 2,
                    object(index, sub)
                );
                let compared = if value == MEASURED { 8 } else { 16 };
                let reply = self.sdo(&begin_read(index, sub));
                assert_eq!(reply[..compared], expected[..compared], "{name}");
            }
        }
    }

    /// A read-only object refuses each write, a fixed one each other value. A setting accepts its own value. Nothing changes.
    pub fn assert_access(&mut self, rows: &[Row]) {
        for &(index, sub, size, access, _) in rows {
            let name = format!("{index:04X}h:{sub:02X}");
            let length = if size == 0 { 4 } else { size };
            let value = if size > 0 && access != Access::Wo {
                self.read(index, sub).unwrap()
            } else {
                0
            };
            match access {
                Access::Ro => {
                    for written in [value, value ^ 1] {
                        let refused = self.write(index, sub, length, written);
                        assert_eq!(refused, Err(READ_ONLY), "{name}");
                    }
                    let announced = format!("21{}{length:02X}000000", object(index, sub));
                    let expected = abort(&object(index, sub), READ_ONLY);
                    assert_eq!(self.sdo(&announced), expected, "{name} in segments");
                }
                Access::Fixed => {
                    assert_eq!(self.write(index, sub, size, value), Ok(()), "{name}");
                    let refused = self.write(index, sub, size, value ^ 1);
                    assert_eq!(refused, Err(NOT_MAPPABLE), "{name}");
                }
                Access::Own => {
                    assert_eq!(self.write(index, sub, size, value), Ok(()), "{name}");
                    for written in [value ^ 1, value | 0x8000_0000, value | 0x4000_0000] {
                        let refused = self.write(index, sub, size, written);
                        assert_eq!(refused, Err(READ_ONLY), "{name}");
                    }
                }
                Access::Rw => {
                    assert_eq!(self.write(index, sub, size, value), Ok(()), "{name}");
                }
                Access::Command | Access::Wo => {}
            }
            if size > 0 && access != Access::Wo {
                assert_eq!(self.read(index, sub), Ok(value), "{name}");
            }
        }
    }

    /// An object that can be written refuses data of each other length: expedited, in segments with and without the length.
    pub fn assert_lengths(&mut self, rows: &[Row]) {
        for &(index, sub, size, access, _) in rows {
            if size == 0 || matches!(access, Access::Ro | Access::Fixed) {
                continue;
            }
            let object = object(index, sub);
            let before = self.read(index, sub);
            for length in 1..=4 {
                let code = match length.cmp(&size) {
                    std::cmp::Ordering::Less => TOO_SHORT,
                    std::cmp::Ordering::Equal => continue,
                    std::cmp::Ordering::Greater => TOO_LONG,
                };
                let refused = self.write(index, sub, length, 0);
                assert_eq!(refused, Err(code), "{object} {length}");
                let announced = format!("21{object}{length:02X}000000");
                assert_eq!(self.sdo(&announced), abort(&object, code), "{object}");
            }
            let begun = format!("60{object}00000000");
            assert_eq!(self.sdo(&format!("20{object}00000000")), begun);
            let nothing = self.sdo("0F00000000000000");
            assert_eq!(nothing, abort(&object, TOO_SHORT), "0 bytes");
            assert_eq!(self.sdo(&format!("20{object}00000000")), begun);
            let seven = self.sdo("0100000000000000");
            assert_eq!(seven, abort(&object, TOO_LONG), "7 bytes");
            assert_eq!(self.read(index, sub), before, "{object}");
        }
    }

    /// There is no object and no sub-index that the rows have not.
    pub fn assert_no_other(&mut self, rows: &[Row]) {
        let near = rows.iter().flat_map(|row| row.0 - 1..=row.0 + 1);
        for index in near.chain((0..=0xFFFF).step_by(every(61))) {
            if rows.iter().any(|row| row.0 == index) {
                continue;
            }
            assert_eq!(self.read(index, 0), Err(NO_OBJECT), "{index:04X}h");
            assert_eq!(self.write(index, 0, 1, 0), Err(NO_OBJECT), "{index:04X}h");
        }
        let mut indices: Vec<_> = rows.iter().map(|row| row.0).collect();
        indices.dedup();
        for index in indices {
            for sub in 0..=255 {
                if !rows.iter().any(|row| (row.0, row.1) == (index, sub)) {
                    let name = format!("{index:04X}h:{sub:02X}");
                    assert_eq!(self.read(index, sub), Err(NO_SUB_INDEX), "{name}");
                    let written = self.write(index, sub, 1, 0);
                    assert_eq!(written, Err(NO_SUB_INDEX), "{name}");
                }
            }
        }
    }

    /// A setting accepts exactly these values. A refused value changes nothing. The value before is written back.
    pub fn assert_values(&mut self, values: &[Values]) {
        for values in values {
            let Values {
                index, sub, size, ..
            } = *values;
            let name = format!("{index:04X}h:{sub:02X}");
            let delivered = self.read(index, sub).unwrap();
            let mut present = delivered;
            for value in values.tried.iter().flat_map(thinned) {
                let written = self.write(index, sub, size, value);
                if (values.accepted)(value) {
                    assert_eq!(written, Ok(()), "{name} = {value}");
                    present = value;
                } else {
                    let refused = written.is_err_and(|code| REFUSED.contains(&code));
                    assert!(refused, "{name} = {value}: {written:X?}");
                }
                assert_eq!(self.read(index, sub), Ok(present), "{name} = {value}");
            }
            assert_eq!(self.write(index, sub, size, delivered), Ok(()), "{name}");
        }
    }

    /// A command refuses each other value, and does nothing.
    pub fn assert_refused(&mut self, index: u16, sub: u8, size: u8, values: &[u32], code: u32) {
        let [low, high] = index.to_le_bytes();
        for &value in values {
            let request = write_request(index, sub, size, value);
            let expected = abort(&format!("{low:02X}{high:02X}{sub:02X}"), code);
            assert_eq!(self.sdo(&request), expected, "{index:04X}h = {value:X}h");
        }
    }
}
