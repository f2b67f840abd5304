//! The status byte (tables 14 and 15), built when a reply is sent.
//!
//! ```text
//!  bit 7   6                5             4              3              2             1                  0
//!    0     AccuracyWarning  SensorErrorY  SensorErrorX   CmdParamError  EEPROMError   AutobaudDetection  DefaultParam
//!                           (2-axis)      or SensorError
//! ```

use crate::application::Faults;
use crate::mistake::{Mistake, Origin};
use crate::walk::each;

/// The condition that sets a bit of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// Never set: the bit is reserved.
    Never,
    /// All parameters have their factory values.
    DefaultParam,
    /// The bit rate is detected automatically.
    AutobaudDetection,
    /// An access to the nonvolatile memory failed. Sticky: reading the status clears it.
    EepromError,
    /// A request had an invalid code or parameter, or a function failed. Sticky: reading the status clears it.
    CmdParamError,
    /// At least one of these faults of the application is active.
    Fault(Faults),
}

/// A bit of the status byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StatusBit {
    /// The name in the manual; empty for a reserved bit.
    pub name: &'static str,
    /// The condition that sets it.
    pub condition: Condition,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl StatusBit {
    /// A bit that this condition sets.
    #[track_caller]
    pub const fn new(name: &'static str, condition: Condition) -> Self {
        Self {
            name,
            condition,
            origin: Origin::here(),
        }
    }
}

/// The description of the status byte in the form that the device uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct StatusMasks {
    pub default_param: u8,
    pub autobaud_detection: u8,
    pub eeprom_error: u8,
    pub cmd_param_error: u8,
    /// The faults that have a bit.
    faults: Faults,
    /// The left shift from the faults to the status byte, plus 8.
    shift: u32,
}

impl StatusMasks {
    /// Projects the description. It is a compile error if a bit has two faults, or if the faults are not in the order of their
    /// bits.
    #[track_caller]
    pub const fn of(bits: &[StatusBit; 8]) -> Self {
        let mut masks = Self {
            default_param: 0,
            autobaud_detection: 0,
            eeprom_error: 0,
            cmd_param_error: 0,
            faults: Faults::NONE,
            shift: 0,
        };
        each!(bit, StatusBit { condition, origin, .. } in bits => {
            let mask = 1 << bit;
            match *condition {
                Condition::Never => {}
                Condition::DefaultParam => masks.default_param |= mask,
                Condition::AutobaudDetection => masks.autobaud_detection |= mask,
                Condition::EepromError => masks.eeprom_error |= mask,
                Condition::CmdParamError => masks.cmd_param_error |= mask,
                Condition::Fault(fault) => {
                    let mistake = Mistake::row("status bit", bit).at(*origin);
                    mistake.unless(fault.0.is_power_of_two(), "it has exactly one fault");
                    let place = fault.0.trailing_zeros();
                    mistake.unless(place <= 8 + bit as u32, "this fault has no place in this bit");
                    // The offset of 8 keeps the shift from being negative; `of_faults` removes it.
                    let shift = 8 + bit as u32 - place;
                    mistake.unless(
                        masks.faults.0 == 0 || masks.shift == shift,
                        "the faults must be in the order of their bits",
                    );
                    masks.shift = shift;
                    masks.faults = masks.faults.and(fault);
                }
            }
        });
        masks
    }

    /// The sticky bits: they stay set until the status is read.
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
        StatusBit::new("", condition)
    }

    #[test]
    fn faults_set_bits_of_table() {
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
}
