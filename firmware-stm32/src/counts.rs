//! Conversion of the data of the ISM330DHCX to a [`Reading`].
//!
//! ```text
//!  byte 0         1           2         3         5           11       13       15
//!       +---------+-----------+---------+---------+-----------+--------+--------+--------+
//!       | address | STATUS    | (1Fh)   | OUT     | OUTX_L_G  | OUTX_A | OUTY_A | OUTZ_A |
//!       | byte    | _REG      | reserved| _TEMP   | ... 6     | i16    | i16    | i16    |
//!       |         | 1Eh       |         | 20h i16 | bytes 22h | 28h    | 2Ah    | 2Ch    |
//!       +---------+-----------+---------+---------+-----------+--------+--------+--------+
//! ```
//!
//! Acceleration at +-2 g: 61 ug per count (datasheet, LA_So). With 1 g = 2^28 that is 61e-6 * 2^28 = 16374.562816 units per
//! count, calculated as 16374 + 36885/65536 = 16374.562820. The difference is below 0.15 units at full scale, so the result is
//! within one unit (4 ng) of the exact product. Temperature: 256 counts per degree, 0 at 25 degC.

use plumbline::measure::{I32x3, Reading};

/// The axis and direction of the accelerometer that correspond to an axis of the sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axis {
    /// +X of the accelerometer.
    X,
    /// +Y of the accelerometer.
    Y,
    /// +Z of the accelerometer.
    Z,
    /// -X of the accelerometer.
    NegativeX,
    /// -Y of the accelerometer.
    NegativeY,
    /// -Z of the accelerometer.
    NegativeZ,
}

/// The mounting of the accelerometer: X, Y and Z of the sensor as axes of the accelerometer. They must be right-handed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mounting(pub [Axis; 3]);

impl Mounting {
    /// The axes of the accelerometer are those of the sensor.
    pub const ALIGNED: Self = Self([Axis::X, Axis::Y, Axis::Z]);
}

/// The number of bytes in a transfer: the address byte, then STATUS_REG (1Eh) to OUTZ_H_A (2Dh), see the byte map.
pub const TRANSFER: usize = 1 + 16;

/// STATUS_REG of a working accelerometer: new acceleration, gyroscope off, the upper bits always 0, the temperature bit 0 or 1. A
/// stuck bus reads as 00h or FFh, an accelerometer without power as 00h.
const ALIVE: u8 = 0b0000_0001;
const ALIVE_MASK: u8 = 0b1111_1011;

/// The reading in the bytes of a transfer; None if there is no new data or the status is not that of a working accelerometer.
#[inline]
pub fn transferred(bytes: &[u8; TRANSFER], mounting: Mounting) -> Option<Reading> {
    let &[
        _,
        status,
        _,
        t0,
        t1,
        _,
        _,
        _,
        _,
        _,
        _,
        x0,
        x1,
        y0,
        y1,
        z0,
        z1,
    ] = bytes;
    if status & ALIVE_MASK != ALIVE {
        return None;
    }
    let acceleration = [[x0, x1], [y0, y1], [z0, z1]].map(i16::from_le_bytes);
    let temperature = i16::from_le_bytes([t0, t1]);
    Some(reading(acceleration, temperature, mounting))
}

/// A count of acceleration in units of 2^-28 g.
const fn acceleration(count: i16) -> i32 {
    let count = count as i32;
    count * 16374 + ((count * 36885 + 0x8000) >> 16)
}

/// A count of temperature in 0.01 degC. The difference from 25 degC is rounded towards 0.
const fn temperature(count: i16) -> i16 {
    // 100 / 256 = 25 / 64; the result is within -10300..=15299.
    (2500 + count as i32 * 25 / 64) as i16
}

/// The reading of these counts.
#[inline]
pub fn reading(counts: [i16; 3], temperature_count: i16, mounting: Mounting) -> Reading {
    let [x, y, z] = counts.map(acceleration);
    let along = |axis| match axis {
        Axis::X => x,
        Axis::Y => y,
        Axis::Z => z,
        Axis::NegativeX => -x,
        Axis::NegativeY => -y,
        Axis::NegativeZ => -z,
    };
    let [sensor_x, sensor_y, sensor_z] = mounting.0.map(along);
    Reading {
        acceleration: I32x3 {
            x: sensor_x,
            y: sensor_y,
            z: sensor_z,
        },
        angular_rate: I32x3 { x: 0, y: 0, z: 0 },
        temperature: temperature(temperature_count),
        clipped: counts.iter().any(|count| count.unsigned_abs() >= 0x7FFF),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::measure::ONE_G;

    #[test]
    fn acceleration_is_within_one_unit_of_61_micro_g_per_count() {
        for count in i16::MIN..=i16::MAX {
            // count * 61e-6 * 2^28, exactly, in millionths of a unit
            let exact = i128::from(count) * 61 * i128::from(ONE_G);
            let error = i128::from(acceleration(count)) * 1_000_000 - exact;
            assert!(error.abs() <= 1_000_000, "{count}: {error}");
        }
    }

    #[test]
    fn one_g_is_16393_counts() {
        // 1 / 61e-6 = 16393.4
        assert!(acceleration(16393) < ONE_G && acceleration(16394) > ONE_G);
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
    fn only_limits_of_range_are_clipped() {
        let clipped = |counts| reading(counts, 0, Mounting::ALIGNED).clipped;
        assert!(!clipped([0x7FFE, -0x7FFE, 0]));
        assert!(clipped([0x7FFF, 0, 0]));
        assert!(clipped([0, -0x7FFF, 0]));
        assert!(clipped([0, 0, -0x8000]));
    }

    /// A transfer with this STATUS_REG, 26 degC and other counts in every register.
    const fn transfer(status: u8) -> [u8; TRANSFER] {
        [
            0xFF, status, 0xEE, 0x00, 0x01, 1, 2, 3, 4, 5, 6, 0x34, 0x12, 0xFE, 0xFF, 0x00, 0x80,
        ]
    }

    #[test]
    fn transfer_matches_byte_map() {
        let read = transferred(&transfer(0b0000_0101), Mounting::ALIGNED);
        let expected = reading([0x1234, -2, -0x8000], 256, Mounting::ALIGNED);
        assert_eq!(read, Some(expected));
        assert_eq!(expected.temperature, 2600);
    }

    #[test]
    fn transfer_without_new_data_or_with_wrong_status_is_none() {
        for status in 0..=0xFF {
            // XLDA (bit 0) set, GDA (bit 1) clear because the gyroscope is off, TDA (bit 2) 0 or 1, the upper bits 0.
            let alive = matches!(status, 0b001 | 0b101);
            let read = transferred(&transfer(status), Mounting::ALIGNED);
            assert_eq!(read.is_some(), alive, "{status:08b}");
        }
    }

    #[test]
    fn mounting_rotates_axes() {
        // The accelerometer is rotated by 90 deg about Z: its Y is X of the sensor, its X is -Y of the sensor.
        let mounting = Mounting([Axis::Y, Axis::NegativeX, Axis::Z]);
        let turned = reading([100, 200, 300], 0, mounting).acceleration;
        let straight = reading([100, 200, 300], 0, Mounting::ALIGNED).acceleration;
        assert_eq!(turned.x, straight.y);
        assert_eq!(turned.y, -straight.x);
        assert_eq!(turned.z, straight.z);
    }
}
