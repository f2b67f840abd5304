//! bxCAN, the CAN controller of the STM32F103 (reference manual RM0008, chapter 24), as software sees it: registers, mailboxes,
//! FIFOs, filters, interrupt lines. What happens on the wire is the business of [`Protocol`].
//!
//! The bus calls [`wire`](BxCan::wire) at every edge and [`step`](BxCan::step) when [`next_event`](BxCan::next_event) is due.
//!
//! Not modelled: loop back, time-triggered communication and access to a register by less than a word. A change of mode that does
//! not wait for the bus takes no time. A reset by CAN_MCR.RESET is as good as one by RCC. From sleep
//! mode straight back into bus-off, with no recovery asked for, the bus is not listened to. A received length code of 9 to 15 reads
//! as 8, which is all that a [`Frame`] has.

mod access;
mod errors;
mod filters;
mod mailbox;
mod mode;
mod receive;
mod registers;
mod timing;
mod transmit;
mod violations;

pub use violations::Violation;

use can_wire::protocol::{Event, Picoseconds, Protocol};
use errors::{Confinement, Status};
use filters::Filters;
use mode::{Change, Control, Mode};
use plumbline::can::Frame;
use plumbline::node::BusState;
use receive::Fifo;
use registers::Register;
use std::collections::VecDeque;
use timing::Timing;
use transmit::{Outcome, Transmitter};
use violations::Violations;

/// PCLK1 after a reset of the microcontroller: the internal oscillator, in Hz.
const RESET_CLOCK: u32 = 8_000_000;

/// Values of CAN_BTR that are remembered: a sensor without traffic tries the bit rates for ever.
const BTR_HISTORY: usize = 1000;

/// Where the recovery from bus-off stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Recovery {
    /// Nobody has asked for it.
    None,
    /// Software has been to initialization mode; it begins when the bus is joined.
    Due,
    /// Recessive bits are counted.
    UnderWay,
}

/// The registers that a reset sets back.
#[derive(Debug, Default)]
struct State {
    control: Control,
    status: Status,
    timing: Timing,
    transmitter: Transmitter,
    fifos: [Fifo; 2],
    filters: Filters,
}

/// The controller.
#[derive(Debug)]
pub struct BxCan {
    state: State,
    protocol: Protocol,
    recovery: Recovery,
    clock: u32,
    dominant: bool,
    sampled_dominant: bool,
    attention: bool,
    overruns: u64,
    btr_history: VecDeque<(Picoseconds, u32)>,
    violations: Violations,
}

impl Default for BxCan {
    fn default() -> Self {
        Self::new()
    }
}

impl BxCan {
    /// A controller after a reset: asleep, off the bus, clocked with 8 MHz.
    pub fn new() -> Self {
        Self {
            state: State::default(),
            protocol: Protocol::default(),
            recovery: Recovery::None,
            clock: RESET_CLOCK,
            dominant: false,
            sampled_dominant: false,
            attention: false,
            overruns: 0,
            btr_history: VecDeque::new(),
            violations: Violations::default(),
        }
    }

    /// Resets the registers and the error counters; a frame under way is torn off. The clock, and what has been observed, stay.
    pub fn reset(&mut self) {
        self.state = State::default();
        self.protocol.leave();
        self.protocol.reset();
        self.recovery = Recovery::None;
        self.attention = true;
    }

    /// Sets the clock, PCLK1, in Hz.
    ///
    /// # Panics
    /// When it is 0.
    pub fn set_clock(&mut self, hz: u32) {
        assert_ne!(
            hz, 0,
            "a controller without clock cannot be accessed, nor does it run"
        );
        if hz != self.clock && self.state.control.is_on() {
            let reason = format!("changed from {} to {hz} Hz while on the bus", self.clock);
            self.violations.record("PCLK1", reason);
        }
        self.clock = hz;
    }

    /// How the controller stands on the wire: the level that it drives, its error counters.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// The frame to be sent next, when one may be started.
    pub fn offered(&self) -> Option<Frame> {
        if !self.may_start() {
            return None;
        }
        self.state.transmitter.offered(self.state.control.order())
    }

    /// When [`step`](Self::step) has to be called; None while nothing happens on the wire.
    pub fn next_event(&self) -> Option<Picoseconds> {
        let offered = self.may_start() && self.state.transmitter.is_pending();
        self.protocol.next_event(offered)
    }

    /// The wire has changed its level.
    pub fn wire(&mut self, now: Picoseconds, dominant: bool) {
        let edge = dominant && !self.dominant;
        self.dominant = dominant;
        if !edge {
            return;
        }
        if self.state.control.is_on() {
            self.protocol.edge(now);
        } else if self.state.control.mode() == Mode::Sleep {
            self.state.status.disturbed_in_sleep();
            self.state.control.wake_up();
            self.attention = true;
            self.settle(now);
        }
    }

