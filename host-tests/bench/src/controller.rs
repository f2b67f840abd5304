//! A device's CAN controller: the protocol with one transmit mailbox, a receive queue and acceptance filters around it.

use can_wire::protocol::{BitTiming, ErrorCode, Event, Picoseconds, Protocol};
use plumbline::can::{BitRate, Filter, Frame};
use plumbline::node::{BusEvent, BusMode, BusState};
use std::collections::VecDeque;

/// Received frames that the queue of the firmware holds.
const QUEUE: usize = 32;

/// Received frames that the FIFO of the controller holds while the processor is stalled.
const FIFO: usize = 3;

/// A CAN controller after a hardware reset.
#[derive(Debug)]
pub(super) struct Controller {
    pub(super) protocol: Protocol,
    setting: Option<(BusMode, BitRate)>,
    /// The new setting takes effect at the end of the frame that is being sent.
    changing: bool,
    filters: Vec<Filter>,
    mailbox: Option<Frame>,
    /// The frame in the mailbox is not repeated after a bit error.
    once: bool,
    /// Such a frame was not sent.
    unsent: bool,
    /// The frame in the mailbox is being sent, and dropped if it fails.
    aborted: bool,
    received: VecDeque<Frame>,
    in_fifo: usize,
    events: VecDeque<BusEvent>,
    /// The state last reported to the node.
    state: BusState,
}

impl Controller {
    pub(super) fn new() -> Self {
        Self {
            protocol: Protocol::default(),
            setting: None,
            changing: false,
            filters: Vec::new(),
            mailbox: None,
            once: false,
            unsent: false,
            aborted: false,
            received: VecDeque::new(),
            in_fifo: 0,
            events: VecDeque::new(),
            state: BusState::Active,
        }
    }

    /// Changes the mode and the bit rate. A frame in the mailbox is dropped, a frame that is being sent is completed. Earlier
    /// frames and errors are dropped, the error counters stay.
    pub(super) fn configure(
        &mut self,
        now: Picoseconds,
        mode: BusMode,
        rate: BitRate,
        filters: Vec<Filter>,
    ) {
        self.setting = Some((mode, rate));
        self.changing = true;
        self.filters = filters;
        self.mailbox = None;
        self.aborted = false;
        self.received.clear();
        self.in_fifo = 0;
        self.events.retain(|event| *event != BusEvent::Error);
        self.change(now);
    }

    /// Changes the filters. A frame in the mailbox is dropped, a frame that is being sent is completed.
    pub(super) fn refilter(&mut self, filters: Vec<Filter>) {
        self.filters = filters;
        self.aborted = self.protocol.is_transmitting();
        if !self.aborted {
            self.mailbox = None;
        }
    }

    /// Whether the controller is on the bus with this mode and bit rate, and not in bus-off.
    pub(super) fn is_at(&self, mode: BusMode, rate: BitRate) -> bool {
        let is_off = self.protocol.state() == BusState::BusOff;
        self.setting == Some((mode, rate)) && !self.changing && !is_off
    }

    fn change(&mut self, now: Picoseconds) {
        if let Some((mode, rate)) = self.setting
            && self.changing
            && !self.protocol.is_transmitting()
        {
            self.changing = false;
            let silent = mode == BusMode::Listen;
            self.protocol.join(now, BitTiming::of(rate), silent);
        }
    }

    pub(super) fn mode(&self) -> Option<BusMode> {
        self.setting.map(|(mode, _)| mode)
    }

    pub(super) fn rate(&self) -> Option<BitRate> {
        self.setting.map(|(_, rate)| rate)
    }

    /// True when the mailbox can take a frame.
    pub(super) fn mailbox_free(&self) -> bool {
        self.mode() == Some(BusMode::Normal) && self.mailbox.is_none()
    }

    /// True when no frame waits to be sent.
    pub(super) fn mailbox_empty(&self) -> bool {
        self.mailbox.is_none()
    }

    pub(super) fn load(&mut self, frame: Frame, once: bool) {
        self.mailbox = Some(frame);
        self.once = once;
    }

    /// Returns true once if a frame that is not repeated was not sent.
    pub(super) fn take_unsent(&mut self) -> bool {
        std::mem::take(&mut self.unsent)
    }

    /// The frame that waits to be sent.
    pub(super) fn offered(&self) -> Option<Frame> {
        self.mailbox.filter(|_| !self.changing)
    }

    /// Handles an event of the protocol; while the processor is stalled, only the FIFO of the controller takes a frame.
    pub(super) fn note(&mut self, now: Picoseconds, event: Event, stalled: bool) {
        match event {
            _ if self.changing => self.change(now),
            Event::Received(frame) => self.receive(frame, stalled),
            Event::Transmitted => self.mailbox = None,
            Event::Error { code, transmitting } => {
                self.events.push_back(BusEvent::Error);
                // Without acknowledge it is sent again at once.
                if transmitting && self.once && code != ErrorCode::Acknowledgment {
                    self.unsent = self.mailbox.take().is_some();
                }
            }
            Event::Joined | Event::Started | Event::LostArbitration | Event::Recovered => {}
        }
        if self.aborted && !self.protocol.is_transmitting() {
            self.aborted = false;
            self.mailbox = None;
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
        if self.received.len() >= QUEUE {
            self.events.push_back(BusEvent::Overrun);
            return;
        }
        if stalled && self.in_fifo >= FIFO {
            // As on the boards, the newest frame takes the place of the last one.
            self.events.push_back(BusEvent::Overrun);
            self.received.pop_back();
        } else {
            self.in_fifo += usize::from(stalled);
        }
        self.received.push_back(frame);
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
}
