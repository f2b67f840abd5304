//! bxCAN, the CAN controller of the STM32F103 (reference manual RM0008, chapter 24), from the view of software: registers,
//! mailboxes, FIFOs, filters, interrupt lines. [`Protocol`] simulates the wire side.
//!
//! The bus calls [`wire`](BxCan::wire) at every edge and [`step`](BxCan::step) when [`next_event`](BxCan::next_event) is due.
//!
//! [`Silicon`] selects the behaviour that the manual leaves open: the times of changes, and a fault of silent mode.
//!
//! Not modelled: time-triggered communication and accesses narrower than a word. In a direct change from sleep mode to
//! bus-off without a requested recovery, the controller does not listen to the bus.

mod access;
mod change;
mod errors;
mod filters;
mod mailbox;
mod mode;
mod receive;
mod registers;
mod silicon;
mod timing;
mod transmit;
mod violations;

pub use silicon::{ResetTime, Silicon};
pub use violations::Violation;

use can_wire::protocol::{Event, Picoseconds, Protocol};
use errors::Status;
use filters::Filters;
use mode::{Control, Mode};
use plumbline::can::Frame;
use plumbline::node::BusState;
use receive::Fifo;
use silicon::{Lock, Resetting};
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
    /// No change is requested.
    None,
    /// Software has entered initialization mode; the recovery begins when the controller joins the bus.
    Due,
    /// The recessive bits of the recovery are counted.
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

