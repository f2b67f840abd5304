//! The status LEDs: four channels and their blink patterns (CiA 303-3).

use super::BusState;
use crate::time::{Deadline, Instant, after, millis, reached};

/// One item for each LED channel. A product with two LEDs uses the first two channels; a product with two two-colour LEDs uses
/// all.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Channels<T> {
    /// The run LED, green (CiA 303-3), or the green half of a network status LED.
    pub run: T,
    /// The error LED, red (CiA 303-3), or the red half of a network status LED.
    pub error: T,
    /// The green half of a module status LED.
    pub module_green: T,
    /// The red half of a module status LED.
    pub module_red: T,
}

/// Which LEDs are on now.
pub type Leds = Channels<bool>;

/// The pattern of each LED.
pub type Patterns = Channels<Pattern>;

impl Patterns {
    /// No LED is ever on.
    pub const DARK: Self = Self {
        run: Pattern::Off,
        error: Pattern::Off,
        module_green: Pattern::Off,
        module_red: Pattern::Off,
    };
}

/// The blink pattern of one LED.
///
/// The discriminant describes the pattern, so the device needs no table:
///
/// ```text
///  bit 7         6             5   4             3..0
///  +------------+-------------+---+-------------+----------------------------------+
///  | 4 phases,  | last phase  | 0 | permanently | time of a phase in units of      |
///  | otherwise 2| of 1000 ms  |   | on          | 50 ms; 0: the LED does not change|
///  +------------+-------------+---+-------------+----------------------------------+
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum Pattern {
    /// The LED stays dark.
    #[default]
    Off = 0x00,
    /// The LED stays on.
    On = 0x10,
    /// 50 ms on, 50 ms off.
    Flickering = 0x01,
    /// 200 ms on, 200 ms off.
    Blinking = 0x04,
    /// 500 ms on, 500 ms off.
    Flashing = 0x0A,
    /// 200 ms on, 1000 ms off.
    SingleFlash = PAUSE | 0x04,
    /// Twice 200 ms on with 200 ms between, then 1000 ms off.
    DoubleFlash = PAUSE | FOUR | 0x04,
}

/// Bits of the discriminant of a [`Pattern`].
const TIME: u8 = 0x0F;
const PAUSE: u8 = 0x40;
const FOUR: u8 = 0x80;

impl Pattern {
    /// Whether the LED switches on and off.
    const fn changes(self) -> bool {
        self as u8 & TIME != 0
    }

    /// The number of phases of a pattern that changes; a power of two. The phases are on and off in turn.
    const fn phases(self) -> u8 {
        if self as u8 & FOUR != 0 { 4 } else { 2 }
    }

    /// The time of a phase in ms.
    const fn time(self, phase: u8) -> u32 {
        if self as u8 & PAUSE != 0 && phase == self.phases() - 1 {
            return 1000;
        }
        50 * (self as u8 & TIME) as u32
    }
}

/// The patterns of the error LED in the fault confinement states of the CAN controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ErrorPatterns {
    /// The controller is error active and below the warning limit.
    pub working: Pattern,
    /// Warning limit reached, or error passive.
    pub warning: Pattern,
    /// The controller is bus-off.
    pub bus_off: Pattern,
}

impl ErrorPatterns {
    /// The pattern of a fault confinement state.
    pub const fn of(&self, state: BusState) -> Pattern {
        match state {
            BusState::Active => self.working,
            BusState::Warning | BusState::Passive => self.warning,
            BusState::BusOff => self.bus_off,
        }
    }
}

/// One LED and its position in the pattern.
#[derive(Clone, Copy, Debug)]
struct Led {
    /// The end of the present phase, if the LED changes.
    until: Instant,
    pattern: Pattern,
    /// The phase of the pattern. The LED is on in even phases.
    phase: u8,
}

impl Led {
    const DARK: Self = Self {
        until: Instant::from_ticks(0),
        pattern: Pattern::Off,
        phase: 0,
    };

    fn show(&mut self, now: Instant, pattern: Pattern) {
        if self.pattern != pattern {
            self.pattern = pattern;
            self.phase = 0;
            self.until = after(now, millis(pattern.time(0)));
        }
    }

    /// Whether the LED is lit.
    fn poll(&mut self, now: Instant) -> bool {
        if self.pattern.changes() && reached(now, self.until) {
            self.next(now);
        }
        self.pattern != Pattern::Off && self.phase.is_multiple_of(2)
    }

    fn next(&mut self, now: Instant) {
        self.phase = (self.phase + 1) % self.pattern.phases();
        let time = millis(self.pattern.time(self.phase));
        // The period has no drift, except after a poll that is late by more than a phase.
        let next = after(self.until, time);
        let missed = reached(now, next);
        self.until = if missed { after(now, time) } else { next };
    }
}

