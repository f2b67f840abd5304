//! Teach-in: angles relative to a plane of the machine instead of the mounting plane of the sensor (ifm JN2101 manual 9.5).
//!
//! The teach-in is performed while the machine is level. The up vector u becomes the new Z axis. The new X axis is the projection
//! of the old one onto the plane perpendicular to u. The new Y axis completes the right-handed frame:
//!
//! ```text
//! Zb = u / |u|,  Xb = (ex - Zb (Zb . ex)) / |...|,  Yb = Zb x Xb
//! ```
//!
//! The matrix with these rows is the product of two rotations, first about the X axis of the sensor and then about its Y axis:
//!
//! ```text
//! [Xb]   [ cp  0 -sp ]   [ 1  0   0  ]   sr = uy / sqrt(uy^2 + uz^2)   cr = uz / sqrt(uy^2 + uz^2)
//! [Yb] = [ 0   1  0  ] * [ 0  cr -sr ]
//! [Zb]   [ sp  0  cp ]   [ 0  sr  cr ]   sp = ux / |u|                 cp = sqrt(uy^2 + uz^2) / |u|
//! ```
//!
//! These four numbers are stored. They give an orthonormal matrix if each pair is a sine and a cosine.
//!
//! The X axis must not be vertical, because its projection is then 0. An error of the up vector rotates the new X axis by 1 / cp
//! times this error. At less than 5 deg from vertical, where the factor is above 11.5, the teach-in is refused.
//!
//! # Byte map
//!
//! ```text
//!  byte 0         4         8         12        16
//!       +---------+---------+---------+---------+
//!       | sr, i32 | cr, i32 | sp, i32 | cp, i32 |
//!       +---------+---------+---------+---------+
//! ```
//!
//! All little-endian, 1 = 2^30. The sum of the squares of each pair must be 1 within 2^-21, and cp must be at least the sine of 5
//! deg. Other data is refused.

use super::definition::{normalise, square};
use super::low_pass_design::ratio;
use super::{I32x3, RANGE};

/// The length of an encoded [`ReferenceFrame`] in bytes.
pub const SIZE: usize = 16;

/// 1 in Q30.
const ONE: i32 = 1 << 30;

/// The sine of 5 deg in Q30: the smallest accepted cosine of the rotation about the Y axis.
const LEAST_COSINE: i32 = 93_582_766;

/// The accepted difference of a sum of squares from 1, in Q60.
const TOLERANCE: u64 = 1 << (60 - 21);

/// The reference frame of a teach-in.
///
/// The error of an angle in the new frame is at most 3e-5 deg, compared with exact arithmetic on the reference and the sample and
/// including the error of the angle definition. This is valid for samples of 1/2 g and more.
///
/// ```
/// use plumbline::measure::{I32x3, ONE_G, definition::perpendicular, teach::ReferenceFrame};
///
/// let crooked = I32x3 { x: ONE_G / 3, y: ONE_G / 4, z: ONE_G };
/// let teach = ReferenceFrame::new(crooked).unwrap();
/// let now_level = perpendicular(teach.apply(crooked));
/// assert_eq!((now_level.x.millidegrees(), now_level.y.millidegrees()), (0, 0));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReferenceFrame {
    /// The rotation about the X axis.
    roll: Turn,
    /// The rotation about the Y axis.
    pitch: Turn,
}

/// A rotation in a plane, Q30.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Turn {
    sine: i32,
    cosine: i32,
}

impl ReferenceFrame {
    /// The coordinate frame of the sensor.
    pub const IDENTITY: Self = Self {
        roll: Turn::NONE,
        pitch: Turn::NONE,
    };

