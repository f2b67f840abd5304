//! The lines of a log, as `candump -L` and the tool write them.

use can_wire::text::parse;
use plumbline::can::Frame;
use serde_json::Value;
use std::fmt::{self, Display, Formatter};

/// The name of the interface in the logs of the tool.
pub const INTERFACE: &str = "can0";

/// A frame of a log.
#[derive(Clone, PartialEq, Debug)]
pub struct Line {
    /// The time as it is in the log, in seconds.
    pub time: String,
    /// The interface.
    pub interface: String,
    /// The frame.
    pub frame: Frame,
}

impl Line {
    /// The frame of a line of `candump -L`, or of a document of `log --decode` or `decode` with `--json`; None: the line has no frame. What
    /// is behind the frame of `candump` is ignored.
    pub fn parse(text: &str) -> Option<Self> {
        if text.trim_start().starts_with('{') {
            return Self::of(&serde_json::from_str(text).ok()?);
        }
        let mut words = text.split_whitespace();
        let time = words.next()?.strip_prefix('(')?.strip_suffix(')')?;
        let is_time = time.split('.').count() <= 2
            && !time.starts_with('.')
            && time
                .bytes()
                .all(|byte| byte.is_ascii_digit() || byte == b'.');
        let interface = words.next()?;
        let frame = parse(words.next()?).ok()?;
        // A terminal executes control characters.
        let is_shown = !interface.chars().any(char::is_control);
        (is_time && is_shown).then(|| Self {
            time: time.to_owned(),
            interface: interface.to_owned(),
            frame,
        })
    }

    /// The frame of a document.
    fn of(document: &Value) -> Option<Self> {
        let time = document["time"].as_f64().filter(|time| *time >= 0.0)?;
        Some(Self {
            time: format!("{time:.6}"),
            interface: INTERFACE.to_owned(),
            frame: parse(document["frame"].as_str()?).ok()?,
        })
    }

    /// The time in us.
    pub fn micros(&self) -> u64 {
        // A cast saturates.
        let seconds: f64 = self.time.parse().unwrap_or_default();
        (seconds * 1e6).round() as u64
    }
}

impl Display for Line {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "({}) {} {:?}", self.time, self.interface, self.frame)
    }
}
