//! Faults of the accelerometer, from a time on.

use crate::motion::Motion;
use plumbline::measure::{I32x3, Reading};
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
}

impl Fault {
    /// All faults with their names.
    const NAMES: [(&'static str, Self); 4] = [
        ("silent", Self::Silent),
        ("frozen", Self::Frozen),
        ("stopped", Self::Stopped),
        ("zero", Self::Zero),
    ];

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
    "write accelerometer=FAULT or accelerometer=FAULT@SECONDS; FAULT is silent, frozen, stopped or zero"
)]
pub struct FaultError;

impl FromStr for FaultFrom {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let text = text.strip_prefix("accelerometer=").ok_or(FaultError)?;
        let (name, seconds) = text.split_once('@').unwrap_or((text, "0"));
        let named = Fault::NAMES.into_iter().find(|(own, _)| *own == name);
        let (_, fault) = named.ok_or(FaultError)?;
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

/// A motion measured by an accelerometer with faults. At each time, the fault that began last is in force.
pub struct Faulty<M> {
    motion: M,
    faults: Vec<FaultFrom>,
}

impl<M: Motion> Faulty<M> {
    /// `motion` with these faults, in any order.
    pub fn new(motion: M, faults: &[FaultFrom]) -> Self {
        let mut faults = faults.to_vec();
        faults.sort_by_key(|fault| fault.from);
        Self { motion, faults }
    }
}

impl<M: Motion> Motion for Faulty<M> {
    fn reading(&mut self, now: Instant) -> Reading {
        let reading = self.motion.reading(now);
        if self.fault(now) != Some(Fault::Zero) {
            return reading;
        }
        Reading {
            acceleration: I32x3 { x: 0, y: 0, z: 0 },
            clipped: false,
            ..reading
        }
    }

    fn supply(&mut self, now: Instant) -> u16 {
        self.motion.supply(now)
    }

    fn fault(&self, now: Instant) -> Option<Fault> {
        let begun = self.faults.iter().rev().find(|fault| fault.from <= now);
        begun.map(|begun| begun.fault)
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
    fn fault_that_began_last_is_in_force() {
        let faults = ["zero@3", "silent@2"].map(|text| {
            let text = format!("accelerometer={text}");
            text.parse().expect("a fault")
        });
        let level = crate::script::LEVEL;
        let mut motion = Faulty::new(level, &faults);
        let mut at = |s: u64| {
            let now = Instant::from_ticks(s * 1_000_000);
            (motion.fault(now), motion.reading(now).acceleration.z)
        };
        let one_g = level.acceleration.z;
        assert_eq!(at(1), (None, one_g));
        assert_eq!(at(2), (Some(Fault::Silent), one_g));
        assert_eq!(at(3), (Some(Fault::Zero), 0));
    }
}
