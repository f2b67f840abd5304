//! The rotation of a vector by a small angle.
//!
//! With the rotation vector w (its direction is the axis, its length the angle) and u = w / |w| tan(|w| / 2), the coordinates of a
//! fixed vector v in the rotated sensor are
//!
//! ```text
//! v + 2 / (1 + |u|^2) (v + v x u) x u
//! ```
//!
//! For any u this is an exact rotation, so the length of the vector does not change; an error of tan only changes the angle.

/// A vector: Q26 for accelerations, Q31 for rotations.
pub(super) type Vector = [i32; 3];

/// 1 in Q31.
const ONE: u32 = 1 << 31;

/// Rotates `state` (Q58, offset 1/2 in Q26, at most 14 g long) into the sensor after its rotation by `rotation` (radians, Q31,
/// each component within +-1/2). Returns the rotated vector, Q26, rounded to nearest.
///
/// The error of the angle is below 1e-5 of it at 0.2 rad.
pub(super) fn rotated(state: &mut [i64; 3], rotation: Vector) -> Vector {
    // |w|^2; three components of 1/2 give 3/4
    let [x, y, z] = rotation.map(|w| (i64::from(w) * i64::from(w)) as u64);
    let square = ((x + y + z) >> 31) as u32;
    // tan(|w| / 2) / |w| = 1/2 (1 + |w|^2 / 12 + ...)
    let half = ONE / 2 + square / 24;
    // |u|^2, at most 0.22
    let tangent = high(high(half, half), square);
    // 1 / (1 + n) = (1 - n) (1 + n^2) (1 + n^4), the error is n^8
    let second = high(tangent, tangent);
    let fourth = high(second, second);
    let reciprocal = high(high(ONE - tangent, ONE + second), ONE + fourth);

    let u = rotation.map(|w| times(w, half));
    let twice = u.map(|u| times(u, reciprocal) << 1);
    let v = state.map(output);
    let [x, y, z] = cross(v, u).map(|product| ((product >> 30) + 1) >> 1);
    let [vx, vy, vz] = v.map(i64::from);
    let sum = [(vx + x) as i32, (vy + y) as i32, (vz + z) as i32];
    for (component, change) in state.iter_mut().zip(cross(sum, twice)) {
        *component += change << 1;
    }
    state.map(output)
}

/// The product a x b with the fractional bits of both. Each component of the operands must be below 2^31.
#[inline(never)] // measured: smaller, and no answer takes longer
pub(super) fn cross(a: Vector, b: Vector) -> [i64; 3] {
    // Products of 32-bit numbers, each one instruction. With numbers of 64 bits the code would be twice as long.
    let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [
        product(ay, bz) - product(az, by),
        product(az, bx) - product(ax, bz),
        product(ax, by) - product(ay, bx),
    ]
}

/// The upper half of a state with the offset of 1/2: rounded to nearest.
fn output(state: i64) -> i32 {
    (state >> 32) as i32
}

/// The product of two numbers in Q31.
fn high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 31) as u32
}

/// A signed number times a factor in Q31, rounded to nearest.
fn times(value: i32, factor: u32) -> i32 {
    ((i64::from(value) * i64::from(factor) + (1 << 30)) >> 31) as i32
}

#[cfg(test)]
mod tests;
