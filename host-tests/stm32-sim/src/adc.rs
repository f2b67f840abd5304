//! The analog-to-digital converter ADC1 (RM0008, chapter 11; RM0390, chapter 13): single conversions of one channel, started by
//! software, at the divider of the sensor's supply.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | ADC_SR | EOC, STRT |
//! | 04h | ADC_CR1 | must be 0: interrupts, scan mode, watchdog and resolution are not modelled |
//! | 08h | ADC_CR2 | ADON; calibration (STM32F103); start by ADON or SWSTART |
//! | 0Ch, 10h | ADC_SMPR1, ADC_SMPR2 | sampling time of the channels |
//! | 2Ch..34h | ADC_SQR1..3 | one channel |
//! | 4Ch | ADC_DR | data, right-aligned |
//! | 300h, 304h | ADC_CSR, ADC_CCR | STM32F446: flags of ADC1, prescaler of the clock |
//!
//! Injected channels (JOFR, JSQR, JDR), the analog watchdog (HTR, LTR) and the data of several converters (CDR) are not modelled.
//! A conversion that the datasheet does not permit is a violation: the clock is too fast, the converter has just been switched on or
//! is not calibrated, the pin is not analog, or the sampling time is too short for the resistance of the divider.

use super::chip::Chip;
use super::io::AccessError;
use super::timebase::{MICROSECOND, Picoseconds, SECOND};
use super::violation::Violations;

// ADC_SR.
const END_OF_CONVERSION: u32 = 1 << 1;
const STARTED: u32 = 1 << 4;

// ADC_CR2.
const ON: u32 = 1 << 0;
const CALIBRATE: u32 = 1 << 2;
const RESET_CALIBRATION: u32 = 1 << 3;
/// On the STM32F103: EXTSEL, SWSTART, and EXTTRIG.
const F103_EVENT: u32 = 0b111 << 17;
const F103_TRIGGER: u32 = 1 << 20;
const F103_START: u32 = 1 << 22;
const F446_START: u32 = 1 << 30;

/// The resistors of the divider at the pin, in ohm: from the supply, and to ground (README, wiring).
const DIVIDER: (f64, f64) = (100_000.0, 6_800.0);

/// What differs between the converters of the chips.
#[derive(Debug)]
struct Facts {
    /// The bits of ADC_CR1 and ADC_CR2 that exist.
    defined: [u32; 2],
    /// The bits of ADC_CR2 that are modelled.
    modelled: u32,
    /// The sampling times in half clocks, by code.
    sampling: [u32; 8],
    /// The time of a conversion after the sampling, in half clocks.
    conversion: u32,
    /// The highest clock in Hz.
    fastest: u32,
    /// The time from ADON to the first conversion (tSTAB).
    stable: Picoseconds,
    /// The switch resistance in ohm, and the capacitance in F, of the input.
    input: (f64, f64),
}

impl Facts {
    const fn of(chip: Chip) -> &'static Self {
        match chip {
            Chip::F103 => &F103,
            Chip::F446 => &F446,
        }
    }
}

/// RM0008, section 11.12; DS5319, 12-bit ADC characteristics.
static F103: Facts = Facts {
    defined: [0x00CF_FFFF, 0x00FE_F90F],
    modelled: ON | CALIBRATE | RESET_CALIBRATION | F103_EVENT | F103_TRIGGER | F103_START,
    sampling: [3, 15, 27, 57, 83, 111, 143, 479],
    conversion: 25,
    fastest: 14_000_000,
    stable: MICROSECOND,
    input: (1000.0, 8e-12),
};

/// RM0390, section 13.13; DS10693, ADC characteristics, at 2.4 V and more.
static F446: Facts = Facts {
    defined: [0x07C0_FFFF, 0x7F7F_0F03],
    modelled: ON | F446_START,
    sampling: [6, 30, 56, 112, 168, 224, 288, 960],
    conversion: 24,
    fastest: 36_000_000,
    stable: 3 * MICROSECOND,
    input: (6000.0, 7e-12),
};

/// What the converter needs for an access.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// The simulated time of the access.
    pub now: Picoseconds,
    /// The clock of the converter on the STM32F103, the clock of the bus on the STM32F446, in Hz.
    pub clock: u32,
    /// The pin at the divider is analog.
    pub is_analog: bool,
}