    /// Does what is due on the wire, which is at this level.
    pub fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        self.listen_in_bus_off(now, dominant);
        let takes = self.protocol.takes_offer();
        let offered = if takes { self.offered() } else { None };
        self.dominant = dominant;
        self.sampled_dominant = dominant;
        let event = self.protocol.step(now, dominant, offered);
        match event {
            Some(event) => self.event(now, event),
            None => self.settle(now),
        }
        event
    }

    /// Something has happened on the wire. [`step`](Self::step) calls it; a test may play the wire by it.
    pub fn event(&mut self, now: Picoseconds, event: Event) {
        let state = &mut self.state;
        let again = state.control.retransmits();
        match event {
            Event::Joined => state.control.joined(),
            Event::Started => state.transmitter.started(state.control.order()),
            Event::LostArbitration => state.transmitter.ended(Outcome::LostArbitration, again),
            Event::Transmitted => {
                state.status.succeeded();
                state.transmitter.ended(Outcome::Succeeded, again);
            }
            Event::Received(frame) => {
                state.status.succeeded();
                self.store(&frame);
            }
            Event::Error { code, transmitting } => {
                state.status.failed(code);
                if transmitting {
                    state.transmitter.ended(Outcome::Failed, again);
                }
            }
            Event::Recovered => {
                state.control.joined();
                self.recovery = Recovery::None;
            }
        }
        self.attention = true;
        self.settle(now);
    }

    /// The interrupt lines: 19 transmit, 20 receive FIFO 0, 21 receive FIFO 1, 22 status change and error.
    pub fn lines(&self) -> [bool; 4] {
        let [first, second] = &self.state.fifos;
        let fifos = [first.status(), second.status()];
        self.state
            .status
            .lines(self.state.transmitter.is_completed(), fifos)
    }

    /// True once after something that may have changed an interrupt line, the level driven or the time of the next event.
    pub fn take_attention(&mut self) -> bool {
        core::mem::take(&mut self.attention)
    }

    /// The bit rate in bit/s, to the nearest; None while off the bus.
    pub fn bit_rate(&self) -> Option<u32> {
        let on = self.state.control.is_on();
        on.then(|| self.state.timing.bit_rate(self.clock))
    }

    /// True when CAN_BTR says that nothing is to be driven.
    pub fn is_silent(&self) -> bool {
        self.state.timing.is_silent()
    }

    /// The values written to CAN_BTR, with their times, oldest first; the newest thousand.
    pub fn btr_history(&self) -> &VecDeque<(Picoseconds, u32)> {
        &self.btr_history
    }

    /// Messages lost because a FIFO was full.
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// What software did wrong, oldest first; at most 1000.
    pub fn violations(&self) -> &[Violation] {
        &self.violations.all
    }

    fn may_start(&self) -> bool {
        self.state.control.may_start() && !self.state.timing.is_silent()
    }

    /// In bus-off the protocol has a recovery to tell of, but not the 11 recessive bits that end initialization mode.
    fn listen_in_bus_off(&mut self, now: Picoseconds, dominant: bool) {
        let sampled = self.next_event().is_some_and(|due| due <= now);
        if sampled && self.protocol.state() == BusState::BusOff {
            self.state.control.listen(dominant);
        }
    }

    fn store(&mut self, frame: &Frame) {
        let Some(found) = self.state.filters.accept(frame) else {
            return;
        };
        let message = mailbox::words(frame, found.index);
        let locked = self.state.control.locks_fifo();
        if !self.state.fifos[found.fifo].store(message, locked) {
            self.overruns += 1;
        }
    }

    /// Follows the protocol and the requests: changes of mode, recovery, error status.
    fn settle(&mut self, now: Picoseconds) {
        self.violations.now = now;
        match self.state.control.due(self.protocol.is_busy()) {
            Some(Change::Join) => self.join(now),
            Some(Change::Acknowledge(mode)) => self.acknowledge(mode),
            None => {}
        }
        if self.is_recovery_due() {
            self.protocol.recover(now);
            self.recovery = Recovery::UnderWay;
            self.attention = true;
        }
        let before = self.state.status.interrupts();
        self.state
            .status
            .sleeps(self.state.control.mode() == Mode::Sleep);
        self.state.status.follow(Confinement::from(&self.protocol));
        self.attention |= before != self.state.status.interrupts();
    }

    /// Starts to look for 11 recessive bits.
    fn join(&mut self, now: Picoseconds) {
        let state = &mut self.state;
        if let Some(fault) = state.timing.fault(self.clock) {
            self.violations.record(Register::BitTiming.name(), fault);
        }
        if state.timing.is_silent() && state.transmitter.is_pending() {
            let register = Register::TransmitStatus.name();
            self.violations
                .record(register, "a transmission is pending in silent mode");
        }
        state.control.joining();
        let timing = state.timing.bit_timing(self.clock);
        self.protocol.join(now, timing, state.timing.is_silent());
        let in_bus_off = self.protocol.state() == BusState::BusOff;
        if in_bus_off && !self.is_recovery_due() {
            self.state.control.joined();
        }
        self.attention = true;
    }

    /// Leaves the bus and acknowledges a mode.
    fn acknowledge(&mut self, mode: Mode) {
        self.protocol.leave();
        self.state.control.enter(mode);
        let asked = mode == Mode::Initialization || self.recovery == Recovery::Due;
        self.recovery = if asked && self.protocol.state() == BusState::BusOff {
            Recovery::Due
        } else {
            Recovery::None
        };
        self.attention = true;
    }

    /// True when the recovery from bus-off is to begin: on the bus, and asked for or automatic.
    fn is_recovery_due(&self) -> bool {
        let asked = match self.recovery {
            Recovery::None => self.state.control.recovers(),
            Recovery::Due => true,
            Recovery::UnderWay => false,
        };
        asked && self.state.control.is_on() && self.protocol.state() == BusState::BusOff
    }
}

#[cfg(test)]
mod tests;
