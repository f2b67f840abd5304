//! The three transmit mailboxes and CAN_TSR (RM0008, 24.7.1 and 24.9.2).
//!
//! CAN_TSR; mailbox m has the bits from 8 m on.
//!
//! | Bits | Field | Content |
//! |---|---|---|
//! | 0 | RQCP | the request, or its abort, is completed; writing 1 clears it and the next three |
//! | 1, 2, 3 | TXOK, ALST, TERR | result of the last attempt: success, arbitration lost, error |
//! | 7 | ABRQ | abort |
//! | 25..24 | CODE | the next free mailbox; without one, the mailbox with the lowest priority |
//! | 28..26 | TME | mailbox m is empty |
//! | 31..29 | LOW | mailbox m has the lowest priority, when more than one is pending |

use super::mailbox::{self, Words};
use super::registers::{IDENTIFIER, Register};
use super::violations::Violations;
use can_wire::frame_length::arbitration;
use plumbline::can::Frame;

/// TIxR.TXRQ: the mailbox has a transmission request.
const REQUEST: u32 = 1;

const COMPLETED: u32 = 1;
const SUCCEEDED: u32 = 1 << 1;
const LOST_ARBITRATION: u32 = 1 << 2;
const FAILED: u32 = 1 << 3;
const RESULTS: u32 = COMPLETED | SUCCEEDED | LOST_ARBITRATION | FAILED;
const ABORT: u32 = 1 << 7;
/// CAN_TSR.CODE, the number of the next free mailbox.
pub(super) const CODE: u32 = 0b11 << 24;

/// The order in which the mailboxes are sent (CAN_MCR.TXFP).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Order {
    /// By priority in arbitration; with equal identifiers by mailbox number.
    Identifier,
    /// In the order of the requests.
    Request,
}

/// The result of an attempt to send.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Outcome {
    Succeeded,
    LostArbitration,
    Failed,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mailbox {
    /// The registers of the mailbox, without TXRQ.
    words: Words,
    /// TXRQ, with the number of the request.
    pending: Option<u64>,
    /// If pending: the lower value has the higher priority on the wire.
    arbitration: u32,
    /// RQCP, TXOK, ALST and TERR.
    results: u32,
    /// ABRQ: aborted at the end of the current attempt.
    abort: bool,
}

impl Mailbox {
    fn complete(&mut self) {
        self.pending = None;
        self.abort = false;
        self.results |= COMPLETED;
    }
}

#[derive(Debug, Default)]
pub(super) struct Transmitter {
    mailboxes: [Mailbox; 3],
    requests: u64,
    under_way: Option<usize>,
}

impl Transmitter {
    pub(super) fn read(&self, mailbox: usize, word: usize) -> u32 {
        let content = &self.mailboxes[mailbox];
        let request = word == IDENTIFIER && content.pending.is_some();
        content.words[word] | u32::from(request)
    }

    /// Writes a mailbox register; true when that requests a transmission.
    pub(super) fn write(
        &mut self,
        mailbox: usize,
        word: usize,
        value: u32,
        violations: &mut Violations,
    ) -> bool {
        let content = &mut self.mailboxes[mailbox];
        if content.pending.is_some() {
            let register = Register::Transmit { mailbox, word }.name();
            violations.record(register, "the mailbox is not empty");
            return false;
        }
        let requested = word == IDENTIFIER && value & REQUEST != 0;
        content.words[word] = value;
        if requested {
            content.words[word] &= !REQUEST;
            content.pending = Some(self.requests);
            content.arbitration = arbitration(&mailbox::frame(&content.words));
            content.results = 0;
            self.requests += 1;
        }
        requested
    }

    /// The value of CAN_TSR.
    pub(super) fn status(&self, order: Order) -> u32 {
        let mut status = 0;
        for (number, mailbox) in self.mailboxes.iter().enumerate() {
            let abort = if mailbox.abort { ABORT } else { 0 };
            status |= (mailbox.results | abort) << (8 * number);
            status |= u32::from(mailbox.pending.is_none()) << (26 + number);
        }
        let pending = self.pending().count();
        let lowest = self
            .pending()
            .max_by_key(|number| self.priority(*number, order));
        let free = (0..3).find(|number| self.mailboxes[*number].pending.is_none());
        let code = free.or(lowest).unwrap_or(0);
        status |= (code as u32) << 24;
        if let Some(lowest) = lowest.filter(|_| pending > 1) {
            status |= 1 << (29 + lowest);
        }
        status
    }

    /// A write to CAN_TSR: clears results, or aborts mailboxes.
    pub(super) fn write_status(&mut self, value: u32) {
        for (number, mailbox) in self.mailboxes.iter_mut().enumerate() {
            let bits = value >> (8 * number);
            let cleared = if bits & COMPLETED == 0 { bits } else { RESULTS };
            mailbox.results &= !(cleared & RESULTS);
            if bits & ABORT == 0 || mailbox.pending.is_none() {
                continue;
            }
            if self.under_way == Some(number) {
                mailbox.abort = true;
            } else {
                mailbox.complete();
            }
        }
    }

    /// The frame to be sent next.
    pub(super) fn offered(&self, order: Order) -> Option<Frame> {
        let number = self.next(order)?;
        Some(mailbox::frame(&self.mailboxes[number].words))
    }

    /// The frame that is being sent.
    pub(super) fn sent(&self) -> Option<Frame> {
        let number = self.under_way?;
        Some(mailbox::frame(&self.mailboxes[number].words))
    }

    /// The transmission of the next frame has started.
    pub(super) fn started(&mut self, order: Order) {
        self.under_way = self.next(order);
    }

    /// The current attempt has ended. Without `again` (CAN_MCR.NART) there is no other attempt.
    pub(super) fn ended(&mut self, outcome: Outcome, again: bool) {
        let Some(number) = self.under_way.take() else {
            return;
        };
        let mailbox = &mut self.mailboxes[number];
        mailbox.results = match outcome {
            Outcome::Succeeded => SUCCEEDED,
            Outcome::LostArbitration => LOST_ARBITRATION,
            Outcome::Failed => FAILED,
        };
        if outcome == Outcome::Succeeded || mailbox.abort || !again {
            mailbox.complete();
        }
    }

    /// True when a frame is pending or being sent.
    pub(super) fn is_pending(&self) -> bool {
        self.pending().next().is_some()
    }

    /// True when a request is completed: the source of the transmit interrupt.
    pub(super) fn is_completed(&self) -> bool {
        self.mailboxes
            .iter()
            .any(|mailbox| mailbox.results & COMPLETED != 0)
    }

    fn next(&self, order: Order) -> Option<usize> {
        self.pending()
            .min_by_key(|number| self.priority(*number, order))
    }

    fn pending(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|number| self.mailboxes[*number].pending.is_some())
    }

    /// The lower value is sent first; the values of two mailboxes are never equal.
    fn priority(&self, number: usize, order: Order) -> (u64, usize) {
        let mailbox = &self.mailboxes[number];
        let key = match order {
            Order::Identifier => mailbox.arbitration.into(),
            Order::Request => mailbox.pending.unwrap_or(u64::MAX),
        };
        (key, number)
    }
}

#[cfg(test)]
mod tests;
