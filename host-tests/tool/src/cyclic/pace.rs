//! The period of messages that come without a request, and how many of them are missing.

use super::Message;
use super::count::{self, Count};
use plumbline::time::{Duration, Instant, after, millis};
use std::collections::VecDeque;

/// The messages from which the period is measured.
const MEASURED: usize = 20;

/// The messages have ended after this number of periods plus this time.
const ENDED: (u64, Duration) = (3, millis(1000));

/// The messages of a sensor since they have begun.
#[derive(Default)]
pub struct Pace {
    /// The times of the newest messages.
    times: VecDeque<Instant>,
    /// The period and the messages since it is known; None: too few, or not regular.
    known: Option<(Duration, Count)>,
    /// What was missing before that.
    missing: u64,
}

impl Pace {
    /// A message came.
    pub(crate) fn take(&mut self, message: &Message) {
        if self.has_ended(message.at) {
            self.restart();
        }
        if self.times.len() == MEASURED {
            self.times.pop_front();
        }
        self.times.push_back(message.at);
        if let Some((_, count)) = &mut self.known {
            count.take(message.at, message.counter);
        }
        if self.times.len() == MEASURED {
            self.measure(message);
        }
    }

    /// Takes another period when the sensor has changed it.
    fn measure(&mut self, message: &Message) {
        let Some(own) = count::period(self.times.make_contiguous()) else {
            return;
        };
        let known = self.known.as_ref().map(|(period, _)| period.ticks());
        if known.is_none_or(|known| own.ticks().abs_diff(known) > known / 4) {
            self.settle();
            let mut count = Count::new(Some(own), message.at);
            count.take(message.at, message.counter);
            self.known = Some((own, count));
        }
    }

    /// Keeps what is missing until the last message.
    fn settle(&mut self) {
        if let (Some((_, count)), Some(last)) = (self.known.take(), self.times.back()) {
            self.missing += count.missing(*last);
        }
    }

    /// The settings of the sensor can have changed: the period is measured again.
    pub fn restart(&mut self) {
        self.settle();
        self.times.clear();
    }

    /// Whether no message has come for so long that none is expected.
    pub fn has_ended(&self, now: Instant) -> bool {
        let (periods, time) = ENDED;
        let period = self.period().map_or(0, |period| period.ticks());
        let longest = periods * period + time.ticks();
        let last = self.times.back();
        last.is_none_or(|last| now > after(*last, Duration::from_ticks(longest)))
    }

    /// The period; None: it is not known.
    pub fn period(&self) -> Option<Duration> {
        self.known.as_ref().map(|(period, _)| *period)
    }

    /// The messages that are missing until the last one that came.
    pub fn missing(&self) -> u64 {
        let now = self.known.as_ref().zip(self.times.back());
        self.missing + now.map_or(0, |((_, count), last)| count.missing(*last))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(at: u64, counter: Option<u16>) -> Message {
        Message {
            counter,
            ..Message::plain((Instant::from_ticks(at), Vec::new()))
        }
    }

    #[test]
    fn missing_messages_are_counted_from_the_measured_period_or_the_counter() {
        for has_counter in [false, true] {
            let mut pace = Pace::default();
            for place in (0..200).filter(|place| !(100..103).contains(place)) {
                // The adapter has steps of 1 ms, and the computer is late.
                let late = (place % 3) * 400;
                let counter = has_counter.then_some(place as u16);
                pace.take(&message(place * 10_000 + late, counter));
            }
            assert_eq!(pace.missing(), 3, "{has_counter}");
            assert_eq!(pace.period().map(|own| own.ticks() / 1000), Some(10));
        }
    }

    #[test]
    fn changed_period_is_measured_again_and_is_no_loss() {
        let mut pace = Pace::default();
        let mut at = 0;
        for period in [10_000, 13_000, 20_000, 5_000] {
            for _ in 0..100 {
                at += period;
                pace.take(&message(at, None));
            }
            assert_eq!(pace.period().map(|own| own.ticks()), Some(period));
            // The grid has doubted some until the new period was measured.
            assert!(pace.missing() <= 20, "{}", pace.missing());
        }
    }

    #[test]
    fn messages_have_ended_after_a_pause_which_is_no_loss() {
        let mut pace = Pace::default();
        for place in 0..50 {
            pace.take(&message(place * 10_000, None));
        }
        assert!(!pace.has_ended(Instant::from_ticks(500_000)));
        assert!(pace.has_ended(Instant::from_ticks(2_000_000)));
        pace.take(&message(60_000_000, None));
        assert_eq!((pace.missing(), pace.period()), (0, None));
    }
}
