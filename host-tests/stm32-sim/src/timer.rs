//! A general-purpose timer as a source of PWM (RM0008, chapter 15): counting up, PWM mode 1.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | TIMx_CR1 | CEN, URS, ARPE |
//! | 04h, 08h | TIMx_CR2, TIMx_SMCR | 0: neither trigger nor slave mode |
//! | 14h | TIMx_EGR | UG |
//! | 18h, 1Ch | TIMx_CCMR1, TIMx_CCMR2 | mode and preload of the channels |
//! | 20h | TIMx_CCER | enables the outputs of the channels |
//! | 28h, 2Ch | TIMx_PSC, TIMx_ARR | prescaler and period |
//! | 34h..40h | TIMx_CCR1..4 | compare values |
//!
//! A preloaded value takes effect at an update event (UG, or the end of a period). A period is short compared with any
//! observation of the duty, so the compare value of a running counter takes effect at once. All other functions, especially
//! interrupts, are violations or refused.

use super::io::AccessError;
use super::violation::Violations;

// TIMx_CR1.
const ENABLE: u32 = 1 << 0;
const UPDATE_SOURCE: u32 = 1 << 2;
const ONE_PULSE: u32 = 1 << 3;
const PRELOAD: u32 = 1 << 7;

/// The bits of TIMx_CR2 and TIMx_SMCR.
pub(super) const TRIGGER: [u32; 2] = [0x00F8, 0xFFF7];
/// TIMx_SMCR: a trigger controls the counter.
pub(super) const SLAVE_MODE: u32 = 0b111;

/// UG in TIMx_EGR.
const UPDATE: u32 = 1 << 0;

/// A channel's byte in TIMx_CCMRx: PWM mode 1 as an output; OCxPE may be set or not.
const PWM_1: u32 = 0b110 << 4;
const CHANNEL_PRELOAD: u32 = 1 << 3;

/// A general-purpose timer, TIM2 to TIM4.
#[derive(Clone, Debug, Default)]
pub struct Timer {
    control: u32,
    /// TIMx_CR2 and TIMx_SMCR.
    trigger: [u32; 2],
    modes: [u32; 2],
    outputs: u32,
    prescaler: u32,
    /// The value of TIMx_PSC at the last update event.
    prescaler_in_force: u32,
    period: u32,
    compares: [u32; 4],
}

impl Timer {
    /// The frequency of the PWM in Hz for a counter clock of `clock` Hz; None while the counter is stopped.
    pub fn frequency(&self, clock: u32) -> Option<f64> {
        let ticks = f64::from(self.prescaler_in_force + 1) * f64::from(self.period + 1);
        self.counts().then(|| f64::from(clock) / ticks)
    }

    /// The duty of a channel (1 to 4) in permille, rounded to nearest; None when the channel has no PWM output.
    pub fn duty(&self, channel: usize) -> Option<u16> {
        let index = channel.checked_sub(1)?;
        let mode = self.modes.get(index / 2)? >> (8 * (index % 2)) & 0xFF;
        let reaches_pin = self.outputs >> (4 * index) & 1 != 0;
        if !self.counts() || mode & !CHANNEL_PRELOAD != PWM_1 || !reaches_pin {
            return None;
        }
        let period = self.period + 1;
        // High while the counter is below the compare value; always high when the compare value exceeds the period.
        let high = self.compares[index].min(period);
        Some(((high * 1000 + period / 2) / period) as u16)
    }

    /// TIMx_CCER: bit 4 n - 4 enables channel n.
    pub fn enabled(&self) -> u32 {
        self.outputs
    }

