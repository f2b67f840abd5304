//! The status byte (tables 14 and 15), composed when a reply is sent.
//!
//! ```text
//!  bit 7   6                5             4              3              2             1                  0
//!    0     AccuracyWarning  SensorErrorY  SensorErrorX   CmdParamError  EEPROMError   AutobaudDetection  DefaultParam
//!                           (2-axis)      or SensorError
//! ```

use crate::application::Faults;

/// What sets a bit of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// Nothing: the bit is reserved.
    Never,
    /// Every parameter has its factory value.
    DefaultParam,
    /// The bit rate is detected automatically.
    AutobaudDetection,
    /// Reading or writing the nonvolatile memory failed. Sticky: cleared by reading the status.
    EepromError,
    /// A frame with an invalid code or parameter came, or a function failed. Sticky: cleared by reading the status.
    CmdParamError,
    /// One of these faults of the application is active.
    Fault(Faults),
}

/// A bit of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StatusBit {
    /// The manual's name; empty for a reserved bit.
    pub name: &'static str,
    /// What sets it.
    pub condition: Condition,
}

/// What the device keeps of the description of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct StatusMasks {
    pub default_param: u8,
    pub autobaud_detection: u8,
    pub eeprom_error: u8,
    pub cmd_param_error: u8,
    /// The faults that have a bit, all of them this much further left than their bits.
    faults: Faults,
    shift: u32,
}

impl StatusMasks {
    /// Projects the description. A bit for two faults, and faults that are not in the order of their bits, are compile errors.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub const fn of(bits: &[StatusBit; 8]) -> Self {
        let mut masks = Self {
            default_param: 0,
            autobaud_detection: 0,
            eeprom_error: 0,
            cmd_param_error: 0,
            faults: Faults::NONE,
            shift: 0,
        };
        let mut bit = 0;
        while bit < 8 {
            let mask = 1 << bit;
            match bits[bit as usize].condition {
                Condition::Never => {}
                Condition::DefaultParam => masks.default_param |= mask,
                Condition::AutobaudDetection => masks.autobaud_detection |= mask,
                Condition::EepromError => masks.eeprom_error |= mask,
                Condition::CmdParamError => masks.cmd_param_error |= mask,
                Condition::Fault(fault) => {
                    assert!(fault.0.is_power_of_two(), "one fault for each bit");
                    let place = fault.0.trailing_zeros();
                    // Counted so that it cannot be negative: the status byte is shifted, not the faults.
                    let shift = 8 + bit - place;
                    assert!(
                        masks.faults.0 == 0 || masks.shift == shift,
                        "faults must be in the order of their bits"
                    );
                    masks.shift = shift;
                    masks.faults = masks.faults.and(fault);
                }
            }
            bit += 1;
        }
        masks
    }

    /// The bits that stay until the status is read.
    pub const fn sticky(&self) -> u8 {
        self.eeprom_error | self.cmd_param_error
    }

    /// The bits of active faults.
    pub const fn of_faults(&self, faults: Faults) -> u8 {
        ((((faults.0 & self.faults.0) as u32) << self.shift) >> 8) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn bit(condition: Condition) -> StatusBit {
        StatusBit {
            name: "",
            condition,
        }
    }

    #[test]
    fn faults_set_the_bits_of_the_table() {
        let mut bits = [bit(Condition::Never); 8];
        bits[0] = bit(Condition::CmdParamError);
        bits[6] = bit(Condition::Fault(Faults::X));
        bits[7] = bit(Condition::Fault(Faults::Y));
        let masks = StatusMasks::of(&bits);
        assert_eq!(masks.cmd_param_error, 1);
        assert_eq!(masks.sticky(), 1);
        assert_eq!(masks.of_faults(Faults::X), 0x40);
        assert_eq!(masks.of_faults(Faults::X.and(Faults::Y)), 0xC0);
        assert_eq!(masks.of_faults(Faults::WARM_UP), 0);
        bits = [bit(Condition::Never); 8];
        bits[0] = bit(Condition::Fault(Faults::X));
        assert_eq!(StatusMasks::of(&bits).of_faults(Faults::X), 0x01);
    }

    #[test]
    #[should_panic(expected = "in the order of their bits")]
    fn faults_in_another_order_are_refused() {
        let mut bits = [bit(Condition::Never); 8];
        bits[4] = bit(Condition::Fault(Faults::Y));
        bits[5] = bit(Condition::Fault(Faults::X));
        StatusMasks::of(&bits);
    }
}
