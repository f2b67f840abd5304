//! A device's CAN controller: one transmit mailbox, a receive queue, acceptance filters and fault confinement.
//!
//! Fault confinement follows the main rules of ISO 11898-1: an error while transmitting counts 8, one while receiving 1, a
//! success takes 1 off. From 96 the state is Warning, from 128 Passive, above 255 while transmitting Bus-Off. A transmitter that
//! is Passive does not count a missing acknowledge. The rules for who saw the error first are left out.

use plumbline::can::{BitRate, Filters, Frame};
use plumbline::node::{BusEvent, BusMode, BusState};
use plumbline::time::{Duration, Instant, after};
use std::collections::VecDeque;

/// Received frames that the firmware's queue holds.
const QUEUE: usize = 32;

/// Received frames that the controller itself holds while the processor stands still.
const FIFO: usize = 3;

/// How a controller stands to a frame on the wire.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Hearing {
    /// Takes part: acknowledges, signals errors.
    Full,
    /// Listens only, at the frame's bit rate.
    Listens,
    /// Listens only, at another bit rate: the frame is a bus error.
    Garbled,
    /// Is off the bus, or set to another bit rate, or joined in the middle of the frame.
    Deaf,
}

/// Why a transmission failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Failure {
    /// The frame was disturbed.
    Corrupted,
    /// Nobody acknowledged it.
    NotAcknowledged,
}

/// A CAN controller after a hardware reset.
#[derive(Debug)]
pub(super) struct Controller {
    setting: Option<(BusMode, BitRate)>,
    since: Instant,
    filters: Filters,
    mailbox: Option<Frame>,
    sending: bool,
    received: VecDeque<Frame>,
    in_fifo: usize,
    events: VecDeque<BusEvent>,
    transmit_errors: u16,
    receive_errors: u16,
    state: BusState,
    recovered_at: Option<Instant>,
}