    /// The reference frame with the Z axis `up`; only its direction has an effect. None if the X axis is within 5 deg of vertical
    /// (up or down), and for the zero vector.
    pub fn new(up: I32x3) -> Option<Self> {
        let up = normalise(up);
        // Half of the vector, so that the lengths fit 31 bits.
        let (x, y, z) = (up.x / 2, up.y / 2, up.z / 2);
        let across = square(y).wrapping_add(square(z));
        let level = square_root(across);
        if level == 0 {
            return None;
        }
        let length = square_root(across.wrapping_add(square(x)));
        let pitch = Turn {
            sine: quotient(x, length),
            cosine: quotient(level as i32, length),
        };
        if pitch.cosine < LEAST_COSINE {
            return None;
        }
        let roll = Turn {
            sine: quotient(y, level),
            cosine: quotient(z, level),
        };
        Some(Self { roll, pitch })
    }

    /// `acceleration` (1 g = 2^26) in the reference frame, rounded to nearest. The input is limited to +-16 g.
    pub fn apply(&self, acceleration: I32x3) -> I32x3 {
        let [x, y, z] = acceleration
            .to_array()
            .map(|component| component.clamp(-2 * RANGE, 2 * RANGE));
        let (y, z) = self.roll.apply(y, z);
        let (x, z) = self.pitch.apply(x, z);
        I32x3 { x, y, z }
    }

    /// Encodes the reference frame, see the byte map.
    pub fn encode(&self) -> [u8; SIZE] {
        let mut bytes = [0; SIZE];
        let values = [
            self.roll.sine,
            self.roll.cosine,
            self.pitch.sine,
            self.pitch.cosine,
        ];
        for (place, value) in bytes.as_chunks_mut().0.iter_mut().zip(values) {
            *place = value.to_le_bytes();
        }
        bytes
    }

    /// Decodes the result of [`encode`](Self::encode). None if the numbers are not two rotations that [`new`](Self::new) accepts.
    pub fn decode(bytes: &[u8; SIZE]) -> Option<Self> {
        let mut values = [0; 4];
        for (value, &place) in values.iter_mut().zip(bytes.as_chunks().0) {
            *value = i32::from_le_bytes(place);
        }
        let [roll_sine, roll_cosine, pitch_sine, pitch_cosine] = values;
        let roll = Turn::checked(roll_sine, roll_cosine)?;
        let pitch = Turn::checked(pitch_sine, pitch_cosine)?;
        (pitch.cosine >= LEAST_COSINE).then_some(Self { roll, pitch })
    }
}

impl Default for ReferenceFrame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Turn {
    const NONE: Self = Self {
        sine: 0,
        cosine: ONE,
    };

    /// None if the sum of the squares is not 1.
    fn checked(sine: i32, cosine: i32) -> Option<Self> {
        let sum = square(sine).wrapping_add(square(cosine));
        (sum.abs_diff(square(ONE)) <= TOLERANCE).then_some(Self { sine, cosine })
    }

    /// The point (`a`, `b`), rotated so that (sine, cosine) is on the second axis. With both within +-2^30 and any third
    /// component, the length of the result fits 31 bits.
    fn apply(self, a: i32, b: i32) -> (i32, i32) {
        let sum = |p: i32, v: i32, q: i32, w: i32| {
            let products = i64::from(p) * i64::from(v) + i64::from(q) * i64::from(w);
            ((products + i64::from(ONE / 2)) >> 30) as i32
        };
        (
            sum(self.cosine, a, -self.sine, b),
            sum(self.sine, a, self.cosine, b),
        )
    }
}

/// `part` / `whole` in Q30, rounded to nearest, for |`part`| <= `whole`, and `whole` in 1..2^31.
fn quotient(part: i32, whole: u32) -> i32 {
    // Half of the quotient, because `ratio` cannot return 1.
    let q31 = ratio(part.unsigned_abs(), whole.wrapping_mul(2));
    let q30 = ((q31 >> 1) + (q31 & 1)) as i32;
    if part < 0 { -q30 } else { q30 }
}

/// The square root, rounded down. Bit by bit: exact, small, and rarely needed.
pub(super) fn square_root(square: u64) -> u32 {
    (0..32).rev().fold(0, |root, bit| {
        let trial = root | (1 << bit);
        let fits = u64::from(trial) * u64::from(trial) <= square;
        if fits { trial } else { root }
    })
}

#[cfg(test)]
mod tests;
