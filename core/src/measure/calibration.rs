//! Calibration of one device: corrects the systematic errors of its accelerometer.
//!
//! With the raw acceleration `a` in g and the temperature `T` in degC:
//!
//! ```text
//! corrected = (I + D) (a - offset - drift (T - 25))
//! ```
//!
//! `I + D` is the correction matrix. The diagonal of `D` corrects the gain of each axis. The other elements correct cross-axis
//! errors (axes that are not orthogonal, or rotated relative to the housing).
//!
//! # Byte map
//!
//! ```text
//!  byte 0         4         8         12        30         36
//!       +---------+---------+---------+---------+----------+
//!       | offset  | offset  | offset  | D       | drift    |
//!       | x, i32  | y, i32  | z, i32  | 9 x i16 | 3 x i16  |
//!       +---------+---------+---------+---------+----------+
//! ```
//!
//! All little-endian; `D` row by row (xx, xy, xz, yx, ...: the first letter is the corrected axis), `drift` x, y, z.
//!
//! | field  | unit              | resolution  | range accepted                |
//! |--------|-------------------|-------------|-------------------------------|
//! | offset | 2^-28 g           | 3.7e-9 g    | +-0.25 g (+-67108864)         |
//! | D      | 2^-18             | 3.8e-6      | +-0.1 (+-26214)               |
//! | drift  | 2^-24 g/K         | 6.0e-8 g/K  | +-1 mg/K (+-16777)            |
//!
//! # Six-position measurement
//!
//! Place the housing at rest on each of its six sides, on a level surface and at 25 degC. Average the raw acceleration in g for
//! some seconds in each position. `p_i` is the average (a vector) with axis `i` up, `n_i` the average with axis `i` down.
//!
//! ```text
//! offset = (p_x + n_x + p_y + n_y + p_z + n_z) / 6
//! s_i    = (p_i - n_i) / 2            one vector for each axis
//! S      = [s_x s_y s_z]              the vectors are its columns
//! D      = inverse(S) - I
//! drift  = (offset at T2 - offset at T1) / (T2 - T1)
//! ```
//!
//! Gravity cancels in the offset. If the surface is off level by a small angle e, the error of the gain is only e^2/2. For
//! `drift`, repeat the measurement at a low and a high temperature `T1` and `T2`. The offset is the one at 25 degC.

use super::{I32x3, ONE_G, saturated};

/// The length of an encoded [`Calibration`] in bytes.
pub const SIZE: usize = 36;

/// 1 g in the unit of the offset.
pub const OFFSET_ONE_G: i32 = 1 << 28;

const OFFSET_LIMIT: i32 = OFFSET_ONE_G / 4;
const DEVIATION_LIMIT: i16 = 26_214;
const DRIFT_LIMIT: i16 = 16_777;

/// The temperature at which the drift is 0, in 0.01 degC.
const REFERENCE: i32 = 2_500;

/// The temperature range of the drift correction, in 0.01 degC. A temperature outside is limited to it.
const TEMPERATURES: (i32, i32) = (-5_500, 12_500);

/// The calibration of one device, always within the ranges of the table above.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Calibration {
    offset: [i32; 3],
    deviation: [[i16; 3]; 3],
    drift: [i16; 3],
}

impl Calibration {
    /// The identity: no correction.
    pub const IDENTITY: Self = Self {
        offset: [0; 3],
        deviation: [[0; 3]; 3],
        drift: [0; 3],
    };

    /// A calibration of `offset` (2^-28 g), `deviation` (the rows of `D`, 2^-18) and `drift` (2^-24 g/K); None if a number is out
    /// of its range.
    pub fn new(offset: [i32; 3], deviation: [[i16; 3]; 3], drift: [i16; 3]) -> Option<Self> {
        let calibration = Self {
            offset,
            deviation,
            drift,
        };
        calibration.is_within_ranges().then_some(calibration)
    }

    /// The numbers as in [`new`](Self::new): offset, deviation and drift.
    pub fn numbers(&self) -> ([i32; 3], [[i16; 3]; 3], [i16; 3]) {
        (self.offset, self.deviation, self.drift)
    }

