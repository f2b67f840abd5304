//! The length of long tests.

/// `long` with `PLUMBLINE_LONG=1` in the environment (`.ci/long walk`), otherwise `normal`.
pub fn choose<T>(normal: T, long: T) -> T {
    match std::env::var("PLUMBLINE_LONG").as_deref() {
        Ok("1") => long,
        _ => normal,
    }
}
