//! Power control (RM0008, chapter 5): the supply voltage and its detectors.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | PWR_CR | PVDE, PLS, DBP; low-power modes are violations |
//! | 04h | PWR_CSR | PVDO |
//!
//! The supply is an input: it changes linearly from one voltage to another. The programmable detector (PVD) compares it with the
//! level that the firmware has selected. The power-down reset (PDR) is always on. The thresholds are typical ones (DS5319, table
//! "Embedded reset and power control block characteristics").
//!
//! Assumptions, which no board has confirmed:
//!
//! - Each part has exactly these thresholds, and a detector responds at once.
//! - The STM32F446 has the thresholds of the STM32F103, also the limit of the flash. Its datasheet has others: the firmware selects
//!   PVD level 6 as 2.85 V and more, which is 2.68 V here, and programming by words needs 2.7 V.
//! - The brown-out reset (BOR) of the STM32F446 is off, as in a new part. Its levels are not modelled.

use super::io::AccessError;
use super::timebase::Picoseconds;
use super::violation::Violations;

/// The usual supply in mV.
pub const NOMINAL: u32 = 3300;

/// Below this voltage in mV, the flash cannot be programmed or erased (DS5319, Vprog).
pub const PROGRAMMING_MIN: u32 = 2000;

/// The power-down reset in mV: below the first one, until above the second one.
const RESET_FALLING: u32 = 1880;
const RESET_RISING: u32 = 1920;

/// PVD in mV: its lowest level while falling, the step to the next level, and the hysteresis.
const DETECTOR_FALLING: u32 = 2080;
const DETECTOR_STEP: u32 = 100;
const DETECTOR_HYSTERESIS: u32 = 100;

// PWR_CR.
const LOW_POWER: u32 = 0b11;
const CLEAR_FLAGS: u32 = 0b11 << 2;
const DETECTOR_ENABLE: u32 = 1 << 4;
const LEVEL_SHIFT: u32 = 5;
const BACKUP_ACCESS: u32 = 1 << 8;
const WRITABLE: u32 = LOW_POWER | DETECTOR_ENABLE | 0b111 << LEVEL_SHIFT | BACKUP_ACCESS;

// PWR_CSR.
const DETECTOR_OUTPUT: u32 = 1 << 2;
const WAKE_UP_PIN: u32 = 1 << 8;

/// A change of the supply: from a time and voltage in mV to another.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Supply {
    from: (Picoseconds, u32),
    to: (Picoseconds, u32),
}

impl Default for Supply {
    /// Constant, with the usual voltage.
    fn default() -> Self {
        Self {
            from: (0, NOMINAL),
            to: (0, NOMINAL),
        }
    }
}

impl Supply {
    /// The voltage in mV.
    pub fn at(&self, now: Picoseconds) -> u32 {
        let ((start, from), (end, to)) = (self.from, self.to);
        if now >= end {
            return to;
        }
        let passed = u128::from(now.saturating_sub(start));
        let change = u128::from(from.abs_diff(to)) * passed / u128::from(end - start);
        if to < from {
            from - change as u32
        } else {
            from + change as u32
        }
    }

    /// The lowest voltage in this period, in mV.
    pub fn lowest(&self, from: Picoseconds, to: Picoseconds) -> u32 {
        self.at(from).min(self.at(to))
    }

    /// When the voltage falls below `level`, or rises to it.
    fn crosses(&self, level: u32, rising: bool) -> Option<Picoseconds> {
        let ((start, from), (end, to)) = (self.from, self.to);
        let (level, crosses) = if rising {
            (level, from < level && level <= to)
        } else {
            (level - 1, from >= level && level > to)
        };
        let part = u128::from(from.abs_diff(level)) * u128::from(end - start);
        crosses.then(|| start + part.div_ceil(u128::from(from.abs_diff(to))) as Picoseconds)
    }
}

/// PWR, and the supply of the microcontroller.
#[derive(Debug, Default)]
pub struct Pwr {
    control: u32,
    status: u32,
    /// PVDO at the last look, for the hysteresis.
    low: bool,
    supply: Supply,
    /// The power-down reset holds the microcontroller.
    down: bool,
}

impl Pwr {
    /// A reset of the microcontroller. The supply stays.
    pub fn reset(&mut self) {
        *self = Self {
            supply: self.supply,
            down: self.down,
            ..Self::default()
        };
    }

    /// From now on the supply changes to `millivolts`, within `length`.
    pub fn ramp(&mut self, now: Picoseconds, millivolts: u32, length: Picoseconds) {
        self.supply = Supply {
            from: (now, self.supply.at(now)),
            to: (now + length, millivolts),
        };
    }

