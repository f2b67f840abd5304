//! One line on a terminal that shows the state of the sensor.

use super::{Traffic, pattern};
use bench::Sensor;
use plumbline::can::BitRate;
use plumbline::node::{BusMode, BusState, Pattern, Patterns, Readout};
use plumbline::time::Instant as BusTime;
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// The update interval of the line.
const INTERVAL: Duration = Duration::from_millis(100);

/// Returns to the start of the line and disables wrapping, so that a long text on a narrow terminal stays one line.
const BEGIN: &str = "\r\x1b[?7l";

/// Erases the rest of the previous version, and enables wrapping again.
const FINISH: &str = "\x1b[K\x1b[?7h";

/// A line on standard output that is overwritten in place.
#[derive(Debug)]
pub struct StatusLine {
    next: Instant,
}

impl Default for StatusLine {
    fn default() -> Self {
        Self::new()
    }
}

impl StatusLine {
    /// A line that is shown immediately.
    pub fn new() -> Self {
        Self {
            next: Instant::now(),
        }
    }

    /// The time until the next update.
    pub(super) fn pause(&self) -> Duration {
        self.next.saturating_duration_since(Instant::now())
    }

    /// Shows the line if an update is due. `now` is the time of the bus.
    pub(super) fn show<'a>(
        &mut self,
        now: BusTime,
        sensors: impl Iterator<Item = &'a dyn Sensor>,
        traffic: Traffic,
        clients: usize,
    ) {
        if !self.pause().is_zero() {
            return;
        }
        self.next = Instant::now() + INTERVAL;
        let sensors: Vec<String> = sensors
            .map(|sensor| {
                text(&Display {
                    model: sensor.name(),
                    is_on: sensor.is_on(),
                    readout: sensor.readout(),
                    leds: pattern::patterns(now, sensor.led_history().iter()),
                    rate: sensor.rate(),
                    mode: sensor.mode(),
                    state: sensor.bus_state(),
                })
            })
            .collect();
        let Traffic { received, sent } = traffic;
        let sensors = sensors.join(" | ");
        let line = format!("{sensors} in {received} out {sent} clients {clients}");
        print(&format!("{BEGIN}{line}{FINISH}"));
    }

    /// Ends the line and goes to the next.
    pub(super) fn end(&mut self) {
        print("\n");
    }
}

/// A closed terminal must not end the sensor.
fn print(text: &str) {
    let mut output = io::stdout().lock();
    let _ = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
}

/// The state of one sensor.
struct Display {
    model: &'static str,
    is_on: bool,
    readout: Option<Readout>,
    leds: Patterns,
    rate: Option<BitRate>,
    mode: Option<BusMode>,
    state: Option<BusState>,
}

/// The part of the line for one sensor.
fn text(display: &Display) -> String {
    let state = match (display.mode, display.state) {
        _ if !display.is_on => "off",
        (None, _) | (_, None) => "not on the bus",
        (_, Some(BusState::BusOff)) => "bus off",
        (Some(BusMode::Listen), _) => "listening",
        (_, Some(BusState::Active)) => "active",
        (_, Some(BusState::Warning)) => "warning",
        (_, Some(BusState::Passive)) => "passive",
    };
    format!(
        "{} {} {} {}{} {} {state}",
        display.model,
        angles(display.is_on, display.readout),
        lamp("run", display.leds.run, 32),
        lamp("err", display.leds.error, 31),
        module(display.leds),
        kbits(display.rate),
    )
}

/// A dot in its colour when on, dark when off, and the name of a pattern that changes.
fn lamp(name: &str, pattern: Pattern, colour: u8) -> String {
    match pattern::name(pattern) {
        Some(changes) => format!("\x1b[{colour}m◐\x1b[0m{name} {changes}"),
        None if pattern == Pattern::On => format!("\x1b[{colour}m●\x1b[0m{name}"),
        None => format!("\x1b[2m○\x1b[0m{name}"),
    }
}

/// The module status LED with its two colours; empty while it is off, because most sensors have none.
fn module(leds: Patterns) -> String {
    let (pattern, colour) = match (leds.module_green, leds.module_red) {
        (Pattern::Off, Pattern::Off) => return String::new(),
        (green, Pattern::Off) => (green, 32),
        (Pattern::Off, red) => (red, 31),
        (_, red) => (red, 33),
    };
    format!(" {}", lamp("mod", pattern, colour))
}

/// "-" when the angles are not available.
fn angles(is_on: bool, readout: Option<Readout>) -> String {
    let degrees = |hundredths: i32| f64::from(hundredths) / 100.0;
    match readout {
        _ if !is_on => "off".into(),
        None => "-".into(),
        Some(Readout { x, y: None }) => format!("{:7.2}°", degrees(x)),
        Some(Readout { x, y: Some(y) }) => {
            format!("X{:+7.2}° Y{:+7.2}°", degrees(x), degrees(y))
        }
    }
}

fn kbits(rate: Option<BitRate>) -> String {
    rate.map_or("- kbit/s".into(), |rate| {
        format!("{} kbit/s", f64::from(rate.bits_per_second()) / 1000.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(display: &Display) -> String {
        let mut text = text(display);
        for code in ["\x1b[32m", "\x1b[31m", "\x1b[2m", "\x1b[0m"] {
            text = text.replace(code, "");
        }
        text
    }

    fn display() -> Display {
        Display {
            model: "is2",
            is_on: true,
            readout: Some(Readout {
                x: -123,
                y: Some(9000),
            }),
            leds: Patterns {
                run: Pattern::On,
                ..Patterns::DARK
            },
            rate: Some(BitRate::K62_5),
            mode: Some(BusMode::Normal),
            state: Some(BusState::Active),
        }
    }

    #[test]
    fn status_of_two_axes() {
        assert_eq!(
            plain(&display()),
            "is2 X  -1.23° Y +90.00° ●run ○err 62.5 kbit/s active"
        );
    }

    #[test]
    fn status_of_one_axis_while_listening() {
        let display = Display {
            model: "is1",
            readout: Some(Readout { x: 35999, y: None }),
            leds: Patterns {
                run: Pattern::Flickering,
                error: Pattern::On,
                module_red: Pattern::SingleFlash,
                ..Patterns::DARK
            },
            mode: Some(BusMode::Listen),
            rate: None,
            ..display()
        };
        assert_eq!(
            plain(&display),
            "is1  359.99° ◐run flickering ●err ◐mod single flash - kbit/s listening"
        );
    }

    #[test]
    fn unknown_angles_and_power_off() {
        let unknown = Display {
            readout: None,
            ..display()
        };
        assert_eq!(plain(&unknown), "is2 - ●run ○err 62.5 kbit/s active");
        let starting = Display {
            rate: None,
            mode: None,
            state: None,
            ..unknown
        };
        assert_eq!(plain(&starting), "is2 - ●run ○err - kbit/s not on the bus");
        let off = Display {
            is_on: false,
            leds: Patterns::DARK,
            ..starting
        };
        assert_eq!(plain(&off), "is2 off ○run ○err - kbit/s off");
    }
}
