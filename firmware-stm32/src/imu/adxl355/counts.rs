//! Conversion of the data of the ADXL355.
//!
//! ```text
//!  byte 0         1         4         7         10            byte 0         1        2         3          5
//!       +---------+---------+---------+---------+                 +---------+--------+---------+----------+
//!       | address | X       | Y       | Z       |                 | address | STATUS | FIFO_   | TEMP2,   |
//!       | byte    | 3 bytes | 3 bytes | 3 bytes |                 | byte    | 04h    | ENTRIES | TEMP1    |
//!       +---------+---------+---------+---------+                 +---------+--------+---------+----------+
//! ```
//!
//! An entry of the FIFO has 20 bits, left-justified, high byte first. Bit 0 marks an X, bit 1 an entry from an empty FIFO.
//!
//! Acceleration at +-8 g: 64000 counts per g. Here a count has 8 fractional bits, so 1 g = 16384000, and in units of 2^-26 g it is
//! multiplied by 4.096.
//! Temperature: 1885 counts at 25 degC, -9.05 counts per degree.

use crate::imu::mounting::{Mounting, mounted};
use plumbline::measure::I32x3;

/// The number of bytes in the transfer of a value.
pub const VALUE: usize = 1 + 9;

/// The number of bytes in the transfer of the state: STATUS to TEMP1.
pub const STATE: usize = 1 + 4;

/// The number of entries that the FIFO holds.
const FIFO_ENTRIES: u8 = 96;

/// The largest step between two values at rest, for [`Values`](crate::imu::values::Values): 4 mg. The noise is 23 counts.
pub const FLOOR: i32 = 256 << 8;

/// The number of bits of a value with its fractional bits, for [`Values`](crate::imu::values::Values).
pub const WIDTH: u32 = 28;

/// Bits of STATUS.
const FIFO_OVERRUN: u8 = 1 << 2;
const NVM_BUSY: u8 = 1 << 4;

/// Bits of an entry.
const IS_X: u8 = 1 << 0;
const IS_EMPTY: u8 = 1 << 1;

/// The entries of a value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Value {
    /// An acceleration in counts with 8 fractional bits.
    Acceleration([i32; 3]),
    /// The FIFO was empty.
    Empty,
    /// The entries are not X, Y, Z in this order.
    Misplaced,
}

/// The value in the bytes of a transfer.
pub fn value(bytes: &[u8; VALUE]) -> Value {
    let &[_, x2, x1, x0, y2, y1, y0, z2, z1, z0] = bytes;
    if (x0 | y0 | z0) & IS_EMPTY != 0 {
        return Value::Empty;
    }
    if [x0, y0, z0].map(|low| low & IS_X) != [IS_X, 0, 0] {
        return Value::Misplaced;
    }
    let count = |high, middle, low| i32::from_be_bytes([high, middle, low & 0xF0, 0]) >> 4;
    Value::Acceleration([count(x2, x1, x0), count(y2, y1, y0), count(z2, z1, z0)])
}

/// The number of complete values in the FIFO. None if FIFO_ENTRIES is not that of a working part: a line that is stuck at 1 reads as FFh.
pub const fn level(state: &[u8; STATE]) -> Option<u8> {
    let &[_, _, entries, _, _] = state;
    if entries <= FIFO_ENTRIES {
        Some(entries / 3)
    } else {
        None
    }
}

/// Whether the FIFO has lost values since STATUS was read.
pub const fn has_lost(state: &[u8; STATE]) -> bool {
    let &[_, status, _, _, _] = state;
    matches!(level(state), Some(1..)) && status & FIFO_OVERRUN != 0
}

/// Whether the part loads its trimming.
pub const fn is_loading(state: &[u8; STATE]) -> bool {
    let &[_, status, _, _, _] = state;
    status & NVM_BUSY != 0
}

/// The counts of the temperature.
pub const fn temperature_counts(state: &[u8; STATE]) -> u16 {
    let &[_, _, _, high, low] = state;
    u16::from_be_bytes([high & 0x0F, low])
}

/// Counts of the temperature in 0.01 degC. The difference from 25 degC is rounded towards 0.
pub const fn temperature(counts: u16) -> i16 {
    // 100 / 9.05 = 2000 / 181; the result is within -21920..=23328.
    let counts = (counts & 0x0FFF) as i32;
    (2500 + (1885 - counts) * 2000 / 181) as i16
}

/// Whether an axis is beyond the range of +-8 g.
pub fn is_clipped(counts: [i32; 3]) -> bool {
    const LIMIT: u32 = 8 * 16_384_000;
    counts.iter().any(|count| count.unsigned_abs() >= LIMIT)
}