    /// The supply.
    pub fn supply(&self) -> Supply {
        self.supply
    }

    /// When the power-down reset next begins or ends.
    pub fn next_event(&self) -> Option<Picoseconds> {
        if self.down {
            self.supply.crosses(RESET_RISING, true)
        } else {
            self.supply.crosses(RESET_FALLING, false)
        }
    }

    /// True while the power-down reset holds the microcontroller.
    pub fn is_down(&self) -> bool {
        self.down
    }

    /// Updates the power-down reset; true if it begins now.
    pub fn goes_down(&mut self, now: Picoseconds) -> bool {
        let before = self.down;
        let limit = if before { RESET_RISING } else { RESET_FALLING };
        self.down = self.supply.at(now) < limit;
        self.down && !before
    }

    /// PVDO: the supply is below the selected level.
    fn detect(&mut self, now: Picoseconds) -> bool {
        let level = DETECTOR_FALLING + DETECTOR_STEP * (self.control >> LEVEL_SHIFT & 0b111);
        let level = if self.low {
            level + DETECTOR_HYSTERESIS
        } else {
            level
        };
        self.low = self.control & DETECTOR_ENABLE != 0 && self.supply.at(now) < level;
        self.low
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, now: Picoseconds, offset: u32) -> Result<u32, AccessError> {
        match offset {
            0x00 => Ok(self.control),
            0x04 if self.detect(now) => Ok(self.status | DETECTOR_OUTPUT),
            0x04 => Ok(self.status),
            _ => Err(AccessError::Unmapped),
        }
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x00 => {
                violations.check(value & LOW_POWER != 0, "PWR_CR", "low power not modelled");
                violations.check(
                    value & !(WRITABLE | CLEAR_FLAGS) != 0,
                    "PWR_CR",
                    "reserved bits are written",
                );
                self.control = value & WRITABLE;
            }
            0x04 => self.status = value & WAKE_UP_PIN,
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::timebase::MICROSECOND;
    use super::*;

    const MILLISECOND: Picoseconds = 1000 * MICROSECOND;

    /// PVD on at this level.
    fn detector(level: u32) -> Pwr {
        let mut pwr = Pwr::default();
        let mut violations = Violations::default();
        let control = DETECTOR_ENABLE | level << LEVEL_SHIFT;
        pwr.write(0x00, control, &mut violations).unwrap();
        assert!(violations.list().is_empty());
        pwr
    }

    #[test]
    fn detector_has_eight_levels_with_hysteresis() {
        // DS5319: PVD selection, typical values of the falling and rising edge in mV
        for (level, falling, rising) in [(0, 2080, 2180), (3, 2380, 2480), (7, 2780, 2880)] {
            let mut pwr = detector(level);
            let mut low = |millivolts| {
                pwr.ramp(0, millivolts, 0);
                pwr.read(0, 0x04).unwrap() & DETECTOR_OUTPUT != 0
            };
            assert!(!low(falling));
            assert!(low(falling - 1));
            assert!(low(rising - 1));
            assert!(!low(rising));
        }
    }

    #[test]
    fn detector_that_is_off_reports_nothing() {
        let mut pwr = Pwr::default();
        pwr.ramp(0, 2000, 0);
        assert_eq!(pwr.read(0, 0x04), Ok(0));
    }

    #[test]
    fn supply_changes_linearly() {
        let mut pwr = Pwr::default();
        pwr.ramp(MILLISECOND, 1300, 2 * MILLISECOND);
        let supply = pwr.supply();
        assert_eq!(supply.at(0), 3300);
        assert_eq!(supply.at(2 * MILLISECOND), 2300);
        assert_eq!(supply.at(9 * MILLISECOND), 1300);
        assert_eq!(supply.lowest(0, 2 * MILLISECOND), 2300);
    }

    #[test]
    fn power_down_reset_has_hysteresis() {
        let mut pwr = Pwr::default();
        assert_eq!(pwr.next_event(), None);
        pwr.ramp(0, 1300, 2 * MILLISECOND);
        let down = pwr.next_event().unwrap();
        assert!(!pwr.goes_down(down - MICROSECOND));
        assert!(pwr.goes_down(down) && pwr.is_down());
        assert_eq!(pwr.next_event(), None);
        pwr.ramp(down, 3300, MILLISECOND);
        let up = pwr.next_event().unwrap();
        pwr.goes_down(up - MICROSECOND);
        assert!(pwr.is_down());
        pwr.goes_down(up);
        assert!(!pwr.is_down());
    }
}
