//! Frames that are sent at their times: a list of single and periodic frames here, a log in [`replay`](super::replay). The command line
//! waits for each of them; the page sends them beside its requests.

use crate::cli::frames;
use can_wire::frame_length::{INTERMISSION, frame_bits};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use serde::{Deserialize, Deserializer};

/// The longest period in ms.
pub const LONGEST: u32 = 3_600_000;

/// Frames in the order of their times.
pub trait Frames {
    /// The next frame and its time; None: there is no other one.
    fn next(&self) -> Option<(Instant, Frame)>;

    /// The next frame was sent at this time.
    fn sent(&mut self, now: Instant);
}

/// When the bus has carried a frame that is sent at this time.
pub fn carried(frame: &Frame, rate: Option<BitRate>, at: Instant) -> Instant {
    let Some(rate) = rate else {
        return at;
    };
    let bits = u64::from(frame_bits(frame) + INTERMISSION);
    let time = bits * 1_000_000 / u64::from(rate.bits_per_second());
    after(at, Duration::from_ticks(time))
}

/// A frame, and the time between two of them in ms; None: it is sent once.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Item {
    /// The frame.
    #[serde(deserialize_with = "frame")]
    pub frame: Frame,
    /// The period.
    #[serde(default, deserialize_with = "every")]
    pub every: Option<u32>,
}

fn frame<'de, D: Deserializer<'de>>(from: D) -> Result<Frame, D::Error> {
    let text = String::deserialize(from)?;
    frames::frame(&text).map_err(serde::de::Error::custom)
}

fn every<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let every = u32::deserialize(from)?;
    match (1..=LONGEST).contains(&every) {
        true => Ok(Some(every)),
        false => Err(serde::de::Error::custom(format!(
            "every is 1 to {LONGEST} ms"
        ))),
    }
}

/// The items of a list in TOML.
///
/// # Errors
/// A text without a full stop: it is not such a list.
pub fn items(text: &str) -> Result<Vec<Item>, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        send: Vec<Item>,
    }
    let file: Result<File, _> = toml::from_str(text);
    Ok(file.map_err(|error| error.message().to_owned())?.send)
}

/// A line of the list.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// From 1.
    pub number: u64,
    /// What is sent.
    pub item: Item,
    /// When it is sent next; None: it has stopped.
    pub next: Option<Instant>,
    /// The frames that were sent.
    pub sent: u64,
    /// The frames that were too late.
    pub left_out: u64,
}

/// A list of frames, each of which can be started.
#[derive(Debug, Default)]
pub struct List {
    lines: Vec<Line>,
    last: u64,
}

impl List {
    /// Adds a line, which has stopped.
    pub fn add(&mut self, item: Item) {
        self.last += 1;
        self.lines.push(Line {
            number: self.last,
            item,
            next: None,
            sent: 0,
            left_out: 0,
        });
    }

    /// The lines in their order.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// The line with this number.
    pub fn line(&mut self, number: u64) -> Option<&mut Line> {
        self.lines.iter_mut().find(|line| line.number == number)
    }

    /// Removes the line with this number.
    pub fn remove(&mut self, number: u64) {
        self.lines.retain(|line| line.number != number);
    }

    /// Starts all lines.
    pub fn start(&mut self, now: Instant) {
        for line in &mut self.lines {
            line.next = Some(now);
        }
    }

    /// Stops all lines.
    pub fn stop(&mut self) {
        for line in &mut self.lines {
            line.next = None;
        }
    }

    /// The line that is sent next. Of lines with the same time it is the first one.
    fn first(&self) -> Option<usize> {
        let running = self.lines.iter().enumerate();
        let running = running.filter_map(|(place, line)| Some((line.next?, place)));
        running.min().map(|(_, place)| place)
    }
}

impl Frames for List {
    fn next(&self) -> Option<(Instant, Frame)> {
        let line = &self.lines[self.first()?];
        Some((line.next?, line.item.frame))
    }

    fn sent(&mut self, now: Instant) {
        let Some(line) = self.first().map(|place| &mut self.lines[place]) else {
            return;
        };
        line.sent += 1;
        let at = line.next.take();
        let (Some(at), Some(every)) = (at, line.item.every.map(millis)) else {
            return;
        };
        // A frame that is too late is left out: a burst of late frames would have another period.
        let late = now.ticks().saturating_sub(at.ticks()) / every.ticks();
        line.left_out += late;
        line.next = Some(after(at, Duration::from_ticks(every.ticks() * (late + 1))));
    }
}
