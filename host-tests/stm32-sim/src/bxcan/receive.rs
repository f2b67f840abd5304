//! A receive FIFO of three mailboxes and its CAN_RFxR (RM0008, 24.7.3 and 24.9.2).
//!
//! | Bits | Field | Content |
//! |---|---|---|
//! | 1..0 | FMP | messages pending |
//! | 3 | FULL | three messages were stored; cleared by writing 1 |
//! | 4 | FOVR | a message was lost; cleared by writing 1 |
//! | 5 | RFOM | writing 1 releases the output mailbox; 1 until it is released |

use super::mailbox::Words;
use super::violations::Violations;
use can_wire::protocol::Picoseconds;
use std::collections::VecDeque;

/// Messages that a FIFO holds.
const DEPTH: usize = 3;

/// CAN_RFxR.FULL.
pub(super) const FULL: u32 = 1 << 3;
/// CAN_RFxR.FOVR.
pub(super) const OVERRUN: u32 = 1 << 4;
/// CAN_RFxR.FMP.
pub(super) const PENDING: u32 = 3;
const RELEASE: u32 = 1 << 5;

#[derive(Debug, Default)]
pub(super) struct Fifo {
    messages: VecDeque<Words>,
    /// The bits FULL and FOVR, which the program clears.
    flags: u32,
    /// The content of the output mailbox when the FIFO is empty: the last released message.
    stale: Words,
    /// RFOM is set until then.
    releasing: Option<Picoseconds>,
}

impl Fifo {
    /// Releases the output mailbox if it is time.
    pub(super) fn settle(&mut self, now: Picoseconds) {
        if self.releasing.is_some_and(|end| end <= now) {
            self.releasing = None;
            self.stale = self.messages.pop_front().unwrap_or(self.stale);
        }
    }

    /// The time at which [`settle`](Self::settle) changes something.
    pub(super) fn next_event(&self) -> Option<Picoseconds> {
        self.releasing
    }

    /// CAN_MCR.RESET: no message is pending.
    pub(super) fn discard(&mut self) {
        self.messages.clear();
        self.releasing = None;
    }

    /// Stores a message; false when a message is lost: the new one if `locked` (CAN_MCR.RFLM), otherwise the last stored one.
    pub(super) fn store(&mut self, message: Words, locked: bool) -> bool {
        if self.messages.len() < DEPTH {
            self.messages.push_back(message);
            if self.messages.len() == DEPTH {
                self.flags |= FULL;
            }
            return true;
        }
        self.flags |= OVERRUN;
        if !locked {
            self.messages[DEPTH - 1] = message;
        }
        false
    }

    /// A word of the output mailbox.
    pub(super) fn read(
        &self,
        word: usize,
        register: &'static str,
        violations: &mut Violations,
    ) -> u32 {
        if self.releasing.is_some() {
            violations.record(register, "read while the mailbox is released");
        }
        let message = self.messages.front().unwrap_or_else(|| {
            violations.record(register, "read while the FIFO is empty");
            &self.stale
        });
        message[word]
    }

    /// The value of CAN_RFxR.
    pub(super) fn status(&self) -> u32 {
        let releasing = if self.releasing.is_some() { RELEASE } else { 0 };
        self.flags | releasing | self.messages.len() as u32
    }

