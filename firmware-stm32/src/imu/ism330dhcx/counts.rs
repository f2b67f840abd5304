//! Conversion of the data in the FIFO of the ISM330DHCX.
//!
//! ```text
//!  byte 0         1            3                 byte 0         1     2                           8
//!       +---------+------------+                      +---------+-----+---------------------------+
//!       | address | FIFO_      |                      | address | tag | acceleration X, Y, Z: i16 |
//!       | byte    | STATUS 3Ah |                      | byte    | 78h | or rate X, Y, Z: i16      |
//!       |         |            |                      |         |     | or temperature: i16, 0, 0 |
//!       +---------+------------+                      +---------+-----+---------------------------+
//! ```
//!
//! Bits 0 to 9 of FIFO_STATUS are the number of words in the FIFO. Bits 3 to 7 of the tag are the sensor.
//!
//! Acceleration at +-8 g: 244 ug per count (datasheet, LA_So). With 1 g = 2^26 that is 244e-6 * 2^26 = 16374.562816 units per
//! count. From counts with 14 fractional bits it is calculated as 1 - 2473901 / 2^32 units; the error is below 2 units (30 ng).
//! Angular rate at +-1000 deg/s: 35 mdps per count (datasheet, G_So). With 1 deg/s = 2^16 that is 2293.76 units per count.
//! Temperature: 256 counts per degree, 0 at 25 degC.
//!
//! Data rate: the nominal 6667 Hz / 8, changed by 0.15 % for each unit of INTERNAL_FREQ_FINE (AN5398, "Timestamp and FIFO").

use crate::imu::mounting::{Mounting, mounted};
use plumbline::measure::I32x3;

/// The number of bytes in the transfer of a word: the address byte, the tag and the data.
pub const WORD: usize = 1 + 7;

/// The number of words that the FIFO holds (datasheet: 3 kbyte of six data bytes each).
const FIFO_WORDS: u16 = 512;

/// The tags of angular rate, acceleration and temperature.
const TAG_RATE: u8 = 0x01;
const TAG_ACCELERATION: u8 = 0x02;
const TAG_TEMPERATURE: u8 = 0x03;

/// A word of the FIFO.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Word {
    /// An acceleration in counts.
    Acceleration([i16; 3]),
    /// A temperature in counts.
    Temperature(i16),
    /// Neither: the FIFO is empty, or the accelerometer has failed.
    Other,
}

/// The number of words in the FIFO, from the two bytes of FIFO_STATUS. None if they are not those of a working accelerometer: a line that is
/// stuck at 1 reads as FFh.
pub const fn level(status: [u8; 2]) -> Option<u16> {
    // Bit 10 is always 0.
    let [low, high] = status;
    let words = u16::from_le_bytes([low, high & 0b111]);
    if words <= FIFO_WORDS {
        Some(words)
    } else {
        None
    }
}

/// Whether the FIFO has lost values since its last word was read, from the two bytes of FIFO_STATUS (FIFO_OVR_IA).
pub const fn has_lost(status: [u8; 2]) -> bool {
    let [_, high] = status;
    matches!(level(status), Some(1..)) && high & 1 << 6 != 0
}

/// The data rate in mHz for the value of INTERNAL_FREQ_FINE.
pub const fn data_rate(fine: i8) -> u32 {
    // 6667 Hz / 8 = 833375 mHz, and 0.15 % of it.
    const NOMINAL: i32 = 6_667_000 / 8;
    const UNIT: i32 = 1250;
    (NOMINAL + fine as i32 * UNIT) as u32
}

/// The word in the bytes of a transfer.
#[inline]
pub fn word(bytes: &[u8; WORD]) -> Word {
    let &[_, tag, x0, x1, y0, y1, z0, z1] = bytes;
    let x = i16::from_le_bytes([x0, x1]);
    match tag >> 3 {
        TAG_ACCELERATION => {
            let y = i16::from_le_bytes([y0, y1]);
            let z = i16::from_le_bytes([z0, z1]);
            Word::Acceleration([x, y, z])
        }
        TAG_TEMPERATURE => Word::Temperature(x),
        _ => Word::Other,
    }
}

