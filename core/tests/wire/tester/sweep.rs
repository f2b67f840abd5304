//! The density of the tests that sweep many values.

/// The stride of a sweep: `stride`, or 1 in a long run (`PLUMBLINE_LONG=1` in the environment; `.ci/long sweeps`).
pub fn every(stride: usize) -> usize {
    match std::env::var("PLUMBLINE_LONG").as_deref() {
        Ok("1") => 1,
        _ => stride,
    }
}
