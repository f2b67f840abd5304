//! The clock of the bus: the clock of the computer, or a clock that the clients advance.
//!
//! With the second clock, the load of the computer does not change a measured time, and a time-out of 10 s takes milliseconds. It adds
//! two kinds of lines to slcan, `@` and `#`: `README.md` of this package describes them. The time stamps of slcan (`Z1`) are not used:
//! they have steps of 1 ms and begin again each minute.

use super::event::ClientId;
use super::{RunError, Server};
use plumbline::time::{Duration, Instant, after};

/// The minimum step: a step for every bit would cost too much computing time.
const STEP_MIN: Duration = Duration::micros(100);

/// The maximum step, for sensors that do not tell when they send.
const STEP_MAX: Duration = Duration::millis(1);

/// The longest line with a meaning for an adapter or for the clock, with its CR.
const LINE_MAX: usize = 64;

/// Where the time comes from.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, clap::ValueEnum)]
pub enum Clock {
    /// The time of the computer
    #[default]
    Computer,
    /// The time stands still until a client sends @ and a span in us (hexadecimal): for tests
    Client,
}

/// The incomplete line of a client that advances the time.
#[derive(Default)]
pub(super) struct Line(Vec<u8>);

impl Server {
    /// Handles input of a client that may advance the time.
    pub(super) fn input_with_clock(&mut self, id: ClientId, bytes: &[u8]) -> Result<(), RunError> {
        for piece in bytes.split_inclusive(|byte| *byte == b'\r') {
            let Some(session) = self.sessions.get_mut(&id) else {
                return Ok(());
            };
            session.line.0.extend_from_slice(piece);
            if piece.ends_with(b"\r") || session.line.0.len() > LINE_MAX {
                let line = core::mem::take(&mut session.line.0);
                match span(&line) {
                    Some(span) => self.advance_for(id, span)?,
                    None => self.input(id, &line),
                }
            }
        }
        Ok(())
    }

    /// Advances the time by `span`, or until the client receives a frame.
    fn advance_for(&mut self, id: ClientId, span: Duration) -> Result<(), RunError> {
        let limit = after(self.bus.now(), span);
        loop {
            self.advance()?;
            let Some(session) = self.sessions.get_mut(&id) else {
                return Ok(());
            };
            let now = self.bus.now();
            if session.received || now >= limit {
                session.received = false;
                let answer = format!("@{:X}\r", now.ticks());
                if !session.push(answer.as_bytes()) {
                    self.leave(id);
                }
                return Ok(());
            }
            self.run_step(limit);
        }
    }

    /// Advances the time to `limit` and passes on the traffic.
    pub(super) fn advance_until(&mut self, limit: Instant) -> Result<(), RunError> {
        self.advance()?;
        while self.bus.now() < limit {
            self.run_step(limit);
            self.advance()?;
        }
        Ok(())
    }

    /// Runs the bus to its next event, at most to `limit`.
    fn run_step(&mut self, limit: Instant) {
        let now = self.bus.now();
        let next = self.bus.next_event().unwrap_or(limit);
        let next = next.clamp(after(now, STEP_MIN), after(now, STEP_MAX));
        self.bus.run_until(next.min(limit));
    }
}

/// The line that tells the time of the next one.
pub(super) fn write_time(at: Instant, lines: &mut Vec<u8>) {
    lines.extend(format!("#{:X}\r", at.ticks()).bytes());
}

/// The span of a line that advances the time.
fn span(line: &[u8]) -> Option<Duration> {
    let digits = line.strip_prefix(b"@")?.strip_suffix(b"\r")?;
    let valid = (1..=8).contains(&digits.len()) && digits.iter().all(u8::is_ascii_hexdigit);
    let text = core::str::from_utf8(digits).ok().filter(|_| valid)?;
    let micros = u64::from_str_radix(text, 16).ok()?;
    Some(Duration::from_ticks(micros))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn span_has_1_to_8_hexadecimal_digits() {
        assert_eq!(span(b"@0\r"), Some(Duration::from_ticks(0)));
        assert_eq!(span(b"@0001f4\r"), Some(Duration::from_ticks(500)));
        assert_eq!(
            span(b"@FFFFFFFF\r"),
            Some(Duration::from_ticks(0xFFFF_FFFF))
        );
        for line in [
            "@\r",
            "@100000000\r",
            "@-1\r",
            "@+1\r",
            "@ 1\r",
            "@1",
            "t0010\r",
            "\r",
        ] {
            assert_eq!(span(line.as_bytes()), None, "{line:?}");
        }
    }
}
