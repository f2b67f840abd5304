//! Calibration of one device: corrects the systematic errors of its accelerometer, and the zero rate of its gyroscope.
//!
//! With the raw acceleration `a` in g and the temperature `T` in degC:
//!
//! ```text
//! corrected = (I + D) (a - offset - drift (T - 25))
//! ```
//!
//! `I + D` is the correction matrix. The diagonal of `D` corrects the gain of each axis. The other elements correct cross-axis
//! errors (axes that are not orthogonal, or rotated relative to the housing). With the raw angular rate `w` in deg/s:
//!
//! ```text
//! corrected = w - zero - zero_drift (T - 25)
//! ```
//!
//! # Byte map
//!
//! ```text
//!  byte 0         4         8         12        30         36         42           48     49
//!       +---------+---------+---------+---------+----------+----------+------------+------+
//!       | offset  | offset  | offset  | D       | drift    | zero     | zero_drift | part |
//!       | x, i32  | y, i32  | z, i32  | 9 x i16 | 3 x i16  | 3 x i16  | 3 x i16    | u8   |
//!       +---------+---------+---------+---------+----------+----------+------------+------+
//! ```
//!
//! All little-endian; `D` row by row (xx, xy, xz, yx, ...: the first letter is the corrected axis), the others x, y, z. The part is the
//! measuring element whose errors these are ([`Part`]): a sensor with another one does not use the calibration. A calibration from before
//! the zero rate has 36 bytes, one from before the part 48. What is missing is 0.
//!
//! | field  | unit              | resolution  | range accepted                |
//! |--------|-------------------|-------------|-------------------------------|
//! | offset | 2^-28 g           | 3.7e-9 g    | +-0.25 g (+-67108864)         |
//! | D      | 2^-18             | 3.8e-6      | +-0.1 (+-26214)               |
//! | drift  | 2^-24 g/K         | 6.0e-8 g/K  | +-1 mg/K (+-16777)            |
//! | zero   | 2^-12 deg/s       | 2.4e-4 deg/s | +-7.5 deg/s (+-30720)        |
//! | zero_drift | 2^-20 deg/s/K | 9.5e-7 deg/s/K | +-0.03 deg/s/K (+-31457)   |
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
//! `zero` is the mean of the angular rates in all positions, because the sensor is at rest in each.
//!
//! Gravity cancels in the offset. If the surface is off level by a small angle e, the error of the gain is only e^2/2. For
//! `drift` and `zero_drift`, repeat the measurement at a low and a high temperature `T1` and `T2`. Offset and zero rate are those at 25
//! degC.

mod log;

use super::{I32x3, ONE_G, saturated};

/// The length of an encoded [`Calibration`] in bytes.
pub const SIZE: usize = 49;

/// The length of the part for the accelerometer in bytes. An old calibration has only this part.
pub const ACCELEROMETER_SIZE: usize = 36;

/// A part that is used as measuring element.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Part {
    /// ISM330DHCX, and ASM330LHH.
    #[default]
    Ism330dhcx = 0,
    /// ADXL355.
    Adxl355 = 1,
}

impl Part {
    /// All parts.
    pub const ALL: &'static [Self] = &[Self::Ism330dhcx, Self::Adxl355];

    /// The name, as that of the feature of the firmware.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ism330dhcx => "ism330dhcx",
            Self::Adxl355 => "adxl355",
        }
    }
}

/// 1 g in the unit of the offset.
pub const OFFSET_ONE_G: i32 = 1 << 28;

const OFFSET_LIMIT: i32 = OFFSET_ONE_G / 4;
const DEVIATION_LIMIT: i16 = 26_214;
const DRIFT_LIMIT: i16 = 16_777;
const ZERO_LIMIT: i16 = 30_720;
const ZERO_DRIFT_LIMIT: i16 = 31_457;

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
    /// The zero rate at the reference temperature, and its drift.
    zero: [[i16; 3]; 2],
    part: Part,
}

impl Calibration {
    /// The identity: no correction.
    pub const IDENTITY: Self = Self {
        offset: [0; 3],
        deviation: [[0; 3]; 3],
        drift: [0; 3],
        zero: [[0; 3]; 2],
        part: Part::Ism330dhcx,
    };

    /// A calibration of `offset` (2^-28 g), `deviation` (the rows of `D`, 2^-18) and `drift` (2^-24 g/K); None if a number is out
    /// of its range.
    pub fn new(offset: [i32; 3], deviation: [[i16; 3]; 3], drift: [i16; 3]) -> Option<Self> {
        let calibration = Self {
            offset,
            deviation,
            drift,
            ..Self::IDENTITY
        };
        calibration.is_within_ranges().then_some(calibration)
    }

