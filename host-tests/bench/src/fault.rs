//! Faults of the accelerometer, from a time on.

use plumbline::measure::{I32x3, RANGE, Reading};
use plumbline::time::Instant;
use std::str::FromStr;

/// What an accelerometer does wrong.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// It does not answer on the SPI.
    Silent,
    /// Its values do not change. They look like new ones. The firmware uses 31 of them.
    Frozen,
    /// It answers, but has no more values.
    Stopped,
    /// All its axes measure 0 g.
    Zero,
    /// This axis measures 0 g, and the self-test does not change it.
    Axis(Axis),
    /// The axis with the largest value is at the end of the range.
    Clipping,
}

/// An axis of the accelerometer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axis {
    /// The first one.
    X,
    /// The second one.
    Y,
    /// The third one.
    Z,
}

impl Fault {
    /// All faults with their names.
    const NAMES: [(&'static str, Self); 8] = [
        ("silent", Self::Silent),
        ("frozen", Self::Frozen),
        ("stopped", Self::Stopped),
        ("zero", Self::Zero),
        ("axis-x", Self::Axis(Axis::X)),
        ("axis-y", Self::Axis(Axis::Y)),
        ("axis-z", Self::Axis(Axis::Z)),
        ("clipping", Self::Clipping),
    ];

    /// The fault with this name.
    pub fn named(name: &str) -> Option<Self> {
        let named = Self::NAMES.into_iter().find(|(own, _)| *own == name);
        named.map(|(_, fault)| fault)
    }

    /// The name of the fault on command lines.
    pub fn name(self) -> &'static str {
        let named = Self::NAMES.into_iter().find(|(_, own)| *own == self);
        named.map_or("", |(name, _)| name)
    }

    /// The names of all faults, as part of a sentence.
    pub fn names() -> String {
        let [first @ .., last] = Self::NAMES.map(|(name, _)| name);
        format!("{} or {last}", first.join(", "))
    }

    /// The reading of an accelerometer with this fault, if it has readings.
    pub fn of(self, reading: Reading) -> Reading {
        let mut values = reading.acceleration.to_array();
        let mut clipped = reading.clipped;
        match self {
            Self::Zero => (values, clipped) = ([0; 3], false),
            Self::Axis(axis) => values[axis as usize] = 0,
            Self::Clipping => {
                clipped = true;
                if let Some(largest) = values.iter_mut().max_by_key(|value| value.unsigned_abs()) {
                    *largest = if *largest < 0 { -RANGE } else { RANGE };
                }
            }
            Self::Silent | Self::Frozen | Self::Stopped => {}
        }
        let [x, y, z] = values;
        Reading {
            acceleration: I32x3 { x, y, z },
            clipped,
            ..reading
        }
    }

    /// Whether the accelerometer has no values.
    pub fn is_mute(self) -> bool {
        matches!(self, Self::Silent | Self::Stopped)
    }
}

/// A fault and the time at which it begins: the argument of `--fault`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FaultFrom {
    /// What is wrong from then on.
    pub fault: Fault,
    /// The virtual time at which it begins.
    pub from: Instant,
}

/// The text after `--fault` is not a fault.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "write accelerometer=FAULT or accelerometer=FAULT@SECONDS; FAULT is {}",
    Fault::names()
)]
pub struct FaultError;

impl FromStr for FaultFrom {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let text = text.strip_prefix("accelerometer=").ok_or(FaultError)?;
        let (name, seconds) = text.split_once('@').unwrap_or((text, "0"));
        let fault = Fault::named(name).ok_or(FaultError)?;
        let seconds: f64 = seconds.parse().map_err(|_| FaultError)?;
        if !(0.0..1e9).contains(&seconds) {
            return Err(FaultError);
        }
        Ok(Self {
            fault,
            from: Instant::from_ticks((seconds * 1e6).round() as u64),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_fault_and_its_begin() {
        for (text, fault, us) in [
            ("accelerometer=silent", Fault::Silent, 0),
            ("accelerometer=frozen@2", Fault::Frozen, 2_000_000),
            ("accelerometer=stopped@0.25", Fault::Stopped, 250_000),
            ("accelerometer=zero@0", Fault::Zero, 0),
        ] {
            let from = Instant::from_ticks(us);
            assert_eq!(text.parse(), Ok(FaultFrom { fault, from }), "{text}");
        }
    }

    #[test]
    fn wrong_text_is_refused() {
        for text in [
            "",
            "silent",
            "accelerometer",
            "accelerometer=",
            "accelerometer=dead",
            "gyroscope=silent",
            "accelerometer=silent@",
            "accelerometer=silent@-1",
            "accelerometer=silent@nan",
            "accelerometer=silent@1e300",
            "accelerometer=silent@1s",
        ] {
            assert_eq!(text.parse::<FaultFrom>(), Err(FaultError), "{text}");
        }
    }

    #[test]
    fn fault_changes_only_its_axis_or_reaches_the_end_of_the_range() {
        let reading = Reading {
            acceleration: I32x3 { x: 5, y: -7, z: 6 },
            ..Reading::default()
        };
        let of = |name: &str| {
            let reading = Fault::named(name).expect("a fault").of(reading);
            (reading.acceleration.to_array(), reading.clipped)
        };
        assert_eq!(of("zero"), ([0, 0, 0], false));
        assert_eq!(of("axis-x"), ([0, -7, 6], false));
        assert_eq!(of("axis-y"), ([5, 0, 6], false));
        assert_eq!(of("axis-z"), ([5, -7, 0], false));
        assert_eq!(of("clipping"), ([5, -RANGE, 6], true));
        assert_eq!(of("frozen"), ([5, -7, 6], false));
    }
}