    /// Corrects a raw acceleration (1 g = 2^26) at `temperature` (0.01 degC). The result is rounded to nearest and limited to -8
    /// g..8 g in each axis. The raw acceleration is limited to the same range first.
    pub fn apply(&self, acceleration: I32x3, temperature: i16) -> I32x3 {
        let (coldest, hottest) = TEMPERATURES;
        let warmth = i32::from(temperature).clamp(coldest, hottest) - REFERENCE;
        let [ox, oy, oz] = self.offset;
        let [dx, dy, dz] = self.drift;
        let x = saturated(acceleration.x) - coarse(ox + drift(dx, warmth));
        let y = saturated(acceleration.y) - coarse(oy + drift(dy, warmth));
        let z = saturated(acceleration.z) - coarse(oz + drift(dz, warmth));
        let [xs, ys, zs] = &self.deviation;
        I32x3 {
            x: saturated(x + deviation(xs, x, y, z)),
            y: saturated(y + deviation(ys, x, y, z)),
            z: saturated(z + deviation(zs, x, y, z)),
        }
    }

    /// Encodes the calibration, see the byte map.
    pub fn encode(&self) -> [u8; SIZE] {
        let mut bytes = [0; SIZE];
        if let Some((offset, rest)) = bytes.split_first_chunk_mut::<12>() {
            for (place, value) in offset.as_chunks_mut().0.iter_mut().zip(self.offset) {
                *place = value.to_le_bytes();
            }
            let values = self.deviation.as_flattened().iter().chain(&self.drift);
            for (place, value) in rest.as_chunks_mut().0.iter_mut().zip(values) {
                *place = value.to_le_bytes();
            }
        }
        bytes
    }

    /// Decodes the result of [`encode`](Self::encode). None if a number is out of its range.
    pub fn decode(bytes: &[u8; SIZE]) -> Option<Self> {
        let (offsets, rest) = bytes.split_first_chunk::<12>()?;
        let (deviations, drifts) = rest.split_first_chunk::<18>()?;
        let mut calibration = Self::IDENTITY;
        for (value, &place) in calibration.offset.iter_mut().zip(offsets.as_chunks().0) {
            *value = i32::from_le_bytes(place);
        }
        let deviation = calibration.deviation.as_flattened_mut();
        decode_numbers(deviation, deviations);
        decode_numbers(&mut calibration.drift, drifts);
        calibration.is_within_ranges().then_some(calibration)
    }

    fn is_within_ranges(&self) -> bool {
        self.offset
            .iter()
            .all(|v| (-OFFSET_LIMIT..=OFFSET_LIMIT).contains(v))
            && are_within(self.deviation.as_flattened(), DEVIATION_LIMIT)
            && are_within(&self.drift, DRIFT_LIMIT)
    }
}

fn decode_numbers(numbers: &mut [i16], bytes: &[u8]) {
    for (number, &place) in numbers.iter_mut().zip(bytes.as_chunks().0) {
        *number = i16::from_le_bytes(place);
    }
}

fn are_within(numbers: &[i16], limit: i16) -> bool {
    numbers.iter().all(|v| (-limit..=limit).contains(v))
}

impl Default for Calibration {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// An offset (2^-28 g) in the unit of the acceleration, rounded to nearest.
const fn coarse(offset: i32) -> i32 {
    const SHIFT: u32 = (OFFSET_ONE_G / ONE_G).ilog2();
    (offset + (1 << SHIFT >> 1)) >> SHIFT
}

/// `per_kelvin` (2^-24 g/K) times `warmth` (0.01 K) in 2^-28 g: the product times 2^4/100, rounded to nearest. At most 2^25.
fn drift(per_kelvin: i16, warmth: i32) -> i32 {
    const SCALE: i64 = ((1 << 36) + 50) / 100;
    ((i64::from(i32::from(per_kelvin) * warmth) * SCALE + (1 << 31)) >> 32) as i32
}

/// One row of the deviation (2^-18) times the vector, rounded to nearest. At most 0.3 times the largest component of the vector.
fn deviation(row: &[i16; 3], x: i32, y: i32, z: i32) -> i32 {
    let &[dx, dy, dz] = row;
    let product = |d: i16, v: i32| i64::from(d) * i64::from(v);
    ((product(dx, x) + product(dy, y) + product(dz, z) + (1 << 17)) >> 18) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::RANGE;
    use proptest::prelude::*;

    #[test]
    fn numbers_of_a_calibration_are_those_that_it_was_made_of() {
        let numbers = (
            [10, -20, 30],
            [[1, -2, 3], [-4, 5, -6], [7, -8, 9]],
            [4, -5, 6],
        );
        let (offset, deviation, drift) = numbers;
        let calibration = Calibration::new(offset, deviation, drift).unwrap();
        assert_eq!(calibration.numbers(), numbers);
    }

    const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
        I32x3 { x, y, z }
    }

