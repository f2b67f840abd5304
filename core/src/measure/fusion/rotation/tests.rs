//! Tests of the rotation against double precision.

use super::*;
use proptest::prelude::*;

/// The unit of the vectors in these tests. It has no effect on a rotation.
const Q28: f64 = 268_435_456.0;
const Q31: f64 = 2_147_483_648.0;

fn state_of(vector: Vector) -> [i64; 3] {
    vector.map(|component| (i64::from(component) << 32) | (1 << 31))
}

fn value_of(state: [i64; 3]) -> [f64; 3] {
    state.map(|component| (component - (1 << 31)) as f64 / 4_294_967_296.0 / Q28)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Rodrigues' formula: `v` in a frame that has been rotated by the rotation vector `w`.
fn exact(v: [f64; 3], w: [f64; 3]) -> [f64; 3] {
    let angle = length(w);
    if angle == 0.0 {
        return v;
    }
    let [x, y, z] = w.map(|c| -c / angle);
    let across = [
        y * v[2] - z * v[1],
        z * v[0] - x * v[2],
        x * v[1] - y * v[0],
    ];
    let along = (x * v[0] + y * v[1] + z * v[2]) * (1.0 - angle.cos());
    let axis = [x, y, z];
    core::array::from_fn(|i| v[i] * angle.cos() + across[i] * angle.sin() + axis[i] * along)
}

fn vectors(limit: i32) -> impl Strategy<Value = Vector> {
    [-limit..=limit, -limit..=limit, -limit..=limit]
}

#[test]
fn rotation_by_zero_changes_nothing() {
    let mut state = state_of([1, -2, 3 << 26]);
    assert_eq!(rotated(&mut state, [0; 3]), [1, -2, 3 << 26]);
    assert_eq!(state, state_of([1, -2, 3 << 26]));
}

#[test]
fn right_hand_rotation_about_y_moves_up_towards_minus_x() {
    // As `perpendicular` defines it: the X axis moves down, so the up vector gets a negative X component.
    let mut state = state_of([0, 0, 1 << 28]);
    let [x, y, z] = rotated(&mut state, [0, 1 << 28, 0]);
    let (sin, cos) = 0.125_f64.sin_cos();
    assert!((f64::from(x) / Q28 + sin).abs() < 1e-6, "{x}");
    assert_eq!(y, 0);
    assert!((f64::from(z) / Q28 - cos).abs() < 1e-6, "{z}");
}

#[test]
fn length_is_constant_over_an_hour_of_fast_rotation() {
    let mut state = state_of([1 << 27, 1 << 26, 1 << 28]);
    let before = length(value_of(state));
    for _ in 0..3600 * 200 {
        rotated(&mut state, [374_825_000, -374_825_000, 374_825_000]);
    }
    let after = length(value_of(state));
    assert!((after / before - 1.0).abs() < 0.05, "{before} {after}");
}

proptest! {
    #[test]
    fn rotation_matches_exact_rotation(vector in vectors(1 << 29), rotation in vectors(1 << 28)) {
        let w = rotation.map(|c| f64::from(c) / Q31);
        let mut state = state_of(vector);
        let expected = exact(value_of(state), w);
        rotated(&mut state, rotation);
        let got = value_of(state);
        // The next term of the series of the tangent
        let limit = length(expected) * (length(w).powi(5) / 119.0 + 1e-8) + 2e-8;
        let error = length(core::array::from_fn(|i| got[i] - expected[i]));
        prop_assert!(error <= limit, "{error:e} {limit:e}");
    }

    #[test]
    fn largest_rotation_keeps_length(vector in vectors(1 << 29), rotation in vectors(1 << 30)) {
        let mut state = state_of(vector);
        let before = length(value_of(state));
        rotated(&mut state, rotation);
        let after = length(value_of(state));
        prop_assert!((after - before).abs() <= before * 1e-5 + 2e-8, "{before} {after}");
    }
}
