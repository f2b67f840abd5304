//! The CAN controller of a device: the protocol, transmit mailboxes, a receive FIFO and acceptance filters.

use crate::registers::Registers;
use can_wire::protocol::{BitTiming, ErrorCode, Event, Period, Picoseconds, Protocol};
use plumbline::can::{BitRate, Filter, Frame};
use plumbline::node::driver::{Controller as _, Phase};
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
    protocol: Protocol,
    registers: Registers,
    setting: Option<(BusMode, BitRate)>,
    /// The new setting takes effect at the end of the frame that is being sent.
    changing: bool,
    /// The driver does not know yet that the controller has joined the bus with the new setting.
    joins: bool,
    filters: Vec<Filter>,
    fifo: VecDeque<Frame>,
    /// A mailbox has become free.
    free: Option<bool>,
    events: VecDeque<BusEvent>,
    /// The state last reported to the node.
    state: BusState,
}

impl Controller {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            protocol: Protocol::default(),
            registers: Registers::new(now),
            setting: None,
            changing: false,
            joins: false,
            filters: Vec::new(),
            fifo: VecDeque::new(),
            free: None,
            events: VecDeque::new(),
            state: BusState::Active,
        }
    }

    pub(super) fn registers(&self) -> &Registers {
        &self.registers
    }

    /// The state machine of the protocol.
    pub(super) fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Changes the mode and the bit rate. The frames in the mailboxes are dropped, a frame that is being sent is completed. Earlier
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
        self.joins = true;
        self.filters = filters;
        self.registers.clear();
        self.registers.resume();
        self.fifo.clear();
        self.free = None;
        self.events.retain(|event| *event != BusEvent::Error);
        self.change(now);
        self.update();
    }

    /// Changes the filters. The frames in the mailboxes are dropped, a frame that is being sent is completed.
    pub(super) fn refilter(&mut self, filters: Vec<Filter>) {
        self.filters = filters;
        self.registers.abort();
        self.registers.resume();
    }

    /// Starts the recovery from bus-off.
    pub(super) fn recover(&mut self, now: Picoseconds) {
        self.protocol.recover(now);
        self.update();
    }

    /// Returns true once when the controller takes part in the bus after a change.
    pub(super) fn has_joined(&mut self) -> bool {
        let joined = self.joins && self.registers.phase().receives();
        self.joins &= !joined;
        joined
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

    /// Updates the registers that the driver reads.
    fn update(&self) {
        let is_off = self.protocol.state() == BusState::BusOff;
        let (phase, rate) = match self.setting {
            _ if self.changing => (Phase::Off, None),
            None => (Phase::Off, None),
            Some(_) if self.protocol.is_joining() => (Phase::Waiting, None),
            Some((BusMode::Listen, _)) => (Phase::Listening, None),
            Some((BusMode::Normal, rate)) => (Phase::Normal, Some(rate).filter(|_| !is_off)),
        };
        let is_transmitting = self.protocol.is_transmitting();
        self.registers.set_state(phase, rate, is_transmitting);
    }

    pub(super) fn mode(&self) -> Option<BusMode> {
        self.setting.map(|(mode, _)| mode)
    }

    pub(super) fn rate(&self) -> Option<BitRate> {
        self.setting.map(|(_, rate)| rate)
    }

    /// The frame that waits to be sent.
    pub(super) fn offered(&self) -> Option<Frame> {
        self.registers.first().filter(|_| !self.changing)
    }

    /// Reports a recessive to dominant edge of the wire.
    pub(super) fn edge(&mut self, now: Picoseconds) {
        self.protocol.edge(now);
    }

    /// Skips a number of equal periods of the wire.
    pub(super) fn skip(&mut self, period: Period, count: u64) {
        self.protocol.skip(period, count);
        self.update();
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
        self.update();
        Some(event)
    }

    fn note(&mut self, now: Picoseconds, event: Event, stalled: bool) {
        match event {
            _ if self.changing => self.change(now),
            Event::Received(frame) => self.receive(frame, stalled),
            Event::Transmitted => {
                self.registers.sent();
                self.free = Some(false);
            }
            Event::Error { code, transmitting } => {
                self.events.push_back(BusEvent::Error);
                // Without acknowledge it is sent again at once.
                if transmitting && code != ErrorCode::Acknowledgment && self.registers.failed() {
                    self.free = Some(true);
                }
            }
            Event::Joined | Event::Started | Event::LostArbitration | Event::Recovered => {}
        }
        if !self.protocol.is_transmitting() && self.registers.drop_aborted() {
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
            self.registers.clone().lose();
            self.fifo.pop_back();
        }
        self.fifo.push_back(frame);
    }

    /// Reports an event of another part of the controller.
    pub(super) fn report(&mut self, event: BusEvent) {
        self.events.push_back(event);
    }

    /// The next event for the node.
    pub(super) fn take_event(&mut self) -> Option<BusEvent> {
        if self.registers.take_lost() {
            return Some(BusEvent::Overrun);
        }
        self.events.pop_front()
    }

    pub(super) fn take_interrupt(&mut self) -> Option<Interrupt> {
        if let Some(frame) = self.fifo.pop_front() {
            return Some(Interrupt::Received(frame));
        }
        self.free.take().map(Interrupt::Free)
    }
}
