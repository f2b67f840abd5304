//! A general-purpose timer that captures the edges of one input (RM0008, chapter 15): channels 3 and 4 as input capture on TI3.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | TIMx_CR1 | CEN |
//! | 0Ch | TIMx_DIER | CC3IE, CC4IE |
//! | 10h | TIMx_SR | CC3IF, CC4IF, CC3OF, CC4OF |
//! | 14h | TIMx_EGR | UG |
//! | 1Ch | TIMx_CCMR2 | CC3S = 01, CC4S = 10 (both on TI3), IC3F, IC4F |
//! | 20h | TIMx_CCER | CC3E, CC3P, CC4E, CC4P |
//! | 24h, 28h | TIMx_CNT, TIMx_PSC | counter and prescaler |
//! | 2Ch | TIMx_ARR | FFFFh; with 0 the counter does not count |
//! | 3Ch, 40h | TIMx_CCR3, TIMx_CCR4 | captured counter |
//!
//! Both edges of a pulse pass the input filter with the same delay, so it is not modelled. The use of any other
//! function is a violation or is refused.

use super::io::AccessError;
use super::timebase::{Picoseconds, SECOND};
use super::timer::{SLAVE_MODE, TRIGGER};
use super::violation::Violations;

/// CEN in TIMx_CR1.
const ENABLE: u32 = 1 << 0;

/// UG in TIMx_EGR.
const UPDATE: u32 = 1 << 0;

/// A channel that captures the input.
#[derive(Clone, Copy)]
struct Channel {
    /// Its field in TIMx_CCMR2, and the value for TI3.
    selection: (u32, u32),
    /// CCxE in TIMx_CCER; CCxP is the next bit.
    enable: u32,
    /// CCxIF in TIMx_SR, and CCxIE in TIMx_DIER.
    flag: u32,
    /// The bits CCxOF of TIMx_SR: a capture was lost.
    overcapture: u32,
}

const CHANNELS: [Channel; 2] = [
    Channel {
        selection: (0b11, 0b01),
        enable: 1 << 8,
        flag: 1 << 3,
        overcapture: 1 << 11,
    },
    Channel {
        selection: (0b11 << 8, 0b10 << 8),
        enable: 1 << 12,
        flag: 1 << 4,
        overcapture: 1 << 12,
    },
];

/// The filters IC3F and IC4F in TIMx_CCMR2.
const FILTERS: u32 = 0xF0F0;

/// TIM4 with an input on channel 3.
#[derive(Clone, Debug, Default)]
pub struct CaptureTimer {
    control: u32,
    /// TIMx_CR2 and TIMx_SMCR.
    trigger: [u32; 2],
    interrupts: u32,
    flags: u32,
    modes: u32,
    edges: u32,
    prescaler: u32,
    /// The value of TIMx_PSC at the last update event.
    prescaler_in_force: u32,
    /// TIMx_ARR. The reset value is 0 in the SVD, and FFFFh in some revisions of the manual.
    period: u32,
    /// A value of the counter, and its time.
    counted: (u16, Picoseconds),
    captured: [u32; 2],
}

impl CaptureTimer {
    /// The level of its interrupt line.
    pub fn interrupt(&self) -> bool {
        self.flags & self.interrupts != 0
    }

    /// Handles an edge at the input. `clock` is the clock of the prescaler in Hz.
    pub fn edge(&mut self, now: Picoseconds, clock: u32, rising: bool) {
        let [_, slave] = self.trigger;
        if self.control & ENABLE == 0 || slave & SLAVE_MODE != 0 {
            return;
        }
        let counter = self.counter(now, clock);
        for (channel, captured) in CHANNELS.into_iter().zip(&mut self.captured) {
            let (field, input) = channel.selection;
            let falling = self.edges & channel.enable << 1 != 0;
            let enabled = self.edges & channel.enable != 0 && self.modes & field == input;
            if !enabled || falling == rising {
                continue;
            }
            if self.flags & channel.flag != 0 {
                self.flags |= channel.overcapture;
            }
            self.flags |= channel.flag;
            *captured = counter.into();
        }
    }