/// Counts with 8 fractional bits in units of 2^-26 g.
const fn units(counts: i32) -> i32 {
    // 4.096 * 2^28, with an error of 2e-10.
    const SCALE: i64 = 1_099_511_628;
    ((counts as i64 * SCALE) >> 28) as i32
}

/// The acceleration along the axes of the sensor, 1 g = 2^26.
pub fn acceleration(counts: I32x3, mounting: Mounting) -> I32x3 {
    mounted(counts, mounting, units)
}

/// The data rate in mHz of a part that has measured `values` in this time in us; None if it is more than 10 % away from 1000 Hz.
pub const fn data_rate(values: u32, micros: u32) -> Option<u32> {
    let Some(rate) = (values as u64 * 1_000_000_000).checked_div(micros as u64) else {
        return None;
    };
    match rate {
        900_000..=1_100_000 => Some(rate as u32),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::measure::ONE_G;

    #[test]
    fn value_matches_byte_map() {
        let bytes = [0xFF, 0x12, 0x34, 0x51, 0xFF, 0xFF, 0xF0, 0x80, 0x00, 0x00];
        let expected = [0x12345 << 8, -1 << 8, -0x80000 << 8];
        assert_eq!(value(&bytes), Value::Acceleration(expected));
        let bytes = [0xFF, 0x7F, 0xFF, 0xF1, 0x00, 0x00, 0x10, 0x00, 0x00, 0x00];
        assert_eq!(
            value(&bytes),
            Value::Acceleration([0x7FFFF << 8, 1 << 8, 0])
        );
    }

    #[test]
    fn entries_without_data_or_in_another_order_are_no_value() {
        let with = |low: [u8; 3]| {
            let [x, y, z] = low;
            value(&[0, 0, 0, x, 0, 0, y, 0, 0, z])
        };
        for low in [[3, 0, 0], [1, 2, 0], [1, 0, 2], [3, 2, 2]] {
            assert_eq!(with(low), Value::Empty, "{low:?}");
        }
        for low in [[0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1]] {
            assert_eq!(with(low), Value::Misplaced, "{low:?}");
        }
        assert_eq!(value(&[0xFF; VALUE]), Value::Empty, "a stuck bus");
        assert_eq!(value(&[0x00; VALUE]), Value::Misplaced, "a stuck bus");
    }

    #[test]
    fn level_counts_complete_values_and_is_none_on_a_line_stuck_at_1() {
        for (entries, expected) in [(0, 0), (2, 0), (3, 1), (5, 1), (96, 32)] {
            assert_eq!(level(&[0, 0, entries, 0, 0]), Some(expected), "{entries}");
        }
        assert_eq!(
            [97, 255].map(|entries| level(&[0, 0, entries, 0, 0])),
            [None; 2]
        );
    }

    #[test]
    fn values_are_lost_with_the_overrun_flag() {
        assert!(has_lost(&[0, 0b111, 96, 0, 0]));
        assert!(!has_lost(&[0, 0b011, 96, 0, 0]), "full, without an overrun");
        assert!(!has_lost(&[0xFF; STATE]), "a stuck bus");
        assert!(is_loading(&[0, 1 << 4, 0, 0, 0]) && !is_loading(&[0, 0xEF, 0, 0, 0]));
    }

    #[test]
    fn temperature_has_minus_9_05_counts_per_degree_from_1885() {
        assert_eq!(temperature(1885), 2500);
        assert_eq!(temperature(1885 - 181), 4500);
        assert_eq!(temperature(1885 + 362), -1500);
        assert_eq!(
            temperature(temperature_counts(&[0, 0, 0, 0xF7, 0x5D])),
            2500
        );
        assert_eq!((temperature(0), temperature(0x0FFF)), (23_328, -21_919));
    }

    #[test]
    fn acceleration_is_within_two_units_of_64000_counts_per_g() {
        for count in (-524_288..524_288).step_by(7) {
            let exact = i64::from(count) * i64::from(ONE_G) / 64_000;
            let error = i64::from(units(count << 8)) - exact;
            assert!(error.abs() <= 2, "{count}: {error}");
        }
    }

    #[test]
    fn only_values_beyond_8_g_are_clipped() {
        assert!(!is_clipped([511_999 << 8, -511_999 << 8, 0]));
        assert!(is_clipped([512_000 << 8, 0, 0]));
        assert!(is_clipped([0, -0x80000 << 8, 0]));
    }

    #[test]
    fn data_rate_is_the_number_of_values_in_a_second() {
        assert_eq!(data_rate(1280, 1_280_000), Some(1_000_000));
        assert_eq!(data_rate(1216, 1_280_000), Some(950_000));
        for (values, micros) in [(0, 0), (1280, 0), (0, 1_280_000), (2000, 1_280_000)] {
            assert_eq!(data_rate(values, micros), None, "{values} {micros}");
        }
    }
}
