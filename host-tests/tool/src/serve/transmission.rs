//! The frames that the page sends beside its requests: a transmit list, and a log that is sent again.

use crate::error::{Error, PageError};
use crate::ops::replay::Replay;
use crate::ops::transmit::{Frames, Item, LONGEST, Line, List, carried};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use serde::Deserialize;
use serde_json::{Value, json};

/// The maximum number of lines of the list.
const LINES: usize = 100;

/// What the page asks for.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Transmit {
    /// Add a line to the list.
    Add {
        /// The frame, as `send` takes it.
        frame: String,
        /// The period in ms; None: it is sent once.
        #[serde(default)]
        every: Option<u32>,
    },
    /// Add the lines of a file.
    Open {
        /// Its content (TOML).
        text: String,
        /// Its name.
        name: String,
    },
    /// Start the line with this number; a line without a period is sent once.
    Start(u64),
    /// Stop the line with this number.
    Stop(u64),
    /// Remove the line with this number.
    Remove(u64),
    /// Send the frames of a log.
    Replay(Log),
    /// Stop the log.
    StopReplay,
}

/// A log that the page sends.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// Its content.
    pub text: String,
    /// Its name.
    pub name: String,
    /// This number of times as fast as it was recorded.
    pub speed: f64,
    /// Again and again.
    #[serde(default)]
    pub repeats: bool,
    /// Only the frames of this interface.
    #[serde(default)]
    pub interface: Option<String>,
}

/// A log that is sent, or was sent.
#[derive(Debug)]
struct Sent {
    name: String,
    /// None: it has stopped.
    frames: Option<Replay>,
    /// The frames of the log.
    total: usize,
    count: u64,
}

/// The frames that are sent.
#[derive(Debug, Default)]
pub struct Transmission {
    /// The transmit list.
    pub list: List,
    log: Option<Sent>,
    /// When the bus has carried the last frame.
    free: Option<Instant>,
}

impl Transmission {
    /// Adds lines to the list, all or none.
    ///
    /// # Errors
    /// The list would be too long.
    pub fn add(&mut self, items: &[Item]) -> Result<(), Error> {
        if self.list.lines().len() + items.len() > LINES {
            return Err(PageError::TooManyLines(LINES).into());
        }
        for item in items {
            self.list.add(*item);
        }
        Ok(())
    }

    /// The line with this number.
    ///
    /// # Errors
    /// There is no such line: another tab has removed it.
    pub fn line(&mut self, number: u64) -> Result<&mut Line, Error> {
        let line = self.list.line(number);
        line.ok_or_else(|| PageError::NoLine(number).into())
    }

    /// Sends a log with this name and number of frames instead of the one before.
    pub fn replay(&mut self, name: String, total: usize, frames: Replay) {
        self.log = Some(Sent {
            name,
            frames: Some(frames),
            total,
            count: 0,
        });
    }

    /// Stops the log.
    pub fn stop_replay(&mut self) {
        if let Some(log) = &mut self.log {
            log.frames = None;
        }
    }

    /// Stops everything: nothing is sent on another bus, or after a pause.
    pub fn stop(&mut self) {
        self.list.stop();
        self.stop_replay();
        self.free = None;
    }

    /// What is sent next: the log only if it is before the list.
    fn next(&self) -> Option<(Instant, Frame, bool)> {
        let log = self.log.as_ref().and_then(|log| log.frames.as_ref());
        let log = log.and_then(Frames::next);
        match (self.list.next(), log) {
            (Some((at, _)), Some((sooner, frame))) if sooner < at => Some((sooner, frame, true)),
            (Some((at, frame)), _) => Some((at, frame, false)),
            (None, log) => log.map(|(at, frame)| (at, frame, true)),
        }
    }

    /// When the next frame is sent.
    pub fn due(&self) -> Option<Instant> {
        let (at, ..) = self.next()?;
        Some(self.free.map_or(at, |free| at.max(free)))
    }

    /// The frame that is sent now.
    pub fn frame(&self, now: Instant) -> Option<Frame> {
        let is_due = self.due()? <= now;
        self.next().filter(|_| is_due).map(|(_, frame, _)| frame)
    }

    /// The adapter has taken this frame.
    pub fn sent(&mut self, frame: &Frame, now: Instant, rate: Option<BitRate>) {
        let is_of_log = self.next().is_some_and(|(.., is_of_log)| is_of_log);
        match &mut self.log {
            Some(log) if is_of_log => {
                log.count += 1;
                log.frames = log.frames.take().and_then(|mut frames| {
                    frames.sent(now);
                    frames.next().is_some().then_some(frames)
                });
            }
            _ => self.list.sent(now),
        }
        self.free = Some(carried(frame, rate, now));
    }

    /// The list and the log, for the page.
    pub fn json(&self) -> Value {
        let line = |line: &Line| {
            json!({
                "number": line.number,
                "frame": format!("{:?}", line.item.frame),
                "every": line.item.every,
                "running": line.next.is_some(),
                "sent": line.sent,
                "leftOut": line.left_out,
            })
        };
        let lines: Vec<Value> = self.list.lines().iter().map(line).collect();
        let log = self.log.as_ref().map(|log| {
            json!({"name": log.name, "frames": log.total, "sent": log.count, "running": log.frames.is_some()})
        });
        json!({"lines": lines, "log": log})
    }
}

/// The item of a line.
///
/// # Errors
/// The frame or the period is not valid.
pub fn item(frame: &str, every: Option<u32>) -> Result<Item, Error> {
    let frame = crate::cli::frames::frame(frame.trim());
    let frame = frame.map_err(|_| PageError::NoFrame)?;
    if every.is_some_and(|every| !(1..=LONGEST).contains(&every)) {
        return Err(PageError::Period(LONGEST).into());
    }
    Ok(Item { frame, every })
}