/// The CAN controller: registers, mailboxes, FIFOs and filters around [`Protocol`].
#[derive(Debug)]
pub struct BxCan {
    state: State,
    protocol: Protocol,
    recovery: Recovery,
    silicon: Silicon,
    lock: Lock,
    /// A reset by CAN_MCR.RESET that has not ended.
    resetting: Option<Resetting>,
    /// The time of the last request of another mode.
    requested_at: Picoseconds,
    clock: u32,
    dominant: bool,
    sampled_dominant: bool,
    changed: bool,
    overruns: u64,
    /// Messages that a filter has accepted.
    stored: u64,
    /// How many times software has stopped the reception on the bus by CAN_FMR.FINIT.
    reception_stops: u64,
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
            silicon: Silicon::default(),
            lock: Lock::default(),
            resetting: None,
            requested_at: 0,
            clock: RESET_CLOCK,
            dominant: false,
            sampled_dominant: false,
            changed: false,
            overruns: 0,
            stored: 0,
            reception_stops: 0,
            btr_history: VecDeque::new(),
            violations: Violations::default(),
        }
    }

    /// CAN1 of the STM32F446, which shares its filter banks with CAN2.
    pub fn with_shared_filters() -> Self {
        let mut controller = Self::new();
        let master = controller.silicon.filter_master;
        controller.state.filters = Filters::new(true, master);
        controller
    }

    /// A reset by RCC or of the microcontroller: resets the registers and the error counters; a current frame is aborted. The
    /// clock and the recorded history stay.
    pub fn reset(&mut self) {
        let shared = self.state.filters.are_shared();
        let filters = Filters::new(shared, self.silicon.filter_master);
        self.state = State {
            filters,
            ..State::default()
        };
        self.protocol.leave();
        self.protocol.reset();
        self.recovery = Recovery::None;
        self.lock.reset();
        self.resetting = None;
        self.changed = true;
    }

    /// The power is switched on: earlier uses of silent mode do not count.
    pub fn power_on(&mut self) {
        self.reset();
        self.lock = Lock::default();
    }

    /// Selects the behaviour that the manual leaves open. If CAN2SB is writable, its new value takes effect at the next reset.
    pub fn set_silicon(&mut self, silicon: Silicon) {
        self.silicon = silicon;
    }

    /// The behaviour that the manual leaves open.
    pub fn silicon(&self) -> Silicon {
        self.silicon
    }

    /// The level of the transmit output; true is dominant.
    pub fn is_dominant(&self) -> bool {
        self.protocol.is_dominant() || self.lock.is_locked()
    }

    /// True when the transmit output is locked at the dominant level.
    pub fn is_locked(&self) -> bool {
        self.lock.is_locked()
    }

    /// Notes that something outside has changed the level on the wire.
    pub(super) fn touch(&mut self) {
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
        self.disturb_clock(hz);
    }

    /// Sets the frequency of PCLK1 in Hz after a disturbance of RCC. This is no violation.
    pub fn disturb_clock(&mut self, hz: u32) {
        if hz != self.clock {
            self.clock = hz;
            self.retime();
        }
    }

    /// The bit time follows CAN_BTR and the clock.
    fn retime(&mut self) {
        let timing = self.state.timing;
        self.protocol
            .retime(timing.bit_timing(self.clock), timing.is_silent());
        self.changed = true;
    }

    /// Sets the frequency of PCLK1 in Hz after a failure of the crystal. This is no violation. In this model, the bit time on the bus does
    /// not change until the firmware reacts.
    pub fn lose_clock(&mut self, hz: u32) {
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
        let [first, second] = &self.state.fifos;
        let times = [
            self.next_bit(),
            first.next_event(),
            second.next_event(),
            self.acknowledges_at(),
        ];
        times.into_iter().flatten().min()
    }

    /// When the protocol has to be stepped.
    fn next_bit(&self) -> Option<Picoseconds> {
        let offered = self.may_start() && self.state.transmitter.is_pending();
        self.protocol.next_event(offered)
    }

    /// Reports a new level of the wire.
    pub fn wire(&mut self, now: Picoseconds, dominant: bool) {
        let edge = dominant && !self.dominant;
        self.dominant = dominant;
        if !edge || self.state.timing.is_looped_back() {
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
        let dominant = self.looped_back().unwrap_or(dominant);
        if self.next_bit().is_none_or(|due| due > now) {
            self.settle(now);
            self.changed = true;
            return None;
        }
        self.listen_in_bus_off(dominant);
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
        let seen = matches!(event, Event::Received(_) | Event::Error { .. });
        if seen && state.timing.is_silent() {
            self.lock.see_frame(self.silicon.lock_after);
        }
        match event {
            Event::Joined if !self.silicon.joins => {
                let timing = state.timing.bit_timing(self.clock);
                self.protocol.join(now, timing, state.timing.is_silent());
            }
            Event::Joined => state.control.joined(),
            Event::Started => state.transmitter.started(state.control.order()),
            Event::LostArbitration => state.transmitter.ended(Outcome::LostArbitration, again),
            Event::Transmitted => {
                state.status.succeeded();
                let looped_back = state.timing.is_looped_back();
                let sent = state.transmitter.sent().filter(|_| looped_back);
                state.transmitter.ended(Outcome::Succeeded, again);
                if let Some(frame) = sent {
                    self.store(&frame);
                }
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

    /// Messages that a filter has accepted, lost ones included.
    pub fn stored(&self) -> u64 {
        self.stored
    }

    /// How many times software has stopped the reception by CAN_FMR.FINIT while the controller was on the bus: frames that end
    /// meanwhile are lost.
    pub fn reception_stops(&self) -> u64 {
        self.reception_stops
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

    /// The level that the controller receives in loop back mode: its own, and it ignores that nobody acknowledges (RM0008, 24.4.4).
    fn looped_back(&self) -> Option<bool> {
        let acknowledged = self.protocol.is_transmitting() && self.protocol.is_at_ack_slot();
        let level = self.protocol.is_dominant() || acknowledged;
        self.state.timing.is_looped_back().then_some(level)
    }

    /// In bus-off the protocol reports the end of the recovery, but not the 11 recessive bits that end initialization mode.
    fn listen_in_bus_off(&mut self, dominant: bool) {
        if self.protocol.state() == BusState::BusOff {
            self.state.control.listen(dominant);
        }
    }

    fn store(&mut self, frame: &Frame) {
        let Some(found) = self.state.filters.accept(frame) else {
            return;
        };
        self.stored += 1;
        let message = mailbox::words(frame, found.index, self.silicon.long_length);
        let locked = self.state.control.locks_fifo();
        if !self.state.fifos[found.fifo].store(message, locked) {
            self.overruns += 1;
        }
    }
}

#[cfg(test)]
mod tests;