/// The angular rate in counts, if the bytes of a transfer are a word of the gyroscope.
pub fn rate_word(bytes: &[u8; WORD]) -> Option<[i32; 3]> {
    let &[_, tag, x0, x1, y0, y1, z0, z1] = bytes;
    let counts = [[x0, x1], [y0, y1], [z0, z1]];
    (tag >> 3 == TAG_RATE).then(|| counts.map(|count| i16::from_le_bytes(count).into()))
}

/// Whether an axis is at the limit of its range.
pub fn is_clipped(counts: [i32; 3]) -> bool {
    counts.iter().any(|count| count.abs() >= 0x7FFF)
}

/// The largest step between two values at rest, for [`Values`](crate::imu::values::Values): 16 mg. The noise is 5
/// counts (60 ug/rtHz).
pub const FLOOR: i32 = 64;

/// The number of bits of a value, for [`Values`](crate::imu::values::Values).
pub const WIDTH: u32 = 16;

/// The largest step between two temperatures in counts: 1 degC in 19 ms. A larger one is an error of the line.
pub const TEMPERATURE_STEP: u16 = 256;

/// The number of fractional bits of the counts in [`acceleration`].
pub const FRACTION: u32 = 14;

/// Counts with [`FRACTION`] fractional bits in units of 2^-26 g.
const fn units(counts: i32) -> i32 {
    counts - ((counts as i64 * 2_473_901) >> 32) as i32
}

/// A count of temperature in 0.01 degC. The difference from 25 degC is rounded towards 0.
pub const fn temperature(count: i16) -> i16 {
    // 100 / 256 = 25 / 64; the result is within -10300..=15299.
    (2500 + count as i32 * 25 / 64) as i16
}

/// The acceleration along the axes of the sensor, 1 g = 2^26, of counts with [`FRACTION`] fractional bits.
pub fn acceleration(counts: I32x3, mounting: Mounting) -> I32x3 {
    mounted(counts, mounting, units)
}

/// The angular rate about the axes of the sensor, 1 deg/s = 2^16, of counts with [`FRACTION`] fractional bits.
pub fn angular_rate(counts: I32x3, mounting: Mounting) -> I32x3 {
    mounted(counts, mounting, rate_units)
}