    /// Writes CAN_RFxR. A release ends at `released`.
    pub(super) fn write_status(
        &mut self,
        value: u32,
        released: Picoseconds,
        register: &'static str,
        violations: &mut Violations,
    ) {
        self.flags &= !value;
        if value & RELEASE == 0 {
            return;
        }
        if self.messages.is_empty() {
            violations.record(register, "released while the FIFO is empty");
        } else if self.releasing.is_none() {
            self.releasing = Some(released);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOCKED: bool = true;
    const NOT_LOCKED: bool = false;

    fn message(number: u32) -> Words {
        [number, 0, 0, 0]
    }

    fn filled(count: u32, locked: bool) -> Fifo {
        let mut fifo = Fifo::default();
        for number in 1..=count {
            assert_eq!(fifo.store(message(number), locked), number <= 3);
        }
        fifo
    }

    /// Removes all messages, oldest first.
    fn drained(fifo: &mut Fifo) -> Vec<u32> {
        let mut violations = Violations::default();
        let mut taken = Vec::new();
        while fifo.status() & PENDING != 0 {
            taken.push(fifo.read(0, "CAN_RI0R", &mut violations));
            fifo.write_status(RELEASE, 0, "CAN_RF0R", &mut violations);
            fifo.settle(0);
        }
        assert_eq!(violations.all, []);
        taken
    }

    #[test]
    fn messages_are_counted_and_read_in_order() {
        assert_eq!(filled(0, NOT_LOCKED).status(), 0);
        assert_eq!(filled(1, NOT_LOCKED).status(), 0b01);
        assert_eq!(filled(2, NOT_LOCKED).status(), 0b10);
        assert_eq!(filled(3, NOT_LOCKED).status(), 0b11 | FULL);
        assert_eq!(drained(&mut filled(3, NOT_LOCKED)), [1, 2, 3]);
    }

    #[test]
    fn unlocked_fifo_overwrites_last_message() {
        let mut fifo = filled(5, NOT_LOCKED);
        assert_eq!(fifo.status(), 0b11 | FULL | OVERRUN);
        assert_eq!(drained(&mut fifo), [1, 2, 5]);
    }

    #[test]
    fn locked_fifo_discards_new_message() {
        let mut fifo = filled(5, LOCKED);
        assert_eq!(fifo.status(), 0b11 | FULL | OVERRUN);
        assert_eq!(drained(&mut fifo), [1, 2, 3]);
    }

    #[test]
    fn released_mailbox_can_store_next_message() {
        let mut fifo = filled(3, LOCKED);
        fifo.write_status(RELEASE, 0, "CAN_RF0R", &mut Violations::default());
        fifo.settle(0);
        assert!(fifo.store(message(4), LOCKED));
        assert_eq!(fifo.status() & OVERRUN, 0);
        assert_eq!(drained(&mut fifo), [2, 3, 4]);
    }

    #[test]
    fn software_clears_full_and_overrun_separately() {
        let mut violations = Violations::default();
        let mut fifo = filled(4, LOCKED);
        drained(&mut fifo);
        assert_eq!(fifo.status(), FULL | OVERRUN);
        fifo.write_status(OVERRUN, 0, "CAN_RF0R", &mut violations);
        assert_eq!(fifo.status(), FULL);
        fifo.write_status(FULL, 0, "CAN_RF0R", &mut violations);
        assert_eq!(fifo.status(), 0);
    }

    #[test]
    fn read_or_release_of_empty_fifo_is_violation() {
        let mut violations = Violations::default();
        let mut fifo = filled(1, LOCKED);
        drained(&mut fifo);
        // The mailbox still shows its last message.
        assert_eq!(fifo.read(0, "CAN_RI1R", &mut violations), 1);
        fifo.write_status(RELEASE, 0, "CAN_RF1R", &mut violations);
        fifo.settle(0);
        assert_eq!(fifo.status(), 0);
        let registers: Vec<_> = violations.all.iter().map(|v| v.register).collect();
        assert_eq!(registers, ["CAN_RI1R", "CAN_RF1R"]);
    }

    #[test]
    fn release_takes_its_time_in_which_mailbox_must_not_be_read() {
        let mut violations = Violations::default();
        let mut fifo = filled(2, LOCKED);
        fifo.write_status(RELEASE, 100, "CAN_RF0R", &mut violations);
        fifo.settle(99);
        assert_eq!(fifo.status(), RELEASE | 2);
        assert_eq!(fifo.next_event(), Some(100));
        // A second request has no effect.
        fifo.write_status(RELEASE, 200, "CAN_RF0R", &mut violations);
        assert_eq!(violations.all, []);
        fifo.read(0, "CAN_RI0R", &mut violations);
        assert_eq!(violations.all.len(), 1);
        fifo.settle(100);
        assert_eq!(fifo.status(), 1);
        assert_eq!(drained(&mut fifo), [2]);
    }
}
