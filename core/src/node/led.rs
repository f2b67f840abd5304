//! Blink patterns of the two status LEDs, as data that a model's LED table refers to.

use super::Leds;
use crate::time::{Instant, after, earlier, millis, reached};

/// What one LED shows. A state lasts 200 ms, in flickering 50 ms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Pattern {
    /// Dark.
    #[default]
    Off,
    /// Lit.
    On,
    /// 50 ms on, 50 ms off.
    Flickering,
    /// 200 ms on, 200 ms off.
    Blinking,
    /// 200 ms on, 1000 ms off.
    SingleFlash,
    /// Twice 200 ms on with 200 ms between, then 1000 ms off.
    DoubleFlash,
}

impl Pattern {
    /// Milliseconds lit and dark in turn, repeated; empty for a steady light.
    const fn times(self) -> &'static [u16] {
        match self {
            Self::Off | Self::On => &[],
            Self::Flickering => &[50, 50],
            Self::Blinking => &[200, 200],
            Self::SingleFlash => &[200, 1000],
            Self::DoubleFlash => &[200, 200, 200, 1000],
        }
    }
}

/// One LED on its way through a pattern.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Led {
    pattern: Pattern,
    /// The place in the pattern's times; those with an even number are lit.
    phase: u8,
    lit: bool,
    until: Option<Instant>,
}

impl Led {
    fn show(&mut self, now: Instant, pattern: Pattern) {
        if self.pattern != pattern {
            let first = pattern.times().first();
            *self = Self {
                pattern,
                phase: 0,
                lit: pattern != Pattern::Off,
                until: first.map(|&time| after(now, millis(time.into()))),
            };
        }
    }

    fn poll(&mut self, now: Instant) {
        let Some(until) = self.until else {
            return;
        };
        if reached(now, until) {
            let times = self.pattern.times();
            self.phase += 1;
            if usize::from(self.phase) >= times.len() {
                self.phase = 0;
            }
            self.lit = self.phase.is_multiple_of(2);
            let time = times.get(usize::from(self.phase)).copied().unwrap_or(200);
            let time = millis(time.into());
            // In step with the pattern's own clock, unless the caller was away for longer than a state.
            let next = after(until, time);
            self.until = Some(if reached(now, next) {
                after(now, time)
            } else {
                next
            });
        }
    }
}

/// The run and the error LED.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Indicator {
    run: Led,
    error: Led,
}

impl Indicator {
    /// Shows these patterns from now on; one that is shown already goes on undisturbed.
    pub fn show(&mut self, now: Instant, run: Pattern, error: Pattern) {
        self.run.show(now, run);
        self.error.show(now, error);
    }

    /// The LEDs as they are now.
    pub fn poll(&mut self, now: Instant) -> Leds {
        self.run.poll(now);
        self.error.poll(now);
        Leds {
            run: self.run.lit,
            error: self.error.lit,
        }
    }

    /// When an LED changes next.
    pub fn deadline(&self) -> Option<Instant> {
        earlier(self.run.until, self.error.until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The times in ms at which the error LED changes while it is polled at its deadlines, up to `end` ms.
    fn changes(pattern: Pattern, end: u64) -> std::vec::Vec<(u64, bool)> {
        let mut indicator = Indicator::default();
        let mut now = Instant::from_ticks(0);
        indicator.show(now, Pattern::Off, pattern);
        let mut lit = false;
        let mut changes = std::vec::Vec::new();
        loop {
            let leds = indicator.poll(now);
            if leds.error != lit {
                lit = leds.error;
                changes.push((now.ticks() / 1000, lit));
            }
            match indicator.deadline() {
                Some(next) if next.ticks() <= end * 1000 => now = next,
                _ => return changes,
            }
        }
    }

    #[test]
    fn patterns_keep_the_times_of_the_led_table() {
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
    fn a_late_caller_finds_the_pattern_going_on() {
        let mut indicator = Indicator::default();
        indicator.show(Instant::from_ticks(0), Pattern::Flickering, Pattern::Off);
        let late = Instant::from_ticks(3_600_000_000);
        let before = indicator.poll(late);
        assert_eq!(indicator.deadline(), Some(after(late, millis(50))));
        assert_ne!(indicator.poll(after(late, millis(50))), before);
    }
}
