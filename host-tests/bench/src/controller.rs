//! The CAN controller of a device: the protocol, transmit mailboxes, a receive FIFO and acceptance filters.

use crate::bus::picoseconds;
use crate::mailboxes::Mailboxes;
use can_wire::protocol::{BitTiming, ErrorCode, Event, Period, Picoseconds, Protocol};
use plumbline::can::{BitRate, Filter, Frame};
use plumbline::node::driver::{self, Change, Filters};
use plumbline::node::{BusEvent, BusMode, BusState};
use plumbline::time::Instant;
use std::collections::VecDeque;

/// Received frames that the FIFO of the controller holds while the processor is stalled.
const FIFO: usize = 3;

/// An interrupt, which calls the driver of the node.
#[derive(Clone, Copy, Debug)]
pub(super) enum Interrupt {
    Received(Frame),
    /// A mailbox has become free; true: its frame ended in a bit error and is not repeated.
    Free(bool),
}

/// A CAN controller after a hardware reset.
#[derive(Debug)]
pub(super) struct Controller {
    /// The time that the driver reads.
    now: Instant,
    protocol: Protocol,
    mailboxes: Mailboxes,
    setting: Option<(BusMode, BitRate)>,
    /// The new setting takes effect at the end of the frame that is being sent.
    changing: bool,
    filters: Vec<Filter>,
    fifo: VecDeque<Frame>,
    /// The FIFO has lost a received frame.
    lost: bool,
    /// A mailbox has become free.
    free: Option<bool>,
    events: VecDeque<BusEvent>,
    /// The state last reported to the node.
    state: BusState,
}

impl Controller {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            now,
            protocol: Protocol::default(),
            mailboxes: Mailboxes::default(),
            setting: None,
            changing: false,
            filters: Vec::new(),
            fifo: VecDeque::new(),
            lost: false,
            free: None,
            events: VecDeque::new(),
            state: BusState::Active,
        }
    }

    /// Sets the time that the driver reads.
    pub(super) fn set_time(&mut self, now: Instant) {
        self.now = now;
    }

    /// The state machine of the protocol.
    pub(super) fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Changes the setting if no frame is being sent.
    fn join(&mut self, now: Picoseconds) {
        if let Some((mode, rate)) = self.setting
            && self.changing
            && !self.protocol.is_transmitting()
        {
            self.changing = false;
            let silent = mode == BusMode::Listen;
            self.protocol.join(now, BitTiming::of(rate), silent);
        }
    }

    /// Changes to this mode. The frames in the mailboxes are dropped, a frame that is being sent is completed. Earlier frames and errors are
    /// dropped, the error counters stay.
    pub(super) fn begin(&mut self, mode: BusMode, rate: BitRate, filters: Vec<Filter>) {
        self.setting = Some((mode, rate));
        self.changing = true;
        self.filters = filters;
        self.mailboxes.clear();
        self.fifo.clear();
        self.free = None;
        self.events.retain(|event| *event != BusEvent::Error);
        self.join(picoseconds(self.now));
    }

    pub(super) fn mode(&self) -> Option<BusMode> {
        self.setting.map(|(mode, _)| mode)
    }

    pub(super) fn rate(&self) -> Option<BitRate> {
        self.setting.map(|(_, rate)| rate)
    }

    /// The frame that waits to be sent.
    pub(super) fn offered(&self) -> Option<Frame> {
        self.mailboxes.first().filter(|_| !self.changing)
    }

    /// Reports a recessive to dominant edge of the wire.
    pub(super) fn edge(&mut self, now: Picoseconds) {
        self.protocol.edge(now);
    }

    /// Skips a number of equal periods of the wire.
    pub(super) fn skip(&mut self, period: Period, count: u64) {
        self.protocol.skip(period, count);
    }

    /// Performs the step of the protocol that is due. While the processor is stalled, only the FIFO takes a frame.
    pub(super) fn step(
        &mut self,
        now: Picoseconds,
        dominant: bool,
        stalled: bool,
    ) -> Option<Event> {
        let offered = self.offered();
        let event = self.protocol.step(now, dominant, offered)?;
        self.note(now, event, stalled);
        Some(event)
    }

    fn note(&mut self, now: Picoseconds, event: Event, stalled: bool) {
        match event {
            _ if self.changing => self.join(now),
            Event::Received(frame) => self.receive(frame, stalled),
            Event::Transmitted => {
                self.mailboxes.sent();
                self.free = Some(false);
            }
            Event::Error { code, transmitting } => {
                self.events.push_back(BusEvent::Error);
                // Without acknowledge it is sent again at once.
                if transmitting && code != ErrorCode::Acknowledgment && self.mailboxes.failed() {
                    self.free = Some(true);
                }
            }
            Event::Joined | Event::Started | Event::LostArbitration | Event::Recovered => {}
        }
        if !self.protocol.is_transmitting() && self.mailboxes.drop_aborted() {
            self.free = Some(false);
        }
        let state = self.protocol.state();
        if state != self.state {
            self.state = state;
            self.events.push_back(BusEvent::State(state));
        }
    }

    fn receive(&mut self, frame: Frame, stalled: bool) {
        let listens = self.mode() == Some(BusMode::Listen);
        if !listens && !self.filters.iter().any(|one| one.accepts(frame.id())) {
            return;
        }
        if stalled && self.fifo.len() >= FIFO {
            // As on the boards, the newest frame takes the place of the last one.
            self.lost = true;
            self.fifo.pop_back();
        }
        self.fifo.push_back(frame);
    }

    /// Reports an event of another part of the controller.
    pub(super) fn report(&mut self, event: BusEvent) {
        self.events.push_back(event);
    }

    pub(super) fn take_interrupt(&mut self) -> Option<Interrupt> {
        if let Some(frame) = self.fifo.pop_front() {
            return Some(Interrupt::Received(frame));
        }
        self.free.take().map(Interrupt::Free)
    }
}

impl driver::Mailboxes for Controller {
    fn now(&self) -> Instant {
        self.now
    }

    fn is_idle(&self) -> bool {
        self.mailboxes.is_empty()
    }

    fn has_room(&self) -> bool {
        self.mailboxes.has_room()
    }

    fn put(&mut self, frame: &Frame, once: bool) {
        self.mailboxes.put(frame, once);
    }

    fn abort(&mut self) {
        let is_transmitting = self.protocol.is_transmitting();
        self.mailboxes.abort(is_transmitting);
    }
}

fn list(filters: Filters<'_>) -> Vec<Filter> {
    let mut list = Vec::new();
    filters.for_each(|filter| list.push(filter));
    list
}

impl driver::Controller for Controller {
    fn open(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>) {
        self.begin(mode, rate, list(filters));
    }

    fn change(&mut self) -> Change {
        if self.changing {
            Change::Leaving
        } else if self.protocol.is_joining() && self.setting.is_some() {
            Change::Joining
        } else {
            Change::Done
        }
    }

    fn refilter(&mut self, filters: Filters<'_>) -> bool {
        self.filters = list(filters);
        true
    }

    fn recover(&mut self) {
        self.protocol.recover(picoseconds(self.now));
    }

    fn event(&mut self) -> Option<BusEvent> {
        if core::mem::take(&mut self.lost) {
            return Some(BusEvent::Overrun);
        }
        self.events.pop_front()
    }
}
