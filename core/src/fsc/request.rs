//! Requests on the Set-Parameter-ID (table 17) and what each one does (sections 9.7 to 9.10).
//!
//! A refused request is answered with its code and the status, CmdParamError set, and changes nothing.

use super::code;
use super::key::Key;
use super::sensor::{Saving, Sensor};
use super::status::Status;
use super::table::{Model, Rule};
use super::wire::{self, Reply};
use crate::can::Frame;
use crate::time::Instant;

impl<M: Model> Sensor<M> {
    /// Answers the request in `frame`.
    pub(super) fn request(&mut self, now: Instant, frame: &Frame) {
        let Some((&fsc, data)) = frame.bytes().split_first() else {
            // There is no code to echo, so there is no reply.
            self.status.raise(Status::CMD_PARAM_ERROR);
            return;
        };
        if self.must_wait(fsc, data) {
            self.deferred = Some(*frame);
            return;
        }
        match fsc {
            code::INCLINATION => self.send(self.inclination()),
            code::STATUS => {
                self.reply(fsc);
                self.status.replace(Status::STICKY, 0);
            }
            code::PRODUCT => self.reply_product(),
            code::SERIAL => self.reply_serial(),
            code::LOAD if data.starts_with(code::LOAD_SIGNATURE) => {
                self.begin_save(Saving::Factory);
            }
            code::SAVE if data.starts_with(code::SAVE_SIGNATURE) => {
                self.begin_save(Saving::Parameters);
            }
            code::ALIVE if data.starts_with(code::RESET_SIGNATURE) => self.restart(now),
            code::ALIVE => {
                if !data.is_empty() {
                    self.status.raise(Status::CMD_PARAM_ERROR);
                }
                self.reply_alive();
            }
            _ => self.parameter(now, fsc, data),
        }
    }

    /// Reads or writes a parameter; any other code is invalid.
    fn parameter(&mut self, now: Instant, fsc: u8, data: &[u8]) {
        let row = usize::from(fsc & 0x0F);
        match (fsc & 0xF0, M::RULES.get(row)) {
            (code::READ, Some(rule)) => {
                let reply = Reply::new(fsc, self.status.0);
                self.send(reply.with(self.values.at(row), rule.size));
            }
            (code::WRITE, Some(rule)) => {
                let written = self.write(now, row, rule, data);
                if written.is_none() {
                    self.status.raise(Status::CMD_PARAM_ERROR);
                }
                self.reply(fsc);
            }
            _ => {
                self.status.raise(Status::CMD_PARAM_ERROR);
                self.reply(fsc);
            }
        }
    }

    /// Writes a parameter if its value is permitted and puts it into force, if it is not one that waits for a restart.
    fn write(&mut self, now: Instant, row: usize, rule: &Rule, data: &[u8]) -> Option<()> {
        let zero_x = row == Key::ZeroX as usize;
        let zero_y = row == Key::ZeroY as usize;
        let value = match data {
            // Without data: automatic zero point adjustment (section 9.2).
            [] if zero_x => M::zero_for(self.measured.x),
            [] if zero_y => M::zero_for(self.measured.y),
            _ => wire::number(data, rule.size)?,
        };
        if !self.values.permits(row, rule, value) {
            return None;
        }
        let was_cyclic = self.values.is_cyclic();
        self.values.set(row, rule, value);
        if row == Key::Filter as usize {
            self.retune();
        } else if row == Key::CyclicMode as usize && was_cyclic != self.values.is_cyclic() {
            self.restart_cyclic(now);
        } else if row == Key::CyclicTime as usize
            && let Some(cyclic) = &mut self.cyclic
        {
            cyclic.set_period(now, value);
            self.attention = true;
        }
        self.update_status();
        Some(())
    }

    /// Whether a request must wait for the running save to end: another save or a restart, and while LOAD is under way, which
    /// will replace the parameters, also a write.
    fn must_wait(&self, fsc: u8, data: &[u8]) -> bool {
        match self.saving {
            None => false,
            Some(saving) => match fsc {
                code::LOAD | code::SAVE => true,
                code::ALIVE => data.starts_with(code::RESET_SIGNATURE),
                _ => saving == Saving::Factory && fsc & 0xF0 == code::WRITE,
            },
        }
    }

    /// Carries the request out that waited for the save which has ended.
    pub(super) fn resume(&mut self, now: Instant) {
        if let Some(frame) = self.deferred.take() {
            self.request(now, &frame);
        }
    }
}
