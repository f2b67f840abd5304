//! Faults between a client and the bus: frames that get lost or arrive late.

use super::control::{Refused, span};
use can_wire::text;
use plumbline::can::{Frame, Id};
use plumbline::time::{Duration, Instant, after};

/// The longest delay of a frame in s.
const LONGEST: f64 = 60.0;

/// A fault of the next frames in one direction.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The number of frames that still have the fault.
    count: u32,
    /// The identifier of these frames; None: any.
    identifier: Option<Id>,
    /// None: they get lost.
    delay: Option<Duration>,
}

impl Rule {
    /// This number of frames with this identifier, or all, get lost, or are late by this time in s.
    ///
    /// # Errors
    /// The identifier or the time is not valid.
    pub fn new(
        count: u32,
        identifier: Option<&str>,
        seconds: Option<f64>,
    ) -> Result<Self, Refused> {
        let id_of = |digits: &str| {
            let frame = text::parse(&format!("{digits}#"));
            frame.map_or_else(
                |_| Err(Refused::Identifier(digits.to_owned())),
                |frame| Ok(frame.id()),
            )
        };
        Ok(Self {
            count,
            identifier: identifier.map(id_of).transpose()?,
            delay: seconds.map(|time| span(time, LONGEST)).transpose()?,
        })
    }

    fn concerns(&self, frame: &Frame) -> bool {
        self.count > 0 && self.identifier.is_none_or(|id| id == frame.id())
    }
}

/// One direction between a client and the bus.
#[derive(Debug, Default)]
pub struct Passage {
    rules: Vec<Rule>,
    /// The late frames with the time of their arrival.
    late: Vec<(Instant, Frame)>,
}

impl Passage {
    /// Adds a fault. It takes effect after those that were added before.
    pub fn add(&mut self, rule: Rule) {
        self.rules.retain(|rule| rule.count > 0);
        self.rules.push(rule);
    }

    /// The frame if it arrives at once.
    pub fn pass(&mut self, at: Instant, frame: Frame) -> Option<Frame> {
        let Some(rule) = self.rules.iter_mut().find(|rule| rule.concerns(&frame)) else {
            return Some(frame);
        };
        rule.count -= 1;
        if let Some(delay) = rule.delay {
            self.late.push((after(at, delay), frame));
        }
        None
    }

    /// Takes the late frames that have arrived, with the time of their arrival.
    pub fn arrived(&mut self, now: Instant) -> Vec<(Instant, Frame)> {
        let mut arrived: Vec<_> = self.late.extract_if(.., |(at, _)| *at <= now).collect();
        arrived.sort_by_key(|(at, _)| *at);
        arrived
    }

    /// The arrival of the next late frame.
    pub fn next(&self) -> Option<Instant> {
        self.late.iter().map(|(at, _)| *at).min()
    }

    /// The number of late frames.
    pub fn late(&self) -> usize {
        self.late.len()
    }

    /// Drops the late frames.
    pub fn clear(&mut self) {
        self.late.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_wire::text::frame;
    use plumbline::time::millis;

    #[test]
    fn faults_concern_their_number_of_frames_and_their_identifier() {
        let mut passage = Passage::default();
        let id = Some(frame("301#").id());
        let at = |ms| after(Instant::from_ticks(0), millis(ms));
        for (count, identifier, delay) in [(1, id, None), (2, None, Some(millis(10)))] {
            passage.add(Rule {
                count,
                identifier,
                delay,
            });
        }
        let mut pass = |ms, text| passage.pass(at(ms), frame(text)).is_some();
        let passed = [
            pass(0, "302#01"),
            pass(1, "301#02"),
            pass(2, "301#03"),
            pass(3, "301#04"),
        ];
        assert_eq!(passed, [false, false, false, true]);
        assert_eq!(passage.next(), Some(at(10)));
        assert_eq!(passage.arrived(at(9)), []);
        assert_eq!(passage.arrived(at(11)), [(at(10), frame("302#01"))]);
        assert_eq!(passage.arrived(at(20)), [(at(12), frame("301#03"))]);
        assert_eq!((passage.late(), passage.next()), (0, None));
    }
}
