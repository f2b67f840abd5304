//! Closes, sets and opens the channel of an adapter, says why that fails, and reads its status.

use super::line::rate_command;
use super::{BEL, Clock, ERRORS, LOST, Slcan, Stream};
use crate::Mode;
use crate::error::AdapterError;
use plumbline::can::BitRate;
use plumbline::time::Duration;
use std::time;
use texts::shown;

/// An adapter that has sent nothing for this time has answered everything.
const QUIET: time::Duration = time::Duration::from_millis(20);

/// The longest time until an adapter that was closed sends nothing.
const DRAINED: time::Duration = time::Duration::from_millis(500);

impl<S: Stream> Slcan<S> {
    pub(super) fn silent(&self) -> AdapterError {
        AdapterError::NotSlcan(self.name.clone())
    }

    /// Something else is at this port, which says this.
    pub(super) fn no_adapter(&self, said: &[u8]) -> AdapterError {
        let said = shown(&String::from_utf8_lossy(said));
        AdapterError::Foreign(self.name.clone(), said)
    }

    /// Reads until the adapter sends nothing more, so that a late answer is not read as the answer to the next command.
    fn drain(&mut self) -> Result<(), AdapterError> {
        if let Clock::Bus(_) = self.clock {
            return self.advance(Duration::from_ticks(0));
        }
        let start = time::Instant::now();
        while self.read(QUIET)? && start.elapsed() < DRAINED {}
        Ok(())
    }

    /// Sends a command that the adapter must accept.
    fn must(&mut self, command: &str, refusal: AdapterError) -> Result<(), AdapterError> {
        match self.command(command)? {
            Some(answer) if answer == [BEL] => Err(refusal),
            Some(_) => Ok(()),
            None => Err(self.silent()),
        }
    }

    /// Closes the channel, independent of the state that another program has left.
    pub(super) fn reset(&mut self) -> Result<(), AdapterError> {
        // The first one can be the end of an incomplete line. A closed adapter may refuse C.
        let answers = [self.command("C")?, self.command("C")?];
        if answers.iter().all(Option::is_none) {
            return Err(self.silent());
        }
        self.drain()
    }

    /// Sets the rate of the closed channel and opens it.
    pub(super) fn start(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        if let Some(rate) = rate {
            let refusal = AdapterError::RateRefused(self.name.clone(), rate.name());
            self.must(&rate_command(rate), refusal)?;
        }
        let name = self.name.clone();
        let (command, refusal) = match mode {
            Mode::Active => ("O", AdapterError::OpenRefused(name)),
            Mode::Listen => ("L", AdapterError::NoListenOnly(name)),
        };
        self.must(command, refusal)
    }

    /// Reads the status and counts what it tells. The adapter clears it then. None: there is none.
    pub(super) fn read_status(&mut self) -> Option<()> {
        self.mode.filter(|_| self.has_status)?;
        // An adapter that does not know F does not answer. It is not asked again, because each request would wait for the time-out.
        let answer = self.command("F").ok().flatten();
        self.has_status = answer.is_some();
        let answer = answer?;
        let digits = answer.strip_prefix(b"F")?;
        let status = u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
        *self.errors.get_or_insert(0) += u64::from(status & ERRORS != 0);
        *self.overruns.get_or_insert(0) += u64::from(status & LOST != 0);
        Some(())
    }
}
