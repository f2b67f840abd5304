//! The slcan protocol (LAWICEL ASCII) on any stream of bytes.
//!
//! ```text
//!  C                    closes the channel; first, because another program may have left it open
//!  S.., s..             the bit rate
//!  O, L                 opens it: active, listen-only
//!  F                    status: F and two hexadecimal digits; bit 0 receive queue full, bit 2 warning, bit 3 overrun,
//!                       bit 5 passive, bit 7 bus error
//!  t.., T.., r.., R..   a frame
//!  CR                   the answer "done"; z CR, Z CR or CR to a frame; BEL is the answer "refused"
//! ```
//!
//! Some adapters, and some programs between, end a line with LF, CR LF or CR CR LF.
//!
//! A line that no slcan adapter says, in the place of the answer to a command, ends it: something else is at this port. Frames, answers to
//! requests of another program (`V`, `N`, `F`), and pieces of frames can come at any time. On an open channel, what cannot be read is counted.
//!
//! In the time of the bus, which only tests use, the server is one with `--clock client`:
//!
//! ```text
//!  @h..h                the time advances by this span in us, or until a frame is received; the answer is the time in us
//!  #h..h                the time of the frame in the next line
//! ```

use super::unread::Unread;
use super::{Adapter, Capabilities, Mode, instant};
use crate::error::AdapterError;
use line::{Line, time_of};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant};
use std::collections::VecDeque;
use std::{io, time};

mod line;
mod open;

pub use line::{read_frame, write_frame};

/// The wait for the answer to a command.
const ANSWER: time::Duration = time::Duration::from_secs(2);

/// The wait for the answer of a server that advances the time of the bus. It computes meanwhile.
const ADVANCED: time::Duration = time::Duration::from_secs(120);

/// The length of the longest valid line: a 29-bit frame with a time stamp of 8 digits.
const LINE_MAX: usize = 40;

/// Bits of the status that are errors of the bus: warning, error passive, bus error.
const ERRORS: u32 = 1 << 2 | 1 << 5 | 1 << 7;

/// Bits of the status that tell of lost frames: receive queue full, overrun.
const LOST: u32 = 1 | 1 << 3;

/// A stream of bytes to an adapter.
pub trait Stream {
    /// Reads what is there, and waits at most this time for it; 0 bytes: nothing came. With a time of 0 it does not wait.
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

/// Where the time comes from.
enum Clock {
    /// The clock of the computer, since this time.
    Computer(time::Instant),
    /// The clock of the bus, which the adapter advances.
    Bus(Instant),
}

/// An adapter with the protocol of slcan, over any stream.
pub struct Slcan<S: Stream> {
    stream: S,
    /// The name of the port, for messages.
    name: String,
    clock: Clock,
    /// The wait for the answer to a command.
    patience: time::Duration,
    mode: Option<Mode>,
    /// This program has closed it, and no other answer can come.
    is_closed: bool,
    line: Vec<u8>,
    /// The last byte was a CR.
    is_after_cr: bool,
    /// A LF has followed a CR.
    has_line_feeds: bool,
    unread: Unread,
    frames: VecDeque<(Instant, Frame)>,
    /// A command waits for its answer.
    is_waiting: bool,
    /// The first letter of that command.
    command: Option<u8>,
    /// The answer to the command that waits, without CR; BEL is an answer with this byte.
    answer: Option<Vec<u8>>,
    /// The first line since the command that no slcan adapter sends.
    foreign: Option<Vec<u8>>,
    /// The time of the bus came in answer to a line that advances it.
    is_advanced: bool,
    /// The time of the frame in the next line.
    stamp: Option<Instant>,
    /// It refused a frame since the last call.
    refused: bool,
    /// It answers the question for its status.
    has_status: bool,
    /// The number of times the status had errors of the bus, and lost frames.
    errors: Option<u64>,
    overruns: Option<u64>,
}

const BEL: u8 = 7;

impl<S: Stream> Slcan<S> {
    /// An adapter on this stream, which is closed at first.
    pub fn new(stream: S, name: &str) -> Self {
        Self {
            stream,
            name: name.to_owned(),
            clock: Clock::Computer(time::Instant::now()),
            patience: ANSWER,
            mode: None,
            is_closed: false,
            line: Vec::new(),
            is_after_cr: false,
            has_line_feeds: false,
            unread: Unread::default(),
            frames: VecDeque::new(),
            is_waiting: false,
            command: None,
            answer: None,
            foreign: None,
            is_advanced: false,
            stamp: None,
            refused: false,
            has_status: true,
            errors: None,
            overruns: None,
        }
    }

