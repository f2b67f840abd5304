//! A sensor without hardware.
fn main() {}
