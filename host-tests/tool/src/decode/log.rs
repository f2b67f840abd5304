//! The lines of a log, as `candump -L` and the tool write them.

use crate::error::{Error, FileError};
use crate::output::Terminal;
use bench::file::open;
use can_wire::text::parse;
use plumbline::can::Frame;
use serde_json::Value;
use std::fmt::{self, Display, Formatter};
use std::io::{self, BufRead, BufReader, stdin};
use std::path::Path;

/// The path that stands for standard input.
pub const INPUT: &str = "-";

/// The longest line of a log, in bytes.
const LONGEST: u64 = 4096;

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

/// What is done with a frame.
type Take<'a> = &'a mut dyn FnMut(&mut Terminal, Line) -> Result<(), Error>;

/// Hands each frame of a log to `take`. Returns the number of lines without a frame.
///
/// # Errors
/// The file cannot be read or has no frame, or `take` fails.
pub fn each(path: &Path, terminal: &mut Terminal, take: Take) -> Result<u64, Error> {
    let name = path.display().to_string();
    if path == Path::new(INPUT) {
        return each_of(&mut stdin().lock(), &name, terminal, take);
    }
    // Programs read a log twice, and a pipe has it once: standard input is the path for a pipe.
    let file = open(path).map_err(|error| unread(&name, &error))?;
    each_of(&mut BufReader::new(file), &name, terminal, take)
}

fn unread(name: &str, error: &dyn Display) -> FileError {
    FileError::LogUnread(name.to_owned(), error.to_string())
}

/// The same with the lines of a log with this name.
///
/// # Errors
/// They cannot be read or have no frame, or `take` fails.
pub fn each_of(
    input: &mut dyn BufRead,
    name: &str,
    terminal: &mut Terminal,
    take: Take,
) -> Result<u64, Error> {
    let (mut frames, mut others) = (0, 0);
    let mut bytes = Vec::new();
    while !(terminal.stopped)() {
        bytes.clear();
        let length = io::Read::take(&mut *input, LONGEST).read_until(b'\n', &mut bytes);
        if length.map_err(|error| unread(name, &error))? == 0 {
            break;
        }
        match Line::parse(&String::from_utf8_lossy(&bytes)) {
            Some(line) => {
                frames += 1;
                take(terminal, line)?;
            }
            None if bytes.trim_ascii().is_empty() => {}
            None => others += 1,
        }
    }
    match frames {
        0 => Err(FileError::NoLog(name.to_owned()).into()),
        _ => Ok(others),
    }
}