    /// The same in the time of the bus: the server advances it on request.
    ///
    /// # Errors
    /// The server does not advance the time, or the stream has failed.
    pub fn in_bus_time(mut self) -> Result<Self, AdapterError> {
        self.clock = Clock::Bus(Instant::from_ticks(0));
        // The answers depend on the load of the computer; the time of the bus does not.
        self.patience = ADVANCED;
        self.advance(Duration::from_ticks(0))?;
        Ok(self)
    }

    fn lost(&self, error: &io::Error) -> AdapterError {
        let (name, reason) = (self.name.clone(), error.to_string());
        match name.starts_with("slcan://") {
            true => AdapterError::ServerLost(name, reason),
            false => AdapterError::Lost(name, reason),
        }
    }

    /// Reads what is there, and waits at most this time for it. False: nothing came.
    fn read(&mut self, timeout: time::Duration) -> Result<bool, AdapterError> {
        let mut bytes = [0; 4096];
        let count = match self.stream.read(&mut bytes, timeout) {
            Ok(count) => count,
            Err(error) => return Err(self.lost(&error)),
        };
        let now = self.now();
        for (place, &byte) in bytes[..count].iter().enumerate() {
            let was_after_cr = std::mem::replace(&mut self.is_after_cr, byte == b'\r');
            match byte {
                b'\n' if was_after_cr => self.has_line_feeds = true,
                // A part of CR CR LF; without LF it is an empty line.
                b'\r'
                    if was_after_cr
                        && (self.has_line_feeds || is_line_feed(&bytes[place..count])) => {}
                b'\r' | b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    self.take(now, line);
                }
                BEL => {
                    self.line.clear();
                    if self.is_waiting {
                        self.answer = Some(vec![BEL]);
                    } else if self.mode.is_some() {
                        self.refused = true;
                    }
                }
                _ if self.line.len() < LINE_MAX => self.line.push(byte),
                _ => {}
            }
        }
        Ok(count > 0)
    }

    /// Takes a complete line. On an open channel, a line that cannot be read is counted.
    fn take(&mut self, now: Instant, line: Vec<u8>) {
        let line = line.trim_ascii().to_vec();
        match (Line::of(&line), &mut self.clock) {
            (Line::Frame, _) => {
                let at = self.stamp.take().unwrap_or(now);
                if let Some(frame) = read_frame(&line) {
                    self.frames.push_back((at, frame));
                } else if self.mode.is_some() {
                    self.unread.take(line);
                }
            }
            (Line::Time, Clock::Bus(_)) if line[0] == b'#' => self.stamp = time_of(&line),
            (Line::Time, Clock::Bus(clock)) => {
                *clock = time_of(&line).unwrap_or(*clock);
                self.is_advanced = true;
            }
            (Line::Done, _) if self.is_waiting => self.answer = Some(line),
            (Line::Told, _) if self.is_waiting && self.command == line.first().copied() => {
                self.answer = Some(line);
            }
            (Line::Foreign, _) if self.is_waiting => {
                self.foreign.get_or_insert(line);
            }
            (Line::Piece | Line::Foreign, _) if self.mode.is_some() => self.unread.take(line),
            _ => {}
        }
    }

    /// Reads until something came, or until this time of the bus or computer.
    fn pump(&mut self, until: Instant) -> Result<(), AdapterError> {
        let wait = until.ticks().saturating_sub(self.now().ticks());
        match self.clock {
            Clock::Computer(_) => self.read(time::Duration::from_micros(wait)).map(|_| ()),
            Clock::Bus(_) => self.advance(Duration::from_ticks(wait)),
        }
    }

