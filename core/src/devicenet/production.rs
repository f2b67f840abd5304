//! The production of COS and cyclic messages (connection 4), and the repetition of messages that are not acknowledged.
//!
//! The first message is sent when the connection is established. A COS message follows when a word differs from the one last sent by
//! the COS delta or more, and at the expected packet rate (EPR). A cyclic message follows at the EPR only. The production inhibit
//! time delays a COS message.

use crate::time::{Deadline, Instant, after, millis};

/// The words of a message: as many as the assembly has, the others are 0.
pub(super) type Words = [u16; 4];

/// What causes a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Trigger {
    Off,
    /// A change of the words, and the EPR.
    Change,
    /// The EPR, not a change.
    Cyclic,
}

/// The messages of the producing connection (COS or cyclic).
#[derive(Clone, Copy, Debug)]
pub(super) struct Production {
    trigger: Trigger,
    /// The next message at the EPR.
    next: Deadline,
    rate: u16,
    /// The production inhibit time in ms.
    inhibit: u16,
    /// The end of the inhibit time after the last message.
    inhibited: Deadline,
    /// The words have changed since the last message.
    changed: bool,
    /// The words of the last message, with which changes are compared.
    sent: Words,
}

impl Production {
    pub const OFF: Self = Self {
        trigger: Trigger::Off,
        next: Deadline::NEVER,
        rate: 0,
        inhibit: 0,
        inhibited: Deadline::NEVER,
        changed: false,
        sent: [0; 4],
    };

    /// Stops. The inhibit time gets its default 0.
    pub fn stop(&mut self) {
        *self = Self::OFF;
    }

    pub fn is_running(&self) -> bool {
        self.trigger != Trigger::Off
    }

    /// Sets the EPR in ms. If nothing was sent yet, the first message is due now. The EPR in force moves no message.
    pub fn set_rate(&mut self, now: Instant, rate: u16, is_cyclic: bool) {
        let is_new = rate != self.rate;
        self.rate = rate;
        if self.is_running() {
            if is_new {
                self.restart(now);
            }
            return;
        }
        self.trigger = if is_cyclic {
            Trigger::Cyclic
        } else {
            Trigger::Change
        };
        self.next = Deadline::at(now);
    }

    /// The production inhibit time in ms.
    pub fn inhibit(&self) -> u16 {
        self.inhibit
    }

    /// Sets the production inhibit time in ms. It begins with the last message.
    pub fn set_inhibit(&mut self, inhibit: u16) {
        let [old, new] = [self.inhibit, inhibit].map(|ms| millis(ms.into()));
        self.inhibited = self.inhibited.with_delay(old, new);
        self.inhibit = inhibit;
    }

    /// The next message is due at the EPR after `now`.
    fn restart(&mut self, now: Instant) {
        self.next = if self.rate > 0 {
            Deadline::after(now, millis(self.rate.into()))
        } else {
            Deadline::NEVER
        };
    }

    /// Whether new values must be compared with the words last sent.
    pub fn watches(&self) -> bool {
        self.trigger == Trigger::Change && !self.changed
    }

    pub fn sent(&self) -> &Words {
        &self.sent
    }

    /// Handles a change of the values.
    pub fn change(&mut self) {
        self.changed = true;
    }

    /// Whether a message must be sent now. `differs` compares the newest values with the words last sent.
    pub fn is_due(&mut self, now: Instant, differs: impl FnOnce(&Words) -> bool) -> bool {
        if self.next.is_reached(now) {
            return true;
        }
        if !self.changed || self.inhibited.is_set() && !self.inhibited.is_reached(now) {
            return false;
        }
        self.changed = false;
        differs(&self.sent)
    }

    /// Handles that these words are sent.
    pub fn produced(&mut self, now: Instant, words: Words) {
        self.sent = words;
        self.changed = false;
        self.inhibited = if self.inhibit > 0 {
            Deadline::after(now, millis(self.inhibit.into()))
        } else {
            Deadline::NEVER
        };
        let period = millis(self.rate.into());
        // A message at its time does not shift the next one, except after a delay of a period. A change restarts the rate.
        match self.next.time() {
            Some(due) if self.rate > 0 && due <= now && after(due, period) > now => {
                self.next = Deadline::at(after(due, period));
            }
            _ => self.restart(now),
        }
    }

    /// The time of the next message.
    pub fn deadline(&self) -> Deadline {
        let mut deadline = self.next;
        if self.changed {
            deadline.consider(self.inhibited);
        }
        deadline
    }
}

/// The acknowledge handler (class 2Bh): repeats a message that is not acknowledged.
#[derive(Clone, Copy, Debug)]
pub(super) struct AcknowledgeHandler {
    /// The wait for an acknowledge in ms.
    timer: u16,
    /// The number of repetitions of a message that is not acknowledged.
    retries: u8,
    left: u8,
    until: Deadline,
}

impl AcknowledgeHandler {
    /// The state before the master sets its attributes.
    pub const INITIAL: Self = Self {
        timer: 0,
        retries: 0,
        left: 0,
        until: Deadline::NEVER,
    };

    /// The default settings; no message waits.
    pub const DEFAULT: Self = Self {
        timer: 16,
        retries: 1,
        ..Self::INITIAL
    };

    /// The wait for an acknowledge in ms.
    pub fn timer(&self) -> u16 {
        self.timer
    }

    /// Sets the wait for an acknowledge in ms.
    pub fn set_timer(&mut self, timer: u16) {
        self.timer = timer;
    }

    pub fn retries(&self) -> u8 {
        self.retries
    }

    /// Sets the number of repetitions.
    pub fn set_retries(&mut self, retries: u8) {
        self.retries = retries;
    }

    /// Handles that a new message is sent.
    pub fn produced(&mut self, now: Instant) {
        self.left = self.retries;
        self.until = Deadline::after(now, millis(self.timer.into()));
    }

    /// Handles an acknowledge, or the end of the connection.
    pub fn stop(&mut self) {
        self.until = Deadline::NEVER;
    }

    /// Returns true if the message must be sent again now.
    pub fn poll(&mut self, now: Instant) -> bool {
        if !self.until.is_reached(now) {
            return false;
        }
        self.until = Deadline::NEVER;
        let repeats = self.left > 0;
        if repeats {
            self.left -= 1;
            self.until = Deadline::after(now, millis(self.timer.into()));
        }
        repeats
    }

    /// The end of the wait.
    pub fn deadline(&self) -> Deadline {
        self.until
    }
}

#[cfg(test)]
mod tests;
