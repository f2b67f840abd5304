//! The slcan protocol (LAWICEL ASCII) on any stream of bytes.
//!
//! ```text
//!  C                    closes the channel; always first, because another program may have left it open
//!  S0 .. S8             10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s
//!  s071C                62.5 kbit/s: bit timing registers of the SJA1000 at 16 MHz
//!  O, L                 opens it: active, listen-only
//!  F                    status: F and two hexadecimal digits; bit 2 warning, bit 3 overrun, bit 5 passive, bit 7 bus error
//!  tIIIL.., TIIIIIIIIL..  a frame with 11 or 29 bits: identifier, length, data; r and R: a remote frame
//!  CR                   the answer "done"; z CR or Z CR to a frame; BEL is the answer "refused"
//! ```

use super::bench::not_active;
use super::{Adapter, Capabilities, Mode};
use crate::failure::Failure;
use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::time::{Duration, Instant, after, millis};
use std::collections::VecDeque;
use std::{io, time};

/// The wait for the answer to a command.
const ANSWER: Duration = millis(500);

/// The longest line that is no nonsense: a 29-bit frame with a time stamp of 8 digits.
const LINE_MAX: usize = 40;

/// Bits of the status that are errors of the bus: warning, error passive, bus error.
const ERRORS: u32 = 1 << 2 | 1 << 5 | 1 << 7;

/// A stream of bytes to an adapter.
pub trait Stream {
    /// Reads what is there, and waits at most this time for it; 0 bytes: nothing came.
    ///
    /// # Errors
    /// The stream has failed or has ended.
    fn read(&mut self, bytes: &mut [u8], timeout: time::Duration) -> io::Result<usize>;

    /// Writes all bytes.
    ///
    /// # Errors
    /// The stream has failed.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// An slcan adapter.
pub struct Slcan<S: Stream> {
    stream: S,
    /// Its name for messages.
    name: String,
    start: time::Instant,
    mode: Option<Mode>,
    line: Vec<u8>,
    frames: VecDeque<(Instant, Frame)>,
    /// Answers other than those to frames, without CR; BEL is an answer with this byte.
    answers: VecDeque<Vec<u8>>,
    /// It refused a frame since the last call.
    refused: bool,
    errors: Option<u64>,
}

const BEL: u8 = 7;

impl<S: Stream> Slcan<S> {
    /// An adapter on this stream, which is closed at first.
    pub fn new(stream: S, name: &str) -> Self {
        Self {
            stream,
            name: name.to_owned(),
            start: time::Instant::now(),
            mode: None,
            line: Vec::new(),
            frames: VecDeque::new(),
            answers: VecDeque::new(),
            refused: false,
            errors: None,
        }
    }

    fn lost(&self, error: &io::Error) -> Failure {
        let name = &self.name;
        let message =
            format!("the adapter {name} has failed ({error}): plug it in again and repeat");
        Failure::bus("adapter-lost", message)
    }

    /// Reads until `until` or until something came.
    fn pump(&mut self, until: Instant) -> Result<(), Failure> {
        let wait = until.ticks().saturating_sub(self.now().ticks());
        let mut bytes = [0; 4096];
        let timeout = time::Duration::from_micros(wait.max(100));
        let count = match self.stream.read(&mut bytes, timeout) {
            Ok(count) => count,
            Err(error) => return Err(self.lost(&error)),
        };
        let now = self.now();
        for &byte in &bytes[..count] {
            match byte {
                b'\r' => {
                    let line = std::mem::take(&mut self.line);
                    self.take(now, line);
                }
                BEL => {
                    self.line.clear();
                    if self.mode.is_some() && self.answers.is_empty() {
                        self.refused = true;
                    }
                    self.answers.push_back(vec![BEL]);
                }
                _ if self.line.len() < LINE_MAX => self.line.push(byte),
                _ => {}
            }
        }
        Ok(())
    }

