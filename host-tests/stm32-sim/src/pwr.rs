//! Power control (RM0008, chapter 5; RM0390, chapter 5): the supply voltage and its detectors.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | PWR_CR | PVDE, PLS, DBP; VOS without effect; low-power modes are violations |
//! | 04h | PWR_CSR | PVDO |
//!
//! The supply is an input: it changes linearly from one voltage to another. The programmable detector (PVD) compares it with the
//! level that the firmware has selected. The power-down reset, or the brown-out reset if the option bytes enable it, holds the
//! microcontroller while the supply is lower than its threshold. The thresholds are those of the chip ([`Limits`]).
//!
//! Assumptions, which no board has confirmed:
//!
//! - All thresholds of a part are at the same position in their ranges ([`Part`]), and a detector responds without delay.
//! - The board has the option bytes of the README: the brown-out reset of the STM32F446 is on, with level 3.

use super::chip::Chip;
use super::io::AccessError;
use super::timebase::Picoseconds;
use super::violation::Violations;

/// The nominal supply in mV.
pub const NOMINAL: u32 = 3300;

/// A threshold in mV while the supply falls: lowest, typical, highest value of a part.
pub type Threshold = [u32; 3];

/// The limits and thresholds of the supply of a chip, in mV.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limits {
    /// The power-down reset: its threshold, and its hysteresis.
    pub power_down: (Threshold, u32),
    /// The same of the brown-out reset at the level of the README; None: the chip does not have it.
    pub brown_out: Option<(Threshold, u32)>,
    /// PVD at each level (PLS).
    pub detector: [Threshold; 8],
    /// The hysteresis of PVD: its thresholds are higher by this while the supply rises.
    pub detector_hysteresis: u32,
    /// The lowest supply for operations of the flash by bytes, half-words, words.
    pub programming: [u32; 3],
}

/// The position of the thresholds of a part in their ranges.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Part {
    /// The lowest of each range.
    Lowest,
    /// The typical thresholds.
    #[default]
    Typical,
    /// The highest of each range.
    Highest,
}

// PWR_CR.
const LOW_POWER: u32 = 0b11;
const CLEAR_FLAGS: u32 = 0b11 << 2;
const DETECTOR_ENABLE: u32 = 1 << 4;
const LEVEL_SHIFT: u32 = 5;
const BACKUP_ACCESS: u32 = 1 << 8;
/// VOS, only on the STM32F446. It has no effect.
const VOLTAGE_SCALE: u32 = 0b11 << 14;
/// FISSR and FMSSR, only on the STM32F446: the flash stops while the processor runs.
const FLASH_STOP: u32 = 0b11 << 20;
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
    /// A constant supply of the nominal voltage.
    fn default() -> Self {
        Self {
            from: (0, NOMINAL),
            to: (0, NOMINAL),
        }
    }
}

impl Supply {
    /// The supply voltage in mV at a time.
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

    /// The time at which the voltage falls below `level`, or rises to it.
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
#[derive(Debug)]
pub struct Pwr {
    limits: &'static Limits,
    /// The voltage scale in PWR_CR, which is its value after a reset.
    scale: u32,
    part: Part,
    /// The option bytes enable the brown-out reset.
    brown_out: bool,
    control: u32,
    status: u32,
    /// PVDO when it was read last, for the hysteresis.
    low: bool,
    supply: Supply,
    /// The reset holds the microcontroller.
    down: bool,
}

impl Pwr {
    /// After power-on, with the nominal supply and typical thresholds.
    pub fn new(chip: Chip) -> Self {
        let scale = match chip {
            Chip::F103 => 0,
            Chip::F446 => VOLTAGE_SCALE,
        };
        Self {
            limits: &chip.facts().supply,
            part: Part::default(),
            brown_out: true,
            scale,
            control: scale,
            status: 0,
            low: false,
            supply: Supply::default(),
            down: false,
        }
    }

    /// A reset of the microcontroller. The supply stays.
    pub fn reset(&mut self) {
        (self.control, self.status, self.low) = (self.scale, 0, false);
    }

    /// Sets the thresholds of this part.
    pub fn set_part(&mut self, part: Part) {
        self.part = part;
    }

    /// Disables the brown-out reset, as in a new part. FLASH_OPTCR does not show it.
    pub fn disable_brown_out(&mut self) {
        self.brown_out = false;
    }

    /// The supply in mV below which the microcontroller is reset, and the one from which it starts again.
    fn reset_levels(&self) -> (u32, u32) {
        let brown_out = self.limits.brown_out.filter(|_| self.brown_out);
        let (falling, hysteresis) = brown_out.unwrap_or(self.limits.power_down);
        let falling = falling[self.part as usize];
        (falling, falling + hysteresis)
    }

    /// The supply in mV below which the microcontroller is reset.
    pub fn reset_level(&self) -> u32 {
        self.reset_levels().0
    }

    /// From now on the supply changes to `millivolts`, within `length`.
    pub fn ramp(&mut self, now: Picoseconds, millivolts: u32, length: Picoseconds) {
        self.supply = Supply {
            from: (now, self.supply.at(now)),
            to: (now + length, millivolts),
        };
    }

    /// The supply voltage over time.
    pub fn supply(&self) -> Supply {
        self.supply
    }