/// A conversion in progress.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Conversion {
    sampled: Picoseconds,
    end: Picoseconds,
}

/// The converter ADC1 with its channels.
#[derive(Debug)]
pub struct Adc {
    chip: Chip,
    /// The channel at the divider.
    channel: u32,
    status: u32,
    control: [u32; 2],
    /// ADC_SMPR1 and ADC_SMPR2: channels 10 to 18, channels 0 to 9.
    sampling: [u32; 2],
    /// ADC_SQR1 to ADC_SQR3, the sequence of conversions.
    sequence: [u32; 3],
    /// ADC_CCR, the register that all converters share (STM32F446).
    common: u32,
    data: u32,
    /// The time from which conversions are possible; None: it is off.
    stable_at: Option<Picoseconds>,
    /// The end of a calibration and of its reset.
    calibrating: [Option<Picoseconds>; 2],
    calibrated: bool,
    conversion: Option<Conversion>,
}

impl Adc {
    /// The converter after a reset: off. The divider is at this channel.
    pub fn new(chip: Chip, channel: u32) -> Self {
        Self {
            chip,
            channel,
            status: 0,
            control: [0; 2],
            sampling: [0; 2],
            sequence: [0; 3],
            common: 0,
            data: 0,
            stable_at: None,
            calibrating: [None; 2],
            calibrated: false,
            conversion: None,
        }
    }

    /// Completes what has ended. `measure` returns the supply of the sensor and of the microcontroller at a time, in mV.
    pub fn advance(&mut self, now: Picoseconds, measure: impl FnOnce(Picoseconds) -> (u32, u32)) {
        for (end, bit) in self
            .calibrating
            .iter_mut()
            .zip([CALIBRATE, RESET_CALIBRATION])
        {
            if end.take_if(|end| *end <= now).is_some() {
                self.control[1] &= !bit;
                self.calibrated = bit == CALIBRATE;
            }
        }
        if let Some(conversion) = self.conversion.take_if(|it| it.end <= now) {
            let is_supply = self.sequence[2] & 0x1F == self.channel;
            let (supply, reference) = measure(conversion.sampled);
            let (upper, lower) = DIVIDER;
            let pin = f64::from(supply) * lower / (upper + lower);
            let count = pin / f64::from(reference) * 4096.0;
            self.data = if is_supply {
                count.min(4095.0) as u32
            } else {
                0
            };
            self.status |= END_OF_CONVERSION;
        }
    }

    /// Reads the register at `offset`; [`advance`](Self::advance) comes first.
    pub fn read(&mut self, offset: u32) -> Result<u32, AccessError> {
        Ok(match (offset, self.chip) {
            (0x00, _) | (0x300, Chip::F446) => self.status,
            (0x04 | 0x08, _) => self.control[offset as usize / 4 - 1],
            (0x0C | 0x10, _) => self.sampling[offset as usize / 4 - 3],
            (0x2C..=0x34, _) => self.sequence[offset as usize / 4 - 11],
            (0x4C, _) => {
                self.status &= !END_OF_CONVERSION;
                self.data
            }
            (0x304, Chip::F446) => self.common,
            _ => return Err(AccessError::Refused("ADC: register not modelled")),
        })
    }

    /// Writes the register at `offset`; [`advance`](Self::advance) comes first.
    pub fn write(
        &mut self,
        offset: u32,
        value: u32,
        around: Surroundings,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        let facts = Facts::of(self.chip);
        match (offset, self.chip) {
            // A flag is cleared by writing 0.
            (0x00, _) => self.status &= value,
            (0x04, _) => {
                self.control[0] = value & facts.defined[0];
                violations.check(self.control[0] != 0, "ADC_CR1", "not modelled");
            }
            (0x08, _) => self.control(value & facts.defined[1], around, violations),
            (0x0C, Chip::F103) => self.sampling[0] = value & 0x00FF_FFFF,
            (0x0C, Chip::F446) => self.sampling[0] = value & 0x07FF_FFFF,
            (0x10, _) => self.sampling[1] = value & 0x3FFF_FFFF,
            (0x2C, _) => {
                self.sequence[0] = value & 0x00FF_FFFF;
                let length = value >> 20 & 0xF;
                violations.check(length != 0, "ADC_SQR1", "several channels: not modelled");
            }
            (0x30 | 0x34, _) => self.sequence[offset as usize / 4 - 11] = value & 0x3FFF_FFFF,
            (0x304, Chip::F446) => {
                self.common = value & 0x00C3_EF1F;
                let others = self.common & !(0b11 << 16);
                violations.check(others != 0, "ADC_CCR", "not modelled");
            }
            _ => return Err(AccessError::Refused("ADC: register not modelled")),
        }
        Ok(())
    }