impl Controller {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            setting: None,
            since: now,
            filters: Filters::new(),
            mailbox: None,
            sending: false,
            received: VecDeque::new(),
            in_fifo: 0,
            events: VecDeque::new(),
            transmit_errors: 0,
            receive_errors: 0,
            state: BusState::Active,
            recovered_at: None,
        }
    }

    /// Goes to a mode and a bit rate; what waits in the mailbox is dropped, a frame on the wire comes to its end. The error
    /// counters stay.
    pub(super) fn configure(
        &mut self,
        now: Instant,
        mode: BusMode,
        rate: BitRate,
        filters: Filters,
    ) {
        self.setting = Some((mode, rate));
        self.since = now;
        self.filters = filters;
        self.mailbox = None;
        self.sending = false;
        self.received.clear();
        self.in_fifo = 0;
    }

    pub(super) fn mode(&self) -> Option<BusMode> {
        self.setting.map(|(mode, _)| mode)
    }

    pub(super) fn rate(&self) -> Option<BitRate> {
        self.setting.map(|(_, rate)| rate)
    }

    pub(super) fn state(&self) -> BusState {
        self.state
    }

    /// The transmit and the receive error counter.
    pub(super) fn error_counters(&self) -> (u16, u16) {
        (self.transmit_errors, self.receive_errors)
    }

    /// How the controller stands to a frame that started at `start` at `rate`.
    pub(super) fn hearing(&self, rate: BitRate, start: Instant) -> Hearing {
        match self.setting {
            Some((mode, own)) if self.since <= start && self.state != BusState::BusOff => {
                match mode {
                    BusMode::Normal if own == rate => Hearing::Full,
                    BusMode::Listen if own == rate => Hearing::Listens,
                    BusMode::Listen => Hearing::Garbled,
                    BusMode::Normal => Hearing::Deaf,
                }
            }
            _ => Hearing::Deaf,
        }
    }

    /// True when a frame can be put into the mailbox.
    pub(super) fn mailbox_free(&self) -> bool {
        self.mode() == Some(BusMode::Normal) && self.mailbox.is_none()
    }

    /// True when nothing waits to be sent.
    pub(super) fn mailbox_empty(&self) -> bool {
        self.mailbox.is_none()
    }

    pub(super) fn load(&mut self, frame: Frame) {
        self.mailbox = Some(frame);
    }

    /// The frame that waits to be sent at `rate`.
    pub(super) fn pending(&self, rate: BitRate) -> Option<Frame> {
        let can = self.setting == Some((BusMode::Normal, rate)) && self.state != BusState::BusOff;
        self.mailbox.filter(|_| can)
    }

    /// The frame in the mailbox has won arbitration.
    pub(super) fn start(&mut self) {
        self.sending = true;
    }

    pub(super) fn transmitted(&mut self) {
        if core::mem::take(&mut self.sending) {
            self.mailbox = None;
        }
        self.transmit_errors = self.transmit_errors.saturating_sub(1);
        self.judge();
    }

    pub(super) fn not_transmitted(&mut self, failure: Failure) {
        self.sending = false;
        self.events.push_back(BusEvent::Error);
        if failure == Failure::Corrupted || self.state != BusState::Passive {
            self.transmit_errors += 8;
        }
        self.judge();
    }

    /// A good frame has come; with the processor standing still only the controller's own FIFO takes it.
    pub(super) fn received(&mut self, hearing: Hearing, frame: &Frame, stalled: bool) {
        let accepted = match hearing {
            Hearing::Full => {
                // Above 127 the next success brings the counter back to just below the passive limit.
                self.receive_errors = self.receive_errors.min(121).saturating_sub(1);
                self.judge();
                self.filters.iter().any(|filter| filter.accepts(frame.id()))
            }
            Hearing::Listens => true,
            Hearing::Garbled => return self.disturbed(hearing),
            Hearing::Deaf => false,
        };
        if !accepted {
            return;
        }
        if self.received.len() >= QUEUE || (stalled && self.in_fifo >= FIFO) {
            self.events.push_back(BusEvent::Overrun);
            return;
        }
        self.in_fifo += usize::from(stalled);
        self.received.push_back(*frame);
    }

    /// A bus error was seen.
    pub(super) fn disturbed(&mut self, hearing: Hearing) {
        if hearing == Hearing::Deaf {
            return;
        }
        self.events.push_back(BusEvent::Error);
        if hearing == Hearing::Full {
            self.receive_errors = self.receive_errors.saturating_add(1).min(255);
            self.judge();
        }
    }

    /// The processor runs again and empties the FIFO.
    pub(super) fn drain_fifo(&mut self) {
        self.in_fifo = 0;
    }

    pub(super) fn take_event(&mut self) -> Option<BusEvent> {
        self.events.pop_front()
    }

    pub(super) fn take_received(&mut self) -> Option<Frame> {
        self.received.pop_front()
    }

    /// Starts to leave bus-off: 128 times 11 recessive bits, as on a quiet bus.
    pub(super) fn recover(&mut self, now: Instant) {
        if let (BusState::BusOff, None, Some(rate)) = (self.state, self.recovered_at, self.rate()) {
            let bits = 128 * 11 * 1_000_000;
            let time = u64::div_ceil(bits, rate.bits_per_second().into());
            self.recovered_at = Some(after(now, Duration::from_ticks(time)));
        }
    }

    /// When the recovery from bus-off ends.
    pub(super) fn recovered_at(&self) -> Option<Instant> {
        self.recovered_at
    }

    /// Comes back from bus-off when the time is there, joining the bus at that moment.
    pub(super) fn tick(&mut self, now: Instant) {
        if self.recovered_at.is_some_and(|at| at <= now) {
            self.recovered_at = None;
            self.since = now;
            self.transmit_errors = 0;
            self.receive_errors = 0;
            self.state = BusState::Active;
            self.events.push_back(BusEvent::State(self.state));
        }
    }

    /// Derives the fault confinement state from the counters.
    fn judge(&mut self) {
        let state = match (self.transmit_errors, self.receive_errors) {
            _ if self.state == BusState::BusOff => BusState::BusOff,
            (256.., _) => BusState::BusOff,
            (128.., _) | (_, 128..) => BusState::Passive,
            (96.., _) | (_, 96..) => BusState::Warning,
            _ => BusState::Active,
        };
        if state != self.state {
            self.state = state;
            self.events.push_back(BusEvent::State(state));
        }
    }
}
