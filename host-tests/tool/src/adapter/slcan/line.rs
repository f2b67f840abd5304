//! Lines of slcan: the commands of the bit rates, and frames.
//!
//! ```text
//!  S0 .. S8               10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s
//!  s071C                  62.5 kbit/s: bit timing registers of the SJA1000 at 16 MHz
//!  tIIIL.., TIIIIIIIIL..  a frame with 11 or 29 bits: identifier, length, data; r and R: a remote frame
//!  s.., e..               events of some adapters: the state (sa000000), an error (e1a)
//!  Vhhhh, Nxxxx, Fhh      the answers to V (version), N (serial number) and F (status)
//! ```

use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::time::Instant;

/// What a line of an adapter is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Line {
    /// Empty: a command is done.
    Done,
    /// A frame, also a damaged one.
    Frame,
    /// A frame was sent.
    Sent,
    /// The answer to `V`, `v`, `N` or `F`.
    Told,
    /// What some adapters report by themselves: a state, or an error of the bus.
    Event,
    /// The end or middle of frames whose beginning was lost.
    Piece,
    /// The time of the bus, if the adapter has it.
    Time,
    /// No adapter says this.
    Foreign,
}

/// The longest text behind `V`, `v`, `N` or `F`.
const TOLD_MAX: usize = 16;

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
            b't' | b'T' | b'r' | b'R' => Self::Frame,
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
            _ => Self::Foreign,
        }
    }
}

/// The command that sets a bit rate.
pub(super) fn rate_command(rate: BitRate) -> &'static str {
    match rate {
        BitRate::K10 => "S0",
        BitRate::K20 => "S1",
        BitRate::K50 => "S2",
        BitRate::K62_5 => "s071C",
        BitRate::K100 => "S3",
        BitRate::K125 => "S4",
        BitRate::K250 => "S5",
        BitRate::K500 => "S6",
        BitRate::K800 => "S7",
        BitRate::M1 => "S8",
    }
}

/// A frame as a line without CR.
pub fn write_frame(frame: &Frame) -> String {
    use embedded_can::Id;
    let kind = if frame.is_remote() { 'r' } else { 't' };
    let mut line = match frame.id() {
        Id::Standard(id) => format!("{kind}{:03X}", id.as_raw()),
        Id::Extended(id) => format!("{}{:08X}", kind.to_ascii_uppercase(), id.as_raw()),
    };
    line.push_str(&frame.dlc().to_string());
    for byte in frame.bytes() {
        line.push_str(&format!("{byte:02X}"));
    }
    line
}

/// The frame of a line without CR; None if the line is no valid frame. A time stamp of 4 or 8 digits behind it is ignored.
pub fn read_frame(line: &[u8]) -> Option<Frame> {
    let line = std::str::from_utf8(line)
        .ok()
        .filter(|line| line.is_ascii())?;
    let (kind, rest) = line.split_at_checked(1)?;
    let digits = if kind.chars().all(char::is_lowercase) {
        3
    } else {
        8
    };
    let (id, rest) = rest.split_at_checked(digits)?;
    let id = hexadecimal(id)?;
    let id = match digits {
        3 if id <= 0x7FF => standard(id as u16),
        8 if id <= 0x1FFF_FFFF => extended(id),
        _ => return None,
    };
    let (length, rest) = rest.split_at_checked(1)?;
    let length = length.parse::<usize>().ok().filter(|length| *length <= 8)?;
    if kind.eq_ignore_ascii_case("r") {
        return time_stamp(rest).then(|| Frame::remote(id, length))?;
    }
    let (data, rest) = rest.split_at_checked(2 * length)?;
    let mut bytes = [0; 8];
    for (place, byte) in bytes.iter_mut().take(length).enumerate() {
        *byte = hexadecimal(&data[2 * place..2 * place + 2])? as u8;
    }
    time_stamp(rest).then(|| Frame::data(id, &bytes[..length]))?
}

fn hexadecimal(text: &str) -> Option<u32> {
    let valid = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    valid.then(|| u32::from_str_radix(text, 16).ok())?
}

fn time_stamp(text: &str) -> bool {
    matches!(text.len(), 0 | 4 | 8) && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The time of a line of the clock of the bus.
pub(super) fn time_of(line: &[u8]) -> Option<Instant> {
    let digits = std::str::from_utf8(line.get(1..)?).ok()?;
    u64::from_str_radix(digits, 16)
        .ok()
        .map(Instant::from_ticks)
}