    #[test]
    fn identity_changes_nothing() {
        for v in [1 - RANGE, -1, 0, 1, 12_345, ONE_G, RANGE - 1] {
            for temperature in [i16::MIN, -4000, 0, 2500, i16::MAX] {
                let a = vector(v, -v, v / 2);
                assert_eq!(Calibration::IDENTITY.apply(a, temperature), a);
            }
        }
    }

    #[test]
    fn image_matches_byte_map() {
        let calibration = Calibration::new(
            [0x0102_0304, -2, 3],
            [[0x0102, 2, 3], [4, 5, 6], [7, 8, -9]],
            [0x0A0B, 11, -12],
        )
        .unwrap();
        let bytes = [
            4, 3, 2, 1, 0xFE, 0xFF, 0xFF, 0xFF, 3, 0, 0, 0, // offset
            2, 1, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 0xF7, 0xFF, // D
            0x0B, 0x0A, 11, 0, 0xF4, 0xFF, // drift
        ];
        assert_eq!(calibration.encode(), bytes);
        assert_eq!(Calibration::decode(&bytes), Some(calibration));
        assert_eq!(Calibration::IDENTITY.encode(), [0; SIZE]);
    }

    #[test]
    fn number_just_outside_its_range_is_refused() {
        // The position of each number in the image, its limit and its size.
        let offsets = (0..3).map(|i| (4 * i, 67_108_864i32, 4));
        let deviations = (0..9).map(|i| (12 + 2 * i, 26_214, 2));
        let drifts = (0..3).map(|i| (30 + 2 * i, 16_777, 2));
        for (at, limit, width) in offsets.chain(deviations).chain(drifts) {
            let with = |value: i32| {
                let mut bytes = [0; SIZE];
                bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
                Calibration::decode(&bytes)
            };
            assert!(with(limit).is_some() && with(-limit).is_some(), "byte {at}");
            assert!(
                with(limit + 1).is_none() && with(-limit - 1).is_none(),
                "byte {at}"
            );
        }
        assert_eq!(
            Calibration::decode(&[0xFF; SIZE]).map(|c| c.offset),
            Some([-1; 3])
        );
    }

    #[test]
    fn offset_gain_cross_axis_and_drift_are_corrected() {
        // 10 mg, gain +1 %, 0.01 of y onto x, 0.1 mg/K
        let (mg, percent, drift) = (ONE_G / 1000, 2621, 1678);
        let c = Calibration::new(
            [OFFSET_ONE_G / 100, 0, 0],
            [[percent, percent, 0], [0; 3], [0; 3]],
            [drift, 0, 0],
        )
        .unwrap();
        let near = |value: i32, mg_expected: f64| {
            let g = f64::from(value) / f64::from(ONE_G) * 1000.0;
            assert!((g - mg_expected).abs() < 0.01, "{g} mg");
        };
        near(c.apply(vector(510 * mg, 0, 0), 2500).x, 505.0);
        near(c.apply(vector(510 * mg, 1000 * mg, 0), 2500).x, 515.0);
        // 30 K warmer: 3 mg of drift; 65 K colder: -6.5 mg
        near(c.apply(vector(513 * mg, 0, 0), 5500).x, 505.0);
        near(
            c.apply(vector(510 * mg - 6 * mg - mg / 2, 0, 0), -4000).x,
            505.0,
        );
        assert_eq!(c.apply(vector(0, 7, -7), 2500).y, 7);
    }

    #[test]
    fn result_saturates_at_8_g() {
        let c = Calibration::new([-OFFSET_LIMIT; 3], [[DEVIATION_LIMIT; 3]; 3], [0; 3]).unwrap();
        let end = RANGE;
        assert_eq!(
            c.apply(vector(i32::MAX, i32::MAX, i32::MAX), 2500),
            vector(end - 1, end - 1, end - 1)
        );
        let c = Calibration::new([OFFSET_LIMIT; 3], [[DEVIATION_LIMIT; 3]; 3], [0; 3]).unwrap();
        assert_eq!(
            c.apply(vector(i32::MIN, i32::MIN, i32::MIN), 2500),
            vector(-end, -end, -end)
        );
    }