/// Counts of the gyroscope with [`FRACTION`] fractional bits in units of 2^-16 deg/s: 2293.76 / 2^14 = 9175.04 / 2^16.
const fn rate_units(counts: i32) -> i32 {
    ((counts as i64 * 9175) >> 16) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::mounting::Axis;
    use plumbline::measure::ONE_G;

    #[test]
    fn acceleration_is_within_two_units_of_244_micro_g_per_count() {
        for count in i16::MIN..=i16::MAX {
            for fraction in [0, 1, 8191, 16383] {
                let counts = (i32::from(count) << FRACTION) + fraction;
                // counts * 244e-6 * 2^26 / 2^14, exactly, in millionths of a unit
                let exact = i128::from(counts) * 244 * i128::from(ONE_G) / (1 << FRACTION);
                let error = i128::from(units(counts)) * 1_000_000 - exact;
                assert!(error.abs() <= 2_000_000, "{count} {fraction}: {error}");
            }
        }
    }

    #[test]
    fn one_g_is_4098_counts() {
        // 1 / 244e-6 = 4098.4
        assert!(units(4098 << FRACTION) < ONE_G && units(4099 << FRACTION) > ONE_G);
    }

    #[test]
    fn temperature_has_256_counts_per_degree_from_25() {
        assert_eq!(temperature(0), 2500);
        assert_eq!(temperature(256), 2600);
        assert_eq!(temperature(-25 * 256), 0);
        assert_eq!(temperature(-65 * 256), -4000);
        assert_eq!(temperature(i16::MAX), 15299);
        assert_eq!(temperature(i16::MIN), -10300);
    }

    #[test]
    fn data_rate_changes_by_0_15_percent_per_unit() {
        assert_eq!(data_rate(0), 833_375);
        for fine in i8::MIN..=i8::MAX {
            let exact = 833_375.0 * (1.0 + 0.0015 * f64::from(fine));
            let error = f64::from(data_rate(fine)) / exact - 1.0;
            assert!(error.abs() < 2e-5, "{fine}: {error}");
        }
    }

    #[test]
    fn level_is_number_of_words_and_none_on_a_line_stuck_at_1() {
        assert_eq!(level([0x00, 0x00]), Some(0));
        assert_eq!(level([0x05, 0x00]), Some(5));
        assert_eq!(level([0xFF, 0x01]), Some(511));
        // Full, with the flags FIFO_OVR_IA and FIFO_FULL_IA.
        assert_eq!(level([0x00, 0x62]), Some(512));
        assert_eq!(level([0xFF, 0xFF]), None);
    }

    #[test]
    fn values_are_lost_with_the_overrun_flag() {
        assert!(has_lost([0x00, 0x4A]));
        assert!(!has_lost([0x00, 0x22]), "full, without an overrun");
        assert!(!has_lost([0xFF, 0xFF]), "a stuck bus");
        assert!(!has_lost([0x05, 0x00]));
    }

    /// A transfer of a word with this tag.
    const fn transfer(tag: u8, data: [u8; 6]) -> [u8; WORD] {
        let [x0, x1, y0, y1, z0, z1] = data;
        [0xFF, tag, x0, x1, y0, y1, z0, z1]
    }

    #[test]
    fn word_matches_byte_map() {
        // Bits 0 to 2 of the tag are a counter and the parity.
        for low in 0..8 {
            let data = [0x34, 0x12, 0xFE, 0xFF, 0x00, 0x80];
            let counts = [0x1234, -2, -0x8000];
            let read = word(&transfer(0x02 << 3 | low, data));
            assert_eq!(read, Word::Acceleration(counts));
            let read = word(&transfer(0x03 << 3 | low, [0x00, 0x01, 0, 0, 0, 0]));
            assert_eq!(read, Word::Temperature(256));
        }
    }

    #[test]
    fn word_of_another_sensor_is_ignored() {
        for sensor in (0..32).filter(|sensor| ![2, 3].contains(sensor)) {
            let read = word(&transfer(sensor << 3, [0xFF; 6]));
            assert_eq!(read, Word::Other, "{sensor:02X}h");
        }
    }

    #[test]
    fn rate_word_has_tag_1() {
        let data = [0x34, 0x12, 0xFE, 0xFF, 0x00, 0x80];
        for low in 0..8 {
            let counts = [0x1234, -2, -0x8000];
            assert_eq!(rate_word(&transfer(0x01 << 3 | low, data)), Some(counts));
        }
        for sensor in (0..32).filter(|sensor| *sensor != 1) {
            assert_eq!(rate_word(&transfer(sensor << 3, data)), None);
        }
    }

    #[test]
    fn rate_has_35_mdps_per_count() {
        let rate = |count: i32| {
            let counts = I32x3 {
                x: count << FRACTION,
                y: 0,
                z: -(count << FRACTION),
            };
            angular_rate(counts, Mounting([Axis::X, Axis::NegativeZ, Axis::Y]))
        };
        for count in [1, 100, 28_571, 32_767] {
            let exact = f64::from(count) * 0.035 * 65_536.0;
            let I32x3 { x, y, z } = rate(count);
            assert!((f64::from(x) / exact - 1.0).abs() < 1e-3 / f64::from(count) + 5e-6);
            // The result is rounded down, also of a negative count.
            assert!((y - x).abs() <= 1 && z == 0, "{x} {y} {z}");
        }
    }

    #[test]
    fn only_limits_of_range_are_clipped() {
        assert!(!is_clipped([0x7FFE, -0x7FFE, 0]));
        assert!(is_clipped([0x7FFF, 0, 0]));
        assert!(is_clipped([0, -0x7FFF, 0]));
        assert!(is_clipped([0, 0, -0x8000]));
    }
}