    /// The same calibration with a zero rate (2^-12 deg/s) and its drift (2^-20 deg/s/K); None if a number is out of its range.
    pub fn with_zero_rate(self, zero: [i16; 3], drift: [i16; 3]) -> Option<Self> {
        let calibration = Self {
            zero: [zero, drift],
            ..self
        };
        calibration.is_within_ranges().then_some(calibration)
    }

    /// The same numbers for another part.
    pub fn of(self, part: Part) -> Self {
        Self { part, ..self }
    }

    /// The part whose errors these are.
    pub fn part(&self) -> Part {
        self.part
    }

    /// The zero rate and its drift, as in [`with_zero_rate`](Self::with_zero_rate).
    pub fn zero_rate(&self) -> ([i16; 3], [i16; 3]) {
        let [zero, drift] = self.zero;
        (zero, drift)
    }

    /// The numbers as in [`new`](Self::new): offset, deviation and drift.
    pub fn numbers(&self) -> ([i32; 3], [[i16; 3]; 3], [i16; 3]) {
        (self.offset, self.deviation, self.drift)
    }

    /// Corrects a raw acceleration (1 g = 2^26) at `temperature` (0.01 degC). The result is rounded to nearest and limited to -8
    /// g..8 g in each axis. The raw acceleration is limited to the same range first.
    pub fn apply(&self, acceleration: I32x3, temperature: i16) -> I32x3 {
        let warmth = warmth(temperature);
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

    /// Corrects a raw angular rate (1 deg/s = 2^16) at `temperature` (0.01 degC). The result is rounded to nearest.
    pub fn apply_to_rate(&self, rate: I32x3, temperature: i16) -> I32x3 {
        let warmth = warmth(temperature);
        let [[zx, zy, zz], [dx, dy, dz]] = self.zero;
        I32x3 {
            x: rate.x.saturating_sub(zero_rate(zx, dx, warmth)),
            y: rate.y.saturating_sub(zero_rate(zy, dy, warmth)),
            z: rate.z.saturating_sub(zero_rate(zz, dz, warmth)),
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
            let values = values.chain(self.zero.as_flattened());
            for (place, value) in rest.as_chunks_mut().0.iter_mut().zip(values) {
                *place = value.to_le_bytes();
            }
        }
        if let Some(place) = bytes.last_mut() {
            *place = self.part as u8;
        }
        bytes
    }

    /// Decodes the result of [`encode`](Self::encode). None if a number is out of its range, or the part unknown.
    pub fn decode(bytes: &[u8; SIZE]) -> Option<Self> {
        let (offsets, rest) = bytes.split_first_chunk::<12>()?;
        let (deviations, rest) = rest.split_first_chunk::<18>()?;
        let (drifts, rest) = rest.split_first_chunk::<6>()?;
        let (zeros, &[part]) = rest.split_first_chunk::<12>()? else {
            return None;
        };
        let mut calibration = Self::IDENTITY;
        for (value, &place) in calibration.offset.iter_mut().zip(offsets.as_chunks().0) {
            *value = i32::from_le_bytes(place);
        }
        let deviation = calibration.deviation.as_flattened_mut();
        decode_numbers(deviation, deviations);
        decode_numbers(&mut calibration.drift, drifts);
        decode_numbers(calibration.zero.as_flattened_mut(), zeros);
        calibration.part = *Part::ALL.iter().find(|known| **known as u8 == part)?;
        calibration.is_within_ranges().then_some(calibration)
    }

    fn is_within_ranges(&self) -> bool {
        let [zero, zero_drift] = &self.zero;
        self.offset
            .iter()
            .all(|v| (-OFFSET_LIMIT..=OFFSET_LIMIT).contains(v))
            && are_within(self.deviation.as_flattened(), DEVIATION_LIMIT)
            && are_within(&self.drift, DRIFT_LIMIT)
            && are_within(zero, ZERO_LIMIT)
            && are_within(zero_drift, ZERO_DRIFT_LIMIT)
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

/// The difference of a temperature (0.01 degC) from the reference.
fn warmth(temperature: i16) -> i32 {
    let (coldest, hottest) = TEMPERATURES;
    i32::from(temperature).clamp(coldest, hottest) - REFERENCE
}

/// A zero rate (2^-12 deg/s) with its drift (2^-20 deg/s/K) at `warmth` (0.01 K), in 2^-16 deg/s, rounded to nearest.
fn zero_rate(zero: i16, drift: i16, warmth: i32) -> i32 {
    (i32::from(zero) << 4) + (i32::from(drift) * warmth + 800).div_euclid(1600)
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
mod tests;
