//! The network status LED and the module status LED, each red and green.
//!
//! | network status | |
//! |---|---|
//! | off | not on-line |
//! | green, flashing | on-line without an established connection |
//! | green | a connection is established |
//! | red, flashing | an I/O connection has timed out |
//! | red | another node has the MAC ID, or bus-off |
//!
//! After power-up, the colours are shown in turn: module green, module red, network green, network red.

use crate::node::{Pattern, Patterns};
use crate::time::{Deadline, Duration, Instant, millis};

/// The time of each colour of the self-test.
const COLOUR: Duration = millis(250);

/// The number of colours of the self-test.
const COLOURS: u8 = 4;

/// The indication of one LED.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Light {
    Off,
    Green,
    /// Green, 0.5 s on and 0.5 s off.
    FlashingGreen,
    Red,
    /// Red, 0.5 s on and 0.5 s off.
    FlashingRed,
}

impl Light {
    /// The patterns of the green and of the red half.
    const fn halves(self) -> (Pattern, Pattern) {
        match self {
            Self::Off => (Pattern::Off, Pattern::Off),
            Self::Green => (Pattern::On, Pattern::Off),
            Self::FlashingGreen => (Pattern::Flashing, Pattern::Off),
            Self::Red => (Pattern::Off, Pattern::On),
            Self::FlashingRed => (Pattern::Off, Pattern::Flashing),
        }
    }
}

/// The module status LED and the network status LED.
#[derive(Clone, Copy, Debug)]
pub(super) struct StatusLeds {
    shown: (Light, Light),
    /// The number of colours of the self-test that are over.
    tested: u8,
    until: Deadline,
}

impl StatusLeds {
    pub const DARK: Self = Self {
        shown: (Light::Off, Light::Off),
        tested: 0,
        until: Deadline::NEVER,
    };

    /// Begins the self-test: the colours of both LEDs one after the other.
    pub fn start(&mut self, now: Instant) {
        self.tested = 0;
        self.until = Deadline::after(now, COLOUR);
    }

    /// The patterns if they have changed. `module` and `network` are the indications after the self-test.
    pub fn show(&mut self, now: Instant, module: Light, network: Light) -> Option<Patterns> {
        if self.until.is_reached(now) {
            self.tested += 1;
            self.until = if self.tested < COLOURS {
                Deadline::after(now, COLOUR)
            } else {
                Deadline::NEVER
            };
        }
        let lights = match self.tested {
            0 => (Light::Green, Light::Off),
            1 => (Light::Red, Light::Off),
            2 => (Light::Off, Light::Green),
            3 => (Light::Off, Light::Red),
            _ => (module, network),
        };
        if lights == self.shown {
            return None;
        }
        self.shown = lights;
        let (module, network) = lights;
        let (module_green, module_red) = module.halves();
        let (run, error) = network.halves();
        Some(Patterns {
            run,
            error,
            module_green,
            module_red,
        })
    }

    /// The end of the present colour of the self-test.
    pub fn deadline(&self) -> Deadline {
        self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn self_test_shows_each_colour_for_250_ms() {
        let at = |ms: u32| Instant::from_ticks(7000) + millis(ms);
        let mut leds = StatusLeds::DARK;
        leds.start(at(0));
        let mut shown = std::vec::Vec::new();
        let mut now = at(0);
        for _ in 0..5 {
            let patterns = leds.show(now, Light::FlashingRed, Light::Green).unwrap();
            let Patterns {
                run,
                error,
                module_green,
                module_red,
            } = patterns;
            shown.push((now, [module_green, module_red, run, error]));
            assert_eq!(leds.show(now, Light::FlashingRed, Light::Green), None);
            now = leds.deadline().time().unwrap_or(now);
        }
        let (off, on) = (Pattern::Off, Pattern::On);
        let expected = [
            (at(0), [on, off, off, off]),
            (at(250), [off, on, off, off]),
            (at(500), [off, off, on, off]),
            (at(750), [off, off, off, on]),
            (at(1000), [off, Pattern::Flashing, on, off]),
        ];
        assert_eq!(shown, expected);
        assert_eq!(leds.deadline(), Deadline::NEVER);
        let dark = leds.show(now, Light::Off, Light::Off);
        assert_eq!(dark, Some(Patterns::DARK));
    }
}