    /// A write to ADC_CR2: switches the converter on, or starts a conversion.
    fn control(&mut self, value: u32, around: Surroundings, violations: &mut Violations) {
        const NAME: &str = "ADC_CR2";
        let facts = Facts::of(self.chip);
        let now = around.now;
        violations.check(value & !facts.modelled != 0, NAME, "not modelled");
        let changed = value ^ self.control[1];
        let was_on = self.control[1] & ON != 0;
        self.control[1] = value;
        if value & ON == 0 {
            (self.stable_at, self.conversion) = (None, None);
            self.control[1] &= !(CALIBRATE | F103_START | F446_START);
            return;
        }
        if !was_on {
            self.stable_at = Some(now + facts.stable);
        }
        let clock = self.clock(around);
        let clocks = |number: u64| SECOND * number / u64::from(clock.max(1));
        let starts = match self.chip {
            Chip::F103 => {
                for (index, bit) in [CALIBRATE, RESET_CALIBRATION].into_iter().enumerate() {
                    if changed & value & bit != 0 {
                        violations.check(
                            !was_on || self.stable_at > Some(now),
                            NAME,
                            "calibrated before the converter is stable",
                        );
                        // RM0008, figure 23 and DS5319: 83 clocks; the reset takes a few.
                        let time = if bit == CALIBRATE { 83 } else { 4 };
                        self.calibrating[index] = Some(now + clocks(time));
                    }
                }
                let by_software = F103_EVENT | F103_TRIGGER | F103_START;
                was_on && (changed == 0 || value & by_software == by_software)
            }
            Chip::F446 => value & F446_START != 0,
        };
        if starts {
            self.control[1] &= !(F103_START | F446_START);
            self.start(clock, around, violations);
        }
    }

    /// The clock of the converter in Hz.
    fn clock(&self, around: Surroundings) -> u32 {
        match self.chip {
            Chip::F103 => around.clock,
            Chip::F446 => around.clock / (2 * ((self.common >> 16 & 0b11) + 1)),
        }
    }

    fn start(&mut self, clock: u32, around: Surroundings, violations: &mut Violations) {
        const NAME: &str = "ADC_CR2";
        let facts = Facts::of(self.chip);
        let channel = self.sequence[2] & 0x1F;
        let register = self.sampling[usize::from(channel < 10)];
        let code = register >> (3 * (channel % 10)) & 0b111;
        let sampling = facts.sampling[code as usize];
        let half = SECOND as f64 / f64::from(clock.max(1)) / 2.0;
        let seconds = f64::from(sampling) * half / SECOND as f64;
        // To a quarter of the least significant bit (DS5319, equation 1; DS10693, the same).
        let (upper, lower) = DIVIDER;
        let (switch, capacitance) = facts.input;
        let resistance = upper * lower / (upper + lower) + switch;
        let needed = resistance * capacitance * f64::from(1 << 14).ln();
        for (wrong, reason) in [
            (clock > facts.fastest, "the clock is too fast"),
            (
                self.stable_at.is_none_or(|at| at > around.now),
                "converts before the converter is stable",
            ),
            (
                self.chip == Chip::F103 && !self.calibrated,
                "converts without calibration",
            ),
            (self.conversion.is_some(), "starts again while it converts"),
            (
                channel != self.channel,
                "nothing is connected to the channel",
            ),
            (!around.is_analog, "the pin is not analog"),
            (
                seconds < needed,
                "the sampling time is too short for the divider",
            ),
        ] {
            violations.check(wrong, NAME, reason);
        }
        let after = |halves: u32| around.now + (f64::from(halves) * half) as Picoseconds;
        self.status |= STARTED;
        self.conversion = Some(Conversion {
            sampled: after(sampling),
            end: after(sampling + facts.conversion),
        });
    }
}

#[cfg(test)]
mod tests;