    /// TIMx_CCER: bit 4 n - 4 enables channel n.
    pub fn enabled(&self) -> u32 {
        self.edges
    }

    fn counter(&self, now: Picoseconds, clock: u32) -> u16 {
        let (counter, since) = self.counted;
        if self.control & ENABLE == 0 || self.period == 0 {
            return counter;
        }
        let ticks = u128::from(now.saturating_sub(since)) * u128::from(clock)
            / (u128::from(SECOND) * u128::from(self.prescaler_in_force + 1));
        counter.wrapping_add(ticks as u16)
    }

    /// Reads the register at `offset`. Reading a captured value clears its flag.
    pub fn read(&mut self, now: Picoseconds, clock: u32, offset: u32) -> Result<u32, AccessError> {
        Ok(match offset {
            0x00 => self.control,
            0x04 | 0x08 => self.trigger[(offset as usize - 0x04) / 4],
            0x0C => self.interrupts,
            0x10 => self.flags,
            0x1C => self.modes,
            0x20 => self.edges,
            0x24 => self.counter(now, clock).into(),
            0x28 => self.prescaler,
            0x2C => self.period,
            0x3C | 0x40 => {
                let index = (offset as usize - 0x3C) / 4;
                self.flags &= !CHANNELS[index].flag;
                self.captured[index]
            }
            _ => return Err(AccessError::Refused("TIM4: register not modelled")),
        })
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        now: Picoseconds,
        clock: u32,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        let value = value & 0xFFFF;
        let all = |select: fn(Channel) -> u32| CHANNELS.into_iter().map(select).sum::<u32>();
        match offset {
            0x00 => {
                violations.check(value & !ENABLE != 0, "TIMx_CR1", "not modelled");
                self.counted = (self.counter(now, clock), now);
                self.control = value & ENABLE;
            }
            0x04 | 0x08 => {
                violations.check(value != 0, "TIMx_CR2, TIMx_SMCR", "not modelled");
                let place = (offset as usize - 0x04) / 4;
                self.trigger[place] = value & TRIGGER[place];
            }
            0x0C => {
                let known = all(|channel| channel.flag);
                violations.check(value & !known != 0, "TIMx_DIER", "not modelled");
                self.interrupts = value & known;
            }
            // Flags are cleared by writing 0.
            0x10 => self.flags &= value,
            0x14 => {
                violations.check(value & !UPDATE != 0, "TIMx_EGR", "not modelled");
                if value & UPDATE != 0 {
                    self.prescaler_in_force = self.prescaler;
                    self.counted = (0, now);
                }
            }
            0x1C => {
                violations.check(
                    self.edges & all(|channel| channel.enable) != 0,
                    "TIMx_CCMR2",
                    "CCxS is writable only while the channel is off",
                );
                let known = |channel: Channel| {
                    let (field, input) = channel.selection;
                    value & field == 0 || value & field == input
                };
                violations.check(
                    !CHANNELS.into_iter().all(known)
                        || value & !(FILTERS | all(|channel| channel.selection.0)) != 0,
                    "TIMx_CCMR2",
                    "not modelled: not an input capture of TI3",
                );
                self.modes = value;
            }
            0x20 => {
                let known = all(|channel| 0b11 * channel.enable);
                violations.check(value & !known != 0, "TIMx_CCER", "not modelled");
                self.edges = value & known;
            }
            0x24 => self.counted = (value as u16, now),
            0x28 => self.prescaler = value,
            0x2C => {
                violations.check(value != 0xFFFF, "TIMx_ARR", "not modelled");
                self.counted = (self.counter(now, clock), now);
                self.period = value;
            }
            _ => return Err(AccessError::Refused("TIM4: register not modelled")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: u32 = 64_000_000;

    const US: Picoseconds = 1_000_000;

    /// A counter of 32 MHz: channel 3 captures rising edges with its interrupt, channel 4 falling edges.
    const SET_UP: [(u32, u32); 8] = [
        (0x28, 1),
        (0x14, 1),
        (0x24, 0x2000),
        (0x1C, 0x3231),
        (0x20, 0x3100),
        (0x0C, 1 << 3),
        (0x00, 1),
        (0x2C, 0xFFFF),
    ];

    /// A timer after these writes at time 0, without violations.
    fn after(writes: &[(u32, u32)]) -> CaptureTimer {
        let (mut timer, mut violations) = (CaptureTimer::default(), Violations::default());
        for &(offset, value) in writes {
            timer
                .write(0, CLOCK, offset, value, &mut violations)
                .unwrap();
        }
        assert_eq!(violations.list(), []);
        timer
    }

    #[test]
    fn pulse_is_captured_with_its_start_and_end() {
        let mut timer = after(&SET_UP);
        timer.edge(10 * US, CLOCK, false);
        assert!(!timer.interrupt());
        timer.edge(14 * US, CLOCK, true);
        assert!(timer.interrupt());
        let mut read = |offset| timer.read(20 * US, CLOCK, offset).unwrap();
        assert_eq!(read(0x10), 1 << 3 | 1 << 4);
        assert_eq!(read(0x40), 0x2000 + 320);
        assert_eq!(read(0x3C), 0x2000 + 448);
        assert_eq!(read(0x10), 0);
        assert_eq!(read(0x24), 0x2000 + 640);
        assert!(!timer.interrupt());
    }

    #[test]
    fn capture_that_was_not_read_is_overwritten() {
        let mut timer = after(&SET_UP);
        for us in [10, 20] {
            timer.edge(us * US, CLOCK, true);
        }
        assert_eq!(timer.read(0, CLOCK, 0x10), Ok(1 << 3 | 1 << 11));
        assert_eq!(timer.read(0, CLOCK, 0x3C), Ok(0x2000 + 640));
    }

    #[test]
    fn counter_overflows_after_16_bits() {
        let mut timer = after(&SET_UP);
        timer.edge(2048 * US, CLOCK, true);
        assert_eq!(timer.read(0, CLOCK, 0x3C), Ok(0x2000));
    }

    #[test]
    fn each_set_up_step_is_required() {
        for left_out in [3, 4, 5, 6] {
            let mut writes = SET_UP.to_vec();
            writes.remove(left_out);
            let mut timer = after(&writes);
            timer.edge(US, CLOCK, true);
            assert!(!timer.interrupt(), "{left_out}");
        }
        // With TIMx_ARR = 0 the counter does not count.
        let mut timer = after(&SET_UP[..7]);
        timer.edge(US, CLOCK, true);
        assert_eq!(timer.read(0, CLOCK, 0x3C), Ok(0x2000));
        // The prescaler needs an update event.
        let mut timer = after(&[&SET_UP[..1], &SET_UP[2..]].concat());
        timer.edge(US, CLOCK, true);
        assert_eq!(timer.read(0, CLOCK, 0x3C), Ok(0x2000 + 64));
    }

    #[test]
    fn functions_not_modelled_are_reported() {
        for (offset, value) in [
            (0x00, 0x81),
            (0x08, 1),
            (0x0C, 1),
            (0x14, 2),
            (0x1C, 1 << 8),
            (0x20, 1),
        ] {
            let mut violations = Violations::default();
            CaptureTimer::default()
                .write(0, CLOCK, offset, value, &mut violations)
                .unwrap();
            assert_eq!(violations.list().len(), 1, "{offset:#x}");
        }
        let mut violations = Violations::default();
        let mut timer = after(&SET_UP);
        timer
            .write(0, CLOCK, 0x1C, 0x3231, &mut violations)
            .unwrap();
        assert_eq!(violations.list().len(), 1, "the channels are on");
        assert!(timer.write(0, CLOCK, 0x18, 0, &mut violations).is_err());
        assert!(timer.read(0, CLOCK, 0x18).is_err());
    }
}
