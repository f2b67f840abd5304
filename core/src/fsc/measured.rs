//! What a sensor measures, before the zero offset.

/// Measured angles in 0.01 deg and the sensor errors that go with them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Measured {
    /// The angle of a 1-axis sensor (0 to 35999), or X (-9000 to 9000).
    pub x: i32,
    /// Y (-9000 to 9000); 0 on a 1-axis sensor.
    pub y: i32,
    /// The sensor error bits of the [status byte](super::Status).
    pub errors: u8,
}
