//! The status byte (tables 14 and 15).
//!
//! ```text
//!  bit 7   6                5             4              3              2             1                  0
//!    0     AccuracyWarning  SensorErrorY  SensorErrorX   CmdParamError  EEPROMError   AutobaudDetection  DefaultParam
//!                           (2-axis)      or SensorError
//! ```

/// Bits of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Status(pub u8);

impl Status {
    /// Every parameter has its factory value.
    pub const DEFAULT_PARAM: u8 = 1 << 0;
    /// The baud rate parameter is 0: automatic detection.
    pub const AUTOBAUD_DETECTION: u8 = 1 << 1;
    /// Reading or writing the EEPROM failed. Sticky: cleared by reading the status.
    pub const EEPROM_ERROR: u8 = 1 << 2;
    /// A frame with an invalid code or parameter came, or a function failed. Sticky: cleared by reading the status.
    pub const CMD_PARAM_ERROR: u8 = 1 << 3;
    /// 1-axis: the cross slope is out of its range, or the accelerometer clips.
    pub const SENSOR_ERROR: u8 = 1 << 4;
    /// 2-axis: X is out of its range, or the accelerometer clips.
    pub const SENSOR_ERROR_X: u8 = 1 << 4;
    /// 2-axis: Y is out of its range, or the accelerometer clips.
    pub const SENSOR_ERROR_Y: u8 = 1 << 5;
    /// With active temperature compensation: the measuring cell does not have its constant temperature.
    pub const ACCURACY_WARNING: u8 = 1 << 6;

    /// The bits that stay until the status is read.
    pub const STICKY: u8 = Self::EEPROM_ERROR | Self::CMD_PARAM_ERROR;

    /// Sets the bits of `mask`.
    pub fn raise(&mut self, mask: u8) {
        self.0 |= mask;
    }

    /// Replaces the bits of `mask` by those of `bits`.
    pub fn replace(&mut self, mask: u8, bits: u8) {
        self.0 = self.0 & !mask | bits & mask;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replacing_bits_leaves_the_others() {
        let mut status = Status(0b0100_1001);
        status.replace(0b0011_0000, 0b1110_0000);
        assert_eq!(status.0, 0b0110_1001);
    }
}
