//! The density of the tests that sweep many values.

/// The stride of a sweep: `stride`, or 1 in a long run (the environment variable `PLUMBLINE_LONG` is set; `.ci/long sweeps`).
pub fn every(stride: usize) -> usize {
    if std::env::var_os("PLUMBLINE_LONG").is_some() {
        1
    } else {
        stride
    }
}