    /// With a period of 0 the counter is blocked (RM0008, TIMx_ARR), in a slave mode it waits for a trigger.
    fn counts(&self) -> bool {
        let [_, slave] = self.trigger;
        self.control & ENABLE != 0 && self.period > 0 && slave & SLAVE_MODE == 0
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Result<u32, AccessError> {
        Ok(match offset {
            0x00 => self.control,
            0x04 | 0x08 => self.trigger[(offset as usize - 0x04) / 4],
            0x18 | 0x1C => self.modes[(offset as usize - 0x18) / 4],
            0x20 => self.outputs,
            0x28 => self.prescaler,
            0x2C => self.period,
            0x34..=0x40 => self.compares[(offset as usize - 0x34) / 4],
            _ => return Err(AccessError::Refused("TIM: register not modelled")),
        })
    }

    /// A disturbance inverts bits of a register with 16 bits. False if it does not have all of them.
    ///
    /// Neither direction nor alignment of the counter change the duty. With OPM the counter stops at its next update event.
    pub fn disturb(&mut self, offset: u32, bits: u32) -> bool {
        let (register, defined) = match offset {
            0x00 => (&mut self.control, 0x3FF),
            0x04 | 0x08 => {
                let place = (offset as usize - 0x04) / 4;
                (&mut self.trigger[place], TRIGGER[place])
            }
            0x18 | 0x1C => (&mut self.modes[(offset as usize - 0x18) / 4], 0xFFFF),
            0x20 => (&mut self.outputs, 0x3333),
            0x28 => (&mut self.prescaler, 0xFFFF),
            0x2C => (&mut self.period, 0xFFFF),
            0x34..=0x40 => (&mut self.compares[(offset as usize - 0x34) / 4], 0xFFFF),
            _ => return false,
        };
        if bits & !defined != 0 {
            return false;
        }
        *register ^= bits;
        if self.control & ONE_PULSE != 0 {
            self.control &= !ENABLE;
        }
        true
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        let value = value & 0xFFFF;
        match offset {
            0x00 => {
                let known = ENABLE | UPDATE_SOURCE | PRELOAD;
                violations.check(value & !known != 0, "TIMx_CR1", "not modelled");
                self.control = value & known;
            }
            0x04 | 0x08 => {
                violations.check(value != 0, "TIMx_CR2, TIMx_SMCR", "not modelled");
                let place = (offset as usize - 0x04) / 4;
                self.trigger[place] = value & TRIGGER[place];
            }
            0x14 => {
                violations.check(value & !UPDATE != 0, "TIMx_EGR", "not modelled");
                if value & UPDATE != 0 {
                    self.prescaler_in_force = self.prescaler;
                }
            }
            0x18 | 0x1C => {
                let known = |mode| matches!(mode & !CHANNEL_PRELOAD, 0 | PWM_1);
                violations.check(
                    !known(value & 0xFF) || !known(value >> 8),
                    "TIMx_CCMRx",
                    "not modelled: neither frozen nor PWM mode 1",
                );
                self.modes[(offset as usize - 0x18) / 4] = value;
            }
            0x20 => {
                violations.check(value & !0x1111 != 0, "TIMx_CCER", "not modelled");
                // CCxE and CCxP.
                self.outputs = value & 0x3333;
            }
            0x28 => self.prescaler = value,
            0x2C => self.period = value,
            0x34..=0x40 => self.compares[(offset as usize - 0x34) / 4] = value,
            _ => return Err(AccessError::Refused("TIM: register not modelled")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A timer after these writes, without violations.
    fn after(writes: &[(u32, u32)]) -> Timer {
        let (mut timer, mut violations) = (Timer::default(), Violations::default());
        for &(offset, value) in writes {
            timer.write(offset, value, &mut violations).unwrap();
        }
        assert_eq!(violations.list(), []);
        timer
    }

    /// Channel 3 at 1 kHz from 64 MHz: PSC 63, ARR 999, UG, PWM mode 1 with preload, CC3E, CEN.
    const SET_UP: [(u32, u32); 6] = [
        (0x28, 63),
        (0x2C, 999),
        (0x14, 1),
        (0x1C, 0x68),
        (0x20, 0x100),
        (0x00, 0x81),
    ];

    #[test]
    fn duty_is_compare_value_divided_by_period() {
        for (compare, permille) in [
            (0, 0),
            (1, 1),
            (250, 250),
            (999, 999),
            (1000, 1000),
            (65_535, 1000),
        ] {
            let timer = after(&[&SET_UP[..], &[(0x3C, compare)]].concat());
            assert_eq!(timer.duty(3), Some(permille));
            assert_eq!([1, 2, 4].map(|channel| timer.duty(channel)), [None; 3]);
            assert_eq!(timer.frequency(64_000_000), Some(1000.0));
        }
    }

    #[test]
    fn each_set_up_step_is_required() {
        for left_out in [1, 3, 4, 5] {
            let mut writes = SET_UP.to_vec();
            writes.remove(left_out);
            assert_eq!(after(&writes).duty(3), None, "{left_out}");
        }
        let mut writes = SET_UP.to_vec();
        writes.remove(2);
        let frequency = after(&writes).frequency(64_000_000);
        assert_eq!(
            frequency,
            Some(64_000.0),
            "the prescaler needs an update event"
        );
    }

    #[test]
    fn slave_mode_stops_the_counter() {
        let mut timer = after(&SET_UP);
        timer
            .write(0x08, 0b101, &mut Violations::default())
            .unwrap();
        assert_eq!(timer.duty(3), None);
    }

    #[test]
    fn functions_not_modelled_are_reported() {
        for (offset, value) in [
            (0x00, 0x10),
            (0x04, 0x10),
            (0x08, 1),
            (0x14, 2),
            (0x18, 0x70),
            (0x20, 2),
        ] {
            let mut violations = Violations::default();
            Timer::default()
                .write(offset, value, &mut violations)
                .unwrap();
            assert_eq!(violations.list().len(), 1, "{offset:#x}");
        }
        let mut violations = Violations::default();
        assert!(Timer::default().write(0x0C, 1, &mut violations).is_err());
        assert!(Timer::default().read(0x24).is_err());
    }
}