    /// Takes a complete line. A line that is neither a frame nor an answer is ignored.
    fn take(&mut self, now: Instant, line: Vec<u8>) {
        match line.first() {
            Some(b't' | b'T' | b'r' | b'R') => {
                if let Some(frame) = read_frame(&line) {
                    self.frames.push_back((now, frame));
                }
            }
            // The answer to a frame that was sent.
            Some(b'z' | b'Z') => {}
            _ => self.answers.push_back(line),
        }
    }

    /// Sends a command and returns its answer; None if the adapter is silent.
    fn command(&mut self, command: &str) -> Result<Option<Vec<u8>>, Failure> {
        self.answers.clear();
        self.write(command)?;
        let until = after(self.now(), ANSWER);
        loop {
            if let Some(answer) = self.answers.pop_front() {
                return Ok(Some(answer));
            }
            if self.now() >= until {
                return Ok(None);
            }
            self.pump(until)?;
        }
    }

    fn write(&mut self, command: &str) -> Result<(), Failure> {
        let line = format!("{command}\r");
        let written = self.stream.write(line.as_bytes());
        written.map_err(|error| self.lost(&error))
    }

    /// Sends a command that the adapter must accept.
    fn must(&mut self, command: &str, refusal: (&'static str, String)) -> Result<(), Failure> {
        match self.command(command)? {
            Some(answer) if answer == [BEL] => Err(Failure::bus(refusal.0, refusal.1)),
            Some(_) => Ok(()),
            None => Err(Failure::bus(
                "adapter-silent",
                format!(
                    "{} does not answer as an slcan adapter: check the port",
                    self.name
                ),
            )),
        }
    }
}

impl<S: Stream> Adapter for Slcan<S> {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: true,
            sets_rate: true,
            needs_rate: true,
            reports_errors: false,
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), Failure> {
        self.mode = None;
        // An answer to an earlier, incomplete line comes first. A closed adapter may refuse C.
        self.command("")?;
        self.command("C")?;
        if let Some(rate) = rate {
            let refusal = format!(
                "{} cannot have {}: use another rate",
                self.name,
                rate.name()
            );
            self.must(rate_command(rate), ("rate-refused", refusal))?;
        }
        let (command, refusal) = match mode {
            Mode::Active => (
                "O",
                ("adapter-refused", format!("{} does not open", self.name)),
            ),
            Mode::Listen => {
                let text = "has no listen-only mode, so it was not opened; --active asks without listening first";
                ("L", ("no-listen-only", format!("{} {text}", self.name)))
            }
        };
        self.must(command, refusal)?;
        self.frames.clear();
        self.refused = false;
        self.errors = None;
        self.mode = Some(mode);
        Ok(())
    }

    fn close(&mut self) {
        self.mode = None;
        // An adapter that has failed cannot be closed.
        let _ = self.command("C");
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Failure> {
        if self.mode != Some(Mode::Active) {
            return Err(not_active());
        }
        self.write(&write_frame(frame))
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, Failure> {
        loop {
            if let Some(received) = self.frames.pop_front() {
                return Ok(Some(received));
            }
            if std::mem::take(&mut self.refused) {
                let name = &self.name;
                let message = format!(
                    "{name} refused a frame, because its queue is full or the bus is off: check the bit rate and the wiring"
                );
                return Err(Failure::bus("frame-refused", message));
            }
            if self.now() >= until {
                return Ok(None);
            }
            self.pump(until)?;
        }
    }

    fn now(&self) -> Instant {
        let elapsed = self.start.elapsed().as_micros();
        Instant::from_ticks(elapsed.try_into().unwrap_or(u64::MAX))
    }

    fn errors(&mut self) -> Option<u64> {
        self.mode?;
        let answer = self.command("F").ok()??;
        self.refused = false;
        let digits = answer.strip_prefix(b"F")?;
        let status = u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
        let errors = self.errors.get_or_insert(0);
        *errors += u64::from(status & ERRORS != 0);
        self.errors
    }
}

impl<S: Stream> Drop for Slcan<S> {
    fn drop(&mut self) {
        if self.mode.is_some() {
            self.close();
        }
    }
}

/// The command that sets a bit rate.
fn rate_command(rate: BitRate) -> &'static str {
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

#[cfg(test)]
mod tests;
