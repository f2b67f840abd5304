//! The frames of a log, with their spacing.

use super::transmit::Frames;
use crate::decode::log::Line;
use crate::error::{Error, RequestError};
use plumbline::can::Frame;
use plumbline::time::Instant;
use std::collections::BTreeSet;

/// The time between the last frame and the next first one of a log with one frame, in us.
const ALONE: u64 = 100_000;

/// The shortest one of other logs, in us.
const SHORTEST: u64 = 1000;

/// The frames, with their times after the first one in us.
#[derive(Debug)]
pub struct Round(Vec<(u64, Frame)>);

impl Round {
    /// The number of frames.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The time from the first frame to the last one, in us.
    pub fn length(&self) -> u64 {
        self.0.last().map_or(0, |(at, _)| *at)
    }

    /// The time from the first frame to the next first one: one mean gap longer than the frames.
    fn period(&self) -> u64 {
        let gaps = self.0.len() as u64 - 1;
        let gap = self.length().checked_div(gaps);
        let gap = gap.map_or(ALONE, |gap| gap.max(SHORTEST));
        self.length().saturating_add(gap)
    }
}

/// The frames of a log while it is read.
#[derive(Debug, Default)]
pub struct Recording {
    frames: Vec<(u64, Frame)>,
    interfaces: BTreeSet<String>,
    first: Option<u64>,
}

impl Recording {
    /// Takes the next frame.
    pub fn take(&mut self, line: Line) {
        let micros = line.micros();
        let first = *self.first.get_or_insert(micros);
        // The time of a log can go back: then the frame follows at once.
        let newest = self.frames.last().map_or(0, |(at, _)| *at);
        let at = micros.saturating_sub(first).max(newest);
        self.frames.push((at, line.frame));
        self.interfaces.insert(line.interface);
    }

    /// The frames of the log with this name.
    ///
    /// # Errors
    /// There is no frame, or there are frames of several buses.
    pub fn finish(self, name: String) -> Result<Round, Error> {
        if self.frames.is_empty() {
            return Err(RequestError::NoFrame(name).into());
        }
        if self.interfaces.len() > 1 {
            let names: Vec<String> = self.interfaces.into_iter().collect();
            return Err(RequestError::Interfaces(name, names.join(", ")).into());
        }
        Ok(Round(self.frames))
    }
}

/// A log that is sent.
#[derive(Debug)]
pub struct Replay {
    round: Round,
    speed: f64,
    repeats: bool,
    /// When the round has started.
    start: Instant,
    /// The next frame of the round.
    place: usize,
}

impl Replay {
    /// Sends the round from this time on, this number of times as fast as it was recorded; again and again if it repeats.
    pub fn new(round: Round, speed: f64, repeats: bool, start: Instant) -> Self {
        Self {
            round,
            speed,
            repeats,
            start,
            place: 0,
        }
    }

    /// This time of the log. A log can have any number as its time.
    fn at(&self, micros: u64) -> Instant {
        let ticks = (micros as f64 / self.speed).round() as u64;
        Instant::from_ticks(self.start.ticks().saturating_add(ticks))
    }
}

impl Frames for Replay {
    fn next(&self) -> Option<(Instant, Frame)> {
        let (at, frame) = self.round.0.get(self.place)?;
        Some((self.at(*at), *frame))
    }

    fn sent(&mut self, _now: Instant) {
        self.place += 1;
        if self.repeats && self.place == self.round.count() {
            (self.start, self.place) = (self.at(self.round.period()), 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_with_the_last_time_is_not_sent_at_once() {
        let mut recording = Recording::default();
        for text in ["(0.1) can0 123#", "(99999999999999) can0 124#"] {
            recording.take(Line::parse(text).expect("a frame"));
        }
        let round = recording.finish("far.log".to_owned()).expect("a log");
        let start = Instant::from_ticks(1_000_000);
        let mut replay = Replay::new(round, 1.0, true, start);
        for _ in 0..3 {
            replay.sent(start);
            let (at, _) = replay.next().expect("it repeats");
            assert_eq!(at, Instant::from_ticks(u64::MAX));
        }
    }

    #[test]
    fn frame_whose_time_goes_back_follows_at_once() {
        let mut recording = Recording::default();
        for text in [
            "(1.0) can0 123#01",
            "(1.2) can0 123#02",
            "(1.1) can0 123#03",
            "(1.3) can0 123#04",
        ] {
            recording.take(Line::parse(text).expect("a frame"));
        }
        let round = recording.finish("bus.log".to_owned()).expect("one bus");
        let times: Vec<u64> = round.0.iter().map(|(at, _)| *at).collect();
        assert_eq!(times, [0, 200_000, 200_000, 300_000]);
    }
}