    /// When the reset by the supply next begins or ends.
    pub fn next_event(&self) -> Option<Picoseconds> {
        let (falling, rising) = self.reset_levels();
        if self.down {
            self.supply.crosses(rising, true)
        } else {
            self.supply.crosses(falling, false)
        }
    }

    /// True while the reset by the supply holds the microcontroller.
    pub fn is_down(&self) -> bool {
        self.down
    }

    /// Updates the reset by the supply; true if it begins now.
    pub fn goes_down(&mut self, now: Picoseconds) -> bool {
        let before = self.down;
        let (falling, rising) = self.reset_levels();
        let limit = if before { rising } else { falling };
        self.down = self.supply.at(now) < limit;
        self.down && !before
    }

    /// PVDO: the supply is below the selected level.
    fn detect(&mut self, now: Picoseconds) -> bool {
        let selected = self.control >> LEVEL_SHIFT & 0b111;
        let level = self.limits.detector[selected as usize][self.part as usize];
        let level = if self.low {
            level + self.limits.detector_hysteresis
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

    /// A disturbance inverts bits of PWR_CR. False if the register does not have all of them.
    pub fn disturb(&mut self, offset: u32, bits: u32) -> bool {
        // CWUF and CSBF are commands.
        let defined = if self.scale == 0 { 0x1F3 } else { 0x003F_EFF3 };
        let defined = offset == 0 && bits & !defined == 0;
        if defined {
            self.control ^= bits;
        }
        defined
    }

    /// True if the processor cannot read the flash.
    pub fn stops_flash(&self) -> bool {
        self.control & FLASH_STOP != 0
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
                let writable = WRITABLE | self.scale;
                violations.check(
                    value & !(writable | CLEAR_FLAGS) != 0,
                    "PWR_CR",
                    "reserved bits are written",
                );
                self.control = value & writable;
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
    fn detector(chip: Chip, level: u32) -> Pwr {
        let mut pwr = Pwr::new(chip);
        let mut violations = Violations::default();
        let control = DETECTOR_ENABLE | level << LEVEL_SHIFT;
        pwr.write(0x00, control, &mut violations).unwrap();
        assert!(violations.list().is_empty());
        pwr
    }

    #[test]
    fn detector_has_eight_levels_with_hysteresis() {
        // PVD selection: the values of the falling edge in mV, and 100 mV of hysteresis.
        use Chip::{F103, F446};
        use Part::{Highest, Lowest, Typical};
        for (chip, level, part, falling) in [
            (F103, 0, Typical, 2080),
            (F103, 3, Typical, 2380),
            (F103, 7, Typical, 2780),
            (F103, 7, Lowest, 2660),
            (F103, 7, Highest, 2900),
            (F446, 0, Typical, 2040),
            (F446, 5, Lowest, 2650),
            (F446, 6, Lowest, 2850),
            (F446, 6, Typical, 2930),
            (F446, 6, Highest, 2990),
        ] {
            let mut pwr = detector(chip, level);
            pwr.set_part(part);
            let mut low = |millivolts| {
                pwr.ramp(0, millivolts, 0);
                pwr.read(0, 0x04).unwrap() & DETECTOR_OUTPUT != 0
            };
            assert!(!low(falling), "{chip:?} {level}");
            assert!(low(falling - 1));
            assert!(low(falling + 99));
            assert!(!low(falling + 100));
        }
    }

    #[test]
    fn detector_that_is_off_reports_nothing() {
        for chip in Chip::ALL {
            let mut pwr = Pwr::new(chip);
            pwr.ramp(0, 2000, 0);
            assert_eq!(pwr.read(0, 0x04), Ok(0));
        }
    }

    #[test]
    fn supply_changes_linearly() {
        let mut pwr = Pwr::new(Chip::F103);
        pwr.ramp(MILLISECOND, 1300, 2 * MILLISECOND);
        let supply = pwr.supply();
        assert_eq!(supply.at(0), 3300);
        assert_eq!(supply.at(2 * MILLISECOND), 2300);
        assert_eq!(supply.at(9 * MILLISECOND), 1300);
        assert_eq!(supply.lowest(0, 2 * MILLISECOND), 2300);
    }

    #[test]
    fn reset_by_the_supply_has_hysteresis() {
        for chip in Chip::ALL {
            let mut pwr = Pwr::new(chip);
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

    #[test]
    fn brown_out_reset_of_stm32f446_has_level_3() {
        let mut pwr = Pwr::new(Chip::F446);
        // DS10693: 2.75 to 2.88 V.
        for (part, level) in [
            (Part::Lowest, 2750),
            (Part::Typical, 2830),
            (Part::Highest, 2880),
        ] {
            pwr.set_part(part);
            pwr.ramp(0, level, 0);
            assert!(!pwr.goes_down(0));
            pwr.ramp(0, level - 1, 0);
            assert!(pwr.goes_down(0));
            pwr.ramp(0, NOMINAL, 0);
            pwr.goes_down(0);
        }
        pwr.disable_brown_out();
        pwr.ramp(0, 1800, 0);
        assert!(!pwr.goes_down(0));
        pwr.ramp(0, 1500, 0);
        assert!(pwr.goes_down(0));
    }
}
