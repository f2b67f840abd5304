//! Lines of slcan: the commands of the bit rates, and frames.
//!
//! ```text
//!  S0 .. S8               10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s
//!  s071C                  62.5 kbit/s: bit timing registers of the SJA1000 at 16 MHz
//!  tIIIL.., TIIIIIIIIL..  a frame with 11 or 29 bits: identifier, length, data; r and R: a remote frame
//!  s.., e..               events of some adapters: the state (sa000000), an error (e1a)
//!  xIIIIIIIIL..           a frame with 29 bits of some adapters
//!  Vhhhh, Nxxxx, Fhh      the answers to V (version), N (serial number) and F (status)
//! ```

use can_wire::slcan::{self, RATES};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;

/// The command of the only bit rate that is not in the table of slcan.
const K62_5: &str = "s071C";

/// What a line of an adapter is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Line {
    /// Empty: a command is done.
    Done,
    /// A frame, also a damaged one.
    Frame,
    /// The answer to a frame that was sent.
    Sent,
    /// The answer to `V`, `v`, `N` or `F`.
    Told,
    /// What some adapters report by themselves: a state, or an error of the bus.
    Event,
    /// The end or middle of frames whose beginning was lost, or something like a frame with an unknown first letter.
    Piece,
    /// The time of the bus, if the adapter has it.
    Time,
    /// A line that no slcan adapter sends.
    Foreign,
}

/// The longest text behind `V`, `v`, `N` or `F`.
const TOLD_MAX: usize = 16;

/// The fewest digits behind the first letter of something like a frame.
const FRAME_MIN: usize = 4;

/// The longest text of an event behind its first letter.
const EVENT_MAX: usize = 9;

impl Line {
    /// The kind of a line without CR.
    pub(super) fn of(line: &[u8]) -> Self {
        let is_frames = |byte: &u8| byte.is_ascii_hexdigit() || b"tTrRzZ".contains(byte);
        let Some((first, rest)) = line.split_first() else {
            return Self::Done;
        };
        match first {
            b't' | b'T' | b'r' | b'R' | b'x' => Self::Frame,
            b'z' | b'Z' => Self::Sent,
            b'#' | b'@' => Self::Time,
            b'F' if rest.len() == 2 && rest.iter().all(u8::is_ascii_hexdigit) => Self::Told,
            b'V' | b'v' | b'N'
                if rest.len() <= TOLD_MAX && rest.iter().all(u8::is_ascii_alphanumeric) =>
            {
                Self::Told
            }
            b's' | b'e'
                if rest.len() <= EVENT_MAX && rest.iter().all(u8::is_ascii_alphanumeric) =>
            {
                Self::Event
            }
            _ if line.iter().all(is_frames) => Self::Piece,
            b'a'..=b'z' | b'A'..=b'Z'
                if rest.len() >= FRAME_MIN && rest.iter().all(u8::is_ascii_hexdigit) =>
            {
                Self::Piece
            }
            _ => Self::Foreign,
        }
    }
}

/// The command that sets a bit rate.
pub(super) fn rate_command(rate: BitRate) -> String {
    let place = RATES.iter().position(|own| *own == rate);
    place.map_or(K62_5.to_owned(), |place| format!("S{place}"))
}

/// A frame as a line without CR.
pub fn write_frame(frame: &Frame) -> String {
    let mut line = Vec::new();
    slcan::write_frame(frame, &mut line);
    line.into_iter().map(char::from).collect()
}

/// The frame of a line without CR; None if the line is no valid frame. A time stamp of 4 or 8 digits behind it is ignored.
pub fn read_frame(line: &[u8]) -> Option<Frame> {
    let named = line.strip_prefix(b"x").map(|rest| [b"T", rest].concat());
    let (frame, stamp) = slcan::read_frame(named.as_deref().unwrap_or(line))?;
    let is_stamp = matches!(stamp.len(), 0 | 4 | 8) && stamp.iter().all(u8::is_ascii_hexdigit);
    is_stamp.then_some(frame)
}

/// The time of a line of the clock of the bus.
pub(super) fn time_of(line: &[u8]) -> Option<Instant> {
    let digits = std::str::from_utf8(line.get(1..)?).ok()?;
    u64::from_str_radix(digits, 16)
        .ok()
        .map(Instant::from_ticks)
}
