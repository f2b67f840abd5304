//! bxCAN, the CAN controller of the STM32F103 (reference manual RM0008, chapter 24), as software sees it: registers, mailboxes,
//! FIFOs, filters, interrupt lines. What happens on the wire is the business of [`Protocol`].
//!
//! The bus calls [`wire`](BxCan::wire) at every edge and [`step`](BxCan::step) when [`next_event`](BxCan::next_event) is due.
//!
//! Not modelled: loop back, time-triggered communication and access to a register by less than a word. A change of mode that does
//! not wait for the bus takes no time. A reset by CAN_MCR.RESET is as good as one by RCC. A received length code of 9 to 15 reads
//! as 8, which is all that a [`Frame`] has.

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

use super::io::AccessError;
use crate::bench::protocol::{Event, Picoseconds, Protocol};
use errors::{Confinement, Status};
use filters::Filters;
use mode::{Change, Control, Mode};
use plumbline::can::Frame;
use plumbline::node::BusState;
use receive::Fifo;
use registers::Register;
use timing::Timing;
use transmit::{Outcome, Transmitter};
use violations::Violations;

/// PCLK1 after a reset of the microcontroller: the internal oscillator, in Hz.
const RESET_CLOCK: u32 = 8_000_000;

/// CAN_MSR.RX and SAMP: the level on the receive pin, now and at the last sample point.
const RECESSIVE: u32 = 1 << 11;
const SAMPLED_RECESSIVE: u32 = 1 << 10;
/// CAN_MSR.RXM and TXM: receiver or transmitter of the frame under way.
const RECEIVING: u32 = 1 << 9;
const TRANSMITTING: u32 = 1 << 8;

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
    btr_history: Vec<(Picoseconds, u32)>,
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
            btr_history: Vec::new(),
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

    /// Reads the register at an offset from the peripheral's base.
    ///
    /// # Errors
    /// There is no register.
    pub fn read(&mut self, now: Picoseconds, offset: u32) -> Result<u32, AccessError> {
        let register = Register::at(offset).ok_or(AccessError::Unmapped)?;
        self.settle(now);
        let state = &self.state;
        Ok(match register {
            Register::MasterControl => state.control.value(),
            Register::MasterStatus => self.master_status(),
            Register::TransmitStatus => state.transmitter.status(state.control.order()),
            Register::ReceiveFifo(fifo) => state.fifos[fifo].status(),
            Register::InterruptEnable => state.status.enabled(),
            Register::ErrorStatus => state.status.error_status(),
            Register::BitTiming => state.timing.value(),
            Register::Transmit { mailbox, word } => state.transmitter.read(mailbox, word),
            Register::Receive { fifo, word } => {
                state.fifos[fifo].read(word, register.name(), &mut self.violations)
            }
            Register::FilterMaster
            | Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation
            | Register::FilterBank { .. } => state.filters.read(register),
        })
    }

    /// Writes the register at an offset from the peripheral's base.
    ///
    /// # Errors
    /// There is no register, or the write asks for something that is not modelled.
    pub fn write(&mut self, now: Picoseconds, offset: u32, value: u32) -> Result<(), AccessError> {
        let register = Register::at(offset).ok_or(AccessError::Unmapped)?;
        self.settle(now);
        let (mask, kept) = register.reserved();
        if value & mask != kept {
            let reason = format!("{value:08X}h changes reserved bits");
            self.violations.record(register.name(), reason);
        }
        match register {
            Register::MasterControl => self.write_control(value)?,
            Register::MasterStatus => self.state.status.clear_interrupts(value),
            Register::TransmitStatus => self.state.transmitter.write_status(value),
            Register::ReceiveFifo(fifo) => {
                self.state.fifos[fifo].write_status(value, register.name(), &mut self.violations)
            }
            Register::InterruptEnable => self.state.status.enable(value),
            Register::ErrorStatus => self.write_error_status(value),
            Register::BitTiming => self.write_timing(now, value)?,
            Register::Transmit { mailbox, word } => self.write_mailbox(mailbox, word, value),
            Register::Receive { .. } => self.violations.record(register.name(), "is read-only"),
            Register::FilterMaster
            | Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation
            | Register::FilterBank { .. } => {
                self.state
                    .filters
                    .write(register, value, &mut self.violations);
            }
        }
        self.attention = true;
        self.settle(now);
        Ok(())
    }

    /// What happens on the wire, for the bus that steps it by itself. It has to call [`event`](Self::event) then.
    pub fn protocol_mut(&mut self) -> &mut Protocol {
        &mut self.protocol
    }

    /// What happens on the wire.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// The frame to be sent next, when one may be started.
    pub fn offered(&self) -> Option<Frame> {
        if !self.state.control.may_start() || self.state.timing.is_silent() {
            return None;
        }
        self.state.transmitter.offered(self.state.control.order())
    }

    /// When [`step`](Self::step) has to be called; None while nothing happens on the wire.
    pub fn next_event(&self) -> Option<Picoseconds> {
        self.protocol.next_event(self.offered().is_some())
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
        let offered = self.offered();
        self.dominant = dominant;
        self.sampled_dominant = dominant;
        let event = self.protocol.step(now, dominant, offered);
        match event {
            Some(event) => self.event(now, event),
            None => self.settle(now),
        }
        event
    }

    /// Something has happened on the wire.
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
            Event::Recovered => self.recovery = Recovery::None,
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

    /// Every value written to CAN_BTR, with its time.
    pub fn btr_history(&self) -> &[(Picoseconds, u32)] {
        &self.btr_history
    }

    /// Messages lost because a FIFO was full.
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// What software did wrong, oldest first.
    pub fn violations(&self) -> &[Violation] {
        &self.violations.all
    }

    fn master_status(&self) -> u32 {
        let state = &self.state;
        let receiving = self.protocol.is_busy() && !self.protocol.is_transmitting();
        let bits = [
            (!self.dominant, RECESSIVE),
            (!self.sampled_dominant, SAMPLED_RECESSIVE),
            (receiving, RECEIVING),
            (self.protocol.is_transmitting(), TRANSMITTING),
        ];
        let levels = bits
            .iter()
            .filter(|(is, _)| *is)
            .map(|(_, bit)| bit)
            .sum::<u32>();
        levels | state.status.interrupts() | state.control.acknowledged()
    }

    fn write_control(&mut self, value: u32) -> Result<(), AccessError> {
        if value & mode::TIME_TRIGGERED != 0 {
            return Err(AccessError::Refused(
                "CAN_MCR.TTCM: time-triggered communication is not modelled",
            ));
        }
        if value & mode::RESET == 0 {
            self.state.control.write(value);
        } else {
            self.reset();
        }
        Ok(())
    }

    fn write_error_status(&mut self, value: u32) {
        if !self.state.status.write_error_status(value) {
            let register = Register::ErrorStatus.name();
            self.violations
                .record(register, "LEC: software may write 7 only");
        }
    }

    fn write_timing(&mut self, now: Picoseconds, value: u32) -> Result<(), AccessError> {
        if value & timing::LOOP_BACK != 0 {
            return Err(AccessError::Refused(
                "CAN_BTR.LBKM: loop back is not modelled",
            ));
        }
        if !self.state.control.is_initializing() {
            let register = Register::BitTiming.name();
            self.violations
                .record(register, "written outside initialization mode");
            return Ok(());
        }
        self.state.timing = Timing::new(value);
        self.btr_history.push((now, self.state.timing.value()));
        Ok(())
    }

    fn write_mailbox(&mut self, mailbox: usize, word: usize, value: u32) {
        let state = &mut self.state;
        let requested = state
            .transmitter
            .write(mailbox, word, value, &mut self.violations);
        if requested && state.timing.is_silent() && state.control.is_on() {
            let register = Register::Transmit { mailbox, word }.name();
            self.violations
                .record(register, "transmission requested in silent mode");
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

    /// True when the recovery from bus-off is to begin: in normal mode, and asked for or automatic.
    fn is_recovery_due(&self) -> bool {
        let asked = match self.recovery {
            Recovery::None => self.state.control.recovers(),
            Recovery::Due => true,
            Recovery::UnderWay => false,
        };
        asked
            && self.state.control.mode() == Mode::Normal
            && self.protocol.state() == BusState::BusOff
    }
}

#[cfg(test)]
mod tests;