    #[test]
    fn six_position_measurement_gives_calibration() {
        // A device with errors, the formulas of the module documentation, then the corrected readings.
        let gain = [
            [1.02, 0.01, -0.005],
            [-0.02, 0.97, 0.015],
            [0.01, -0.01, 1.05],
        ];
        let bias = [0.03, -0.05, 0.08];
        let raw = |u: [f64; 3]| -> [f64; 3] {
            core::array::from_fn(|i| (0..3).map(|j| gain[i][j] * u[j]).sum::<f64>() + bias[i])
        };
        let side = |axis: usize, sign: f64| {
            raw(core::array::from_fn(|i| if i == axis { sign } else { 0.0 }))
        };
        let mut offset = [0.0; 3];
        let mut s = [[0.0; 3]; 3];
        for axis in 0..3 {
            let (p, n) = (side(axis, 1.0), side(axis, -1.0));
            for (i, (offset, row)) in offset.iter_mut().zip(&mut s).enumerate() {
                *offset += (p[i] + n[i]) / 6.0;
                row[axis] = (p[i] - n[i]) / 2.0;
            }
        }
        // The inverse by Cramer's rule.
        let minor = |i: usize, j: usize| {
            let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            s[a][c] * s[b][d] - s[a][d] * s[b][c]
        };
        let determinant: f64 = (0..3).map(|j| s[0][j] * minor(0, j)).sum();
        let deviation = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let identity = if i == j { 1.0 } else { 0.0 };
                ((minor(j, i) / determinant - identity) * 262_144.0).round() as i16
            })
        });
        let fixed = |v: f64| (v * f64::from(ONE_G)).round() as i32;
        let offset = offset.map(|v| (v * f64::from(OFFSET_ONE_G)).round() as i32);
        let c = Calibration::new(offset, deviation, [0; 3]).unwrap();
        for u in [[0.0, 0.0, 1.0], [0.6, -0.8, 0.0], [0.36, 0.48, -0.8]] {
            let [x, y, z] = raw(u).map(fixed);
            let corrected = c.apply(vector(x, y, z), 2500);
            for (got, want) in [corrected.x, corrected.y, corrected.z].into_iter().zip(u) {
                // Three coefficients, each rounded to 2^-18.
                assert!((f64::from(got) / f64::from(ONE_G) - want).abs() < 6e-6);
            }
        }
    }

    fn calibrations() -> impl Strategy<Value = Calibration> {
        let offset = -OFFSET_LIMIT..=OFFSET_LIMIT;
        let deviation = -DEVIATION_LIMIT..=DEVIATION_LIMIT;
        let drift = -DRIFT_LIMIT..=DRIFT_LIMIT;
        (
            prop::array::uniform3(offset),
            prop::array::uniform3(prop::array::uniform3(deviation)),
            prop::array::uniform3(drift),
        )
            .prop_map(|(o, d, t)| Calibration::new(o, d, t).unwrap())
    }

    proptest! {
        #[test]
        fn calibration_is_unchanged_after_encode_and_decode(c in calibrations()) {
            prop_assert_eq!(Calibration::decode(&c.encode()), Some(c));
        }

        #[test]
        fn result_is_rounded_formula(c in calibrations(), a: [i32; 3], temperature: i16) {
            let got = c.apply(vector(a[0], a[1], a[2]), temperature);
            let end = f64::from(RANGE);
            let kelvin = f64::from(temperature.clamp(-5500, 12500)) / 100.0 - 25.0;
            let d: [f64; 3] = core::array::from_fn(|i| {
                f64::from(a[i]).clamp(-end, end - 1.0) - f64::from(c.offset[i]) / 4.0 - f64::from(c.drift[i]) * 4.0 * kelvin
            });
            for (i, got) in [got.x, got.y, got.z].into_iter().enumerate() {
                let sum: f64 = (0..3).map(|j| f64::from(c.deviation[i][j]) / 262_144.0 * d[j]).sum();
                // Half a unit for each of two roundings; the matrix scales the first one.
                prop_assert!((f64::from(got) - (d[i] + sum).clamp(-end, end - 1.0)).abs() <= 1.2);
            }
        }
    }
}