    /// Advances the time of the bus by this span, or until a frame is received.
    fn advance(&mut self, span: Duration) -> Result<(), AdapterError> {
        self.is_advanced = false;
        self.write(&format!("@{:X}", span.ticks().min(0xFFFF_FFFF)))?;
        let start = time::Instant::now();
        while !self.is_advanced {
            let left = ADVANCED.checked_sub(start.elapsed());
            self.read(left.ok_or_else(|| self.silent())?)?;
        }
        Ok(())
    }

    /// Sends a command and returns its answer; None if the adapter is silent. Text that no slcan adapter says is an error.
    fn command(&mut self, command: &str) -> Result<Option<Vec<u8>>, AdapterError> {
        (self.answer, self.foreign) = (None, None);
        self.command = command.bytes().next();
        self.write(command)?;
        self.is_waiting = true;
        let answer = self.answer();
        self.is_waiting = false;
        answer
    }

    fn answer(&mut self) -> Result<Option<Vec<u8>>, AdapterError> {
        let start = time::Instant::now();
        loop {
            let left = self.patience.saturating_sub(start.elapsed());
            self.read(left)?;
            if let Some(said) = self.foreign.take() {
                return Err(self.no_adapter(&said));
            }
            if self.answer.is_some() || left.is_zero() {
                return Ok(self.answer.take());
            }
        }
    }

    fn write(&mut self, command: &str) -> Result<(), AdapterError> {
        // The next CR is an answer.
        self.is_after_cr = false;
        let line = format!("{command}\r");
        let written = self.stream.write(line.as_bytes());
        written.map_err(|error| self.lost(&error))
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

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.mode = None;
        let is_closed = std::mem::take(&mut self.is_closed);
        if !is_closed || self.start(rate, mode).is_err() {
            self.reset()?;
            if let Err(failure) = self.start(rate, mode) {
                // It can be open without having said so, at a wrong rate.
                let _ = self.command("C");
                return Err(failure);
            }
        }
        self.frames.clear();
        self.refused = false;
        (self.errors, self.overruns) = (None, None);
        self.mode = Some(mode);
        Ok(())
    }

    fn close(&mut self) {
        // An answer to a sent frame can come late. The adapter must not read it as the answer to a later command.
        let has_listened = self.mode.take() == Some(Mode::Listen);
        // An adapter that has failed cannot be closed.
        let answer = self.command("C");
        self.is_closed = has_listened && matches!(answer, Ok(Some(said)) if said.is_empty());
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        if self.mode != Some(Mode::Active) {
            return Err(AdapterError::NotOpen);
        }
        self.write(&write_frame(frame))
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        loop {
            // It reads before it compares the time: a late call still receives the frames that have already arrived. A late call does not
            // wait, so it also ends if frames come continuously.
            if self.frames.is_empty() {
                self.pump(until)?;
            }
            if let Some(received) = self.frames.pop_front() {
                return Ok(Some(received));
            }
            if std::mem::take(&mut self.refused) {
                return Err(AdapterError::FrameRefused(self.name.clone()));
            }
            if self.now() >= until {
                return Ok(None);
            }
        }
    }

    fn now(&self) -> Instant {
        match self.clock {
            Clock::Computer(start) => instant(start.elapsed()),
            Clock::Bus(now) => now,
        }
    }

    fn errors(&mut self) -> Option<u64> {
        self.read_status()?;
        self.errors
    }

    fn overruns(&mut self) -> Option<u64> {
        self.read_status()?;
        self.overruns
    }

    fn unread(&self) -> Option<Unread> {
        Some(self.unread.clone())
    }
}

/// Whether these are CR and then a LF.
fn is_line_feed(bytes: &[u8]) -> bool {
    bytes.iter().find(|byte| **byte != b'\r') == Some(&b'\n')
}

impl<S: Stream> Drop for Slcan<S> {
    fn drop(&mut self) {
        if self.mode.is_some() {
            self.close();
        }
    }
}

#[cfg(test)]
mod tests;
