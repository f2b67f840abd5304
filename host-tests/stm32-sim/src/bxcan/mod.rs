//! bxCAN, the CAN controller of the STM32F103 (reference manual RM0008, chapter 24), from the view of software: registers,
//! mailboxes, FIFOs, filters, interrupt lines. [`Protocol`] simulates the wire side.
//!
//! The bus calls [`wire`](BxCan::wire) at every edge and [`step`](BxCan::step) when [`next_event`](BxCan::next_event) is due.
//!
//! Not modelled: loop back, time-triggered communication and accesses narrower than a word. A change of mode that does not wait
//! for the bus takes no time. A reset by CAN_MCR.RESET has the effect of a reset by RCC. In a direct change from sleep mode to
//! bus-off without a requested recovery, the controller does not listen to the bus. A received DLC of 9 to 15 reads as 8, because
//! a [`Frame`] stores no more.

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

/// Values of CAN_BTR that are kept: without traffic a sensor tries the bit rates without end.
const BTR_HISTORY: usize = 1000;

/// The state of the recovery from bus-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Recovery {
    /// Not requested.
    None,
    /// Software has entered initialization mode; the recovery begins when the controller joins the bus.
    Due,
    /// Recessive bits are counted.
    UnderWay,
}

/// The registers that a reset clears.
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
    changed: bool,
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
    /// A controller after a reset: in sleep mode, off the bus, with a clock of 8 MHz.
    pub fn new() -> Self {
        Self {
            state: State::default(),
            protocol: Protocol::default(),
            recovery: Recovery::None,
            clock: RESET_CLOCK,
            dominant: false,
            sampled_dominant: false,
            changed: false,
            overruns: 0,
            btr_history: VecDeque::new(),
            violations: Violations::default(),
        }
    }

    /// CAN1 of the STM32F446, which shares its filter banks with CAN2.
    pub fn with_shared_filters() -> Self {
        let mut controller = Self::new();
        controller.state.filters = Filters::new(true);
        controller
    }

    /// Resets the registers and the error counters; a current frame is aborted. The clock and the recorded history stay.
    pub fn reset(&mut self) {
        let filters = Filters::new(self.state.filters.are_shared());
        self.state = State {
            filters,
            ..State::default()
        };
        self.protocol.leave();
        self.protocol.reset();
        self.recovery = Recovery::None;
        self.changed = true;
    }

    /// Sets the clock, PCLK1, in Hz.
    ///
    /// # Panics
    /// When it is 0.
    pub fn set_clock(&mut self, hz: u32) {
        assert_ne!(
            hz, 0,
            "a controller without a clock cannot run or be accessed"
        );
        if hz != self.clock && self.state.control.is_on() {
            let reason = format!("changed from {} to {hz} Hz while on the bus", self.clock);
            self.violations.record("PCLK1", reason);
        }
        self.clock = hz;
    }

    /// The protocol state: the level that it drives, its error counters.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// The frame to be sent next, if one may be started.
    pub fn offered(&self) -> Option<Frame> {
        if !self.may_start() {
            return None;
        }
        self.state.transmitter.offered(self.state.control.order())
    }

    /// When [`step`](Self::step) has to be called; None while there is no event on the wire.
    pub fn next_event(&self) -> Option<Picoseconds> {
        let offered = self.may_start() && self.state.transmitter.is_pending();
        self.protocol.next_event(offered)
    }

    /// Reports a new level of the wire.
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
            self.changed = true;
            self.settle(now);
        }
    }

    /// Processes the bit that is due on the wire, which has this level.
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

    /// Handles an event on the wire. [`step`](Self::step) calls it; a test may call it to simulate the wire.
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
        self.changed = true;
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

    /// True once after an event that may have changed an interrupt line, the driven level or the time of the next event.
    pub fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }

    /// The bit rate in bit/s, rounded to nearest; None while off the bus.
    pub fn bit_rate(&self) -> Option<u32> {
        let on = self.state.control.is_on();
        on.then(|| self.state.timing.bit_rate(self.clock))
    }

    /// True when CAN_BTR selects silent mode.
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

    /// The violations of the software, oldest first; at most 1000.
    pub fn violations(&self) -> &[Violation] {
        &self.violations.all
    }

    fn may_start(&self) -> bool {
        self.state.control.may_start() && !self.state.timing.is_silent()
    }

    /// In bus-off the protocol reports the end of the recovery, but not the 11 recessive bits that end initialization mode.
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

    /// Updates the mode, the recovery and the error status after events and requests.
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
            self.changed = true;
        }
        let before = self.state.status.interrupts();
        self.state
            .status
            .sleeps(self.state.control.mode() == Mode::Sleep);
        self.state.status.follow(Confinement::from(&self.protocol));
        self.changed |= before != self.state.status.interrupts();
    }

    /// Starts to wait for 11 recessive bits.
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
        self.changed = true;
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
        self.changed = true;
    }

    /// True when the recovery from bus-off has to begin: on the bus, and requested or automatic.
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