/// The status LEDs with their patterns in time.
#[derive(Clone, Copy, Debug)]
pub struct Indicator {
    leds: [Led; 4],
    /// The LEDs that were on at the last poll, one bit each.
    lit: u8,
}

impl Indicator {
    /// All LEDs are dark, before the first pattern is set.
    pub const DARK: Self = Self {
        leds: [Led::DARK; 4],
        lit: 0,
    };

    /// Shows these patterns. A pattern that does not change continues.
    pub fn show(&mut self, now: Instant, patterns: Patterns) {
        let Patterns {
            run,
            error,
            module_green,
            module_red,
        } = patterns;
        let patterns = [run, error, module_green, module_red];
        for (led, pattern) in self.leds.iter_mut().zip(patterns) {
            led.show(now, pattern);
        }
    }

    /// The state of the LEDs; None if no LED has changed since the last call.
    pub fn poll(&mut self, now: Instant) -> Option<Leds> {
        let mut lit = 0;
        for led in &mut self.leds {
            lit = lit << 1 | u8::from(led.poll(now));
        }
        if lit == self.lit {
            return None;
        }
        self.lit = lit;
        Some(Leds {
            run: lit & 8 != 0,
            error: lit & 4 != 0,
            module_green: lit & 2 != 0,
            module_red: lit & 1 != 0,
        })
    }

    /// Adds the time of the next change.
    pub fn consider(&self, next: &mut Deadline) {
        for led in &self.leds {
            if led.pattern.changes() {
                next.consider(Deadline::at(led.until));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deadline(indicator: &Indicator) -> Option<Instant> {
        let mut next = Deadline::NEVER;
        indicator.consider(&mut next);
        next.time()
    }

    /// The times in ms at which the error LED changes, polled at its deadlines up to `end` ms.
    fn changes(pattern: Pattern, end: u64) -> std::vec::Vec<(u64, bool)> {
        let mut indicator = Indicator::DARK;
        let mut now = Instant::from_ticks(0);
        indicator.show(
            now,
            Patterns {
                error: pattern,
                ..Patterns::default()
            },
        );
        let mut changes = std::vec::Vec::new();
        loop {
            if let Some(leds) = indicator.poll(now) {
                changes.push((now.ticks() / 1000, leds.error));
            }
            match deadline(&indicator) {
                Some(next) if next.ticks() <= end * 1000 => now = next,
                _ => return changes,
            }
        }
    }

    #[test]
    fn patterns_have_times_of_led_table() {
        assert_eq!(changes(Pattern::Off, 5000), []);
        assert_eq!(changes(Pattern::On, 5000), [(0, true)]);
        assert_eq!(
            changes(Pattern::Flickering, 150),
            [(0, true), (50, false), (100, true), (150, false)]
        );
        assert_eq!(
            changes(Pattern::SingleFlash, 1400),
            [(0, true), (200, false), (1200, true), (1400, false)]
        );
        assert_eq!(
            changes(Pattern::Blinking, 700),
            [(0, true), (200, false), (400, true), (600, false)]
        );
        assert_eq!(
            changes(Pattern::Flashing, 1500),
            [(0, true), (500, false), (1000, true), (1500, false)]
        );
        assert_eq!(
            changes(Pattern::DoubleFlash, 1800),
            [
                (0, true),
                (200, false),
                (400, true),
                (600, false),
                (1600, true),
                (1800, false)
            ]
        );
    }

    #[test]
    fn pattern_after_late_poll_continues() {
        let mut indicator = Indicator::DARK;
        let patterns = Patterns {
            run: Pattern::Flickering,
            ..Patterns::default()
        };
        indicator.show(Instant::from_ticks(0), patterns);
        let late = Instant::from_ticks(3_600_000_000);
        indicator.poll(late);
        assert_eq!(deadline(&indicator), Some(after(late, millis(50))));
        assert!(indicator.poll(after(late, millis(50))).is_some());
    }

    #[test]
    fn each_channel_has_its_own_pattern() {
        let mut indicator = Indicator::DARK;
        let start = Instant::from_ticks(0);
        let patterns = Patterns {
            run: Pattern::On,
            error: Pattern::Off,
            module_green: Pattern::Blinking,
            module_red: Pattern::Flickering,
        };
        indicator.show(start, patterns);
        let lit = |ms: u32, indicator: &mut Indicator| indicator.poll(after(start, millis(ms)));
        let all = Leds {
            run: true,
            error: false,
            module_green: true,
            module_red: true,
        };
        assert_eq!(lit(0, &mut indicator), Some(all));
        assert_eq!(lit(0, &mut indicator), None);
        assert_eq!(deadline(&indicator), Some(after(start, millis(50))));
        let red_off = Leds {
            module_red: false,
            ..all
        };
        assert_eq!(lit(50, &mut indicator), Some(red_off));
    }
}
