//! bxCAN driver: frames, listen-only mode, acceptance filters, fault confinement state, bus-off.
//!
//! The bxcan crate initialises the controller. These functions use the registers directly:
//!
//! - Changes of mode and bit rate ([`Bus::step`]). The crate waits in a loop for the controller, which does not end if the bus is
//!   stuck. It also enables automatic bus-off recovery (MCR.ABOM), but the node must control the recovery. Here ABOM is never
//!   set, and the main loop polls the controller for a limited time.
//! - A reset of the controller, which has two kinds. MCR.RESET stays set for a time that the manual does not specify, and leaves the
//!   error counters. A reset by RCC also resets these, but after it silent mode can lock the transmit output at the dominant level
//!   on some chips until the next one. So the transmit pin is a recessive output of the port except in normal mode, and the last
//!   reset before normal mode is one by RCC, if the controller has listened.
//! - The fault confinement state (CAN_ESR), which the crate does not support.
//! - Reading the receive FIFO (`can/receive.rs`).
//! - The acceptance filters (`can/filters.rs`): the crate reads the number of banks from a field that some microcontrollers do not
//!   have.
//! - The transmit mailboxes (`can/transmit.rs`): the crate keeps them in the order of the identifiers, and a frame of the node must
//!   not overtake an earlier one.

mod change;
mod events;
mod filters;
mod inspection;
pub mod mailboxes;
mod pulses;
pub mod receive;
mod setup;
pub mod transmit;

pub use events::BusEvents;
pub use pulses::on_pulse;

use change::Change;
use pulses::Pulses;
use setup::Setup;

use crate::board::{self, CanPeripheral};
use crate::clock;
use cortex_m::peripheral::NVIC;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::singleton;
use plumbline::can::BitRate;
use plumbline::node::driver::Filters;
use plumbline::node::{BitTime, BusEvent, BusMode, BusState};
use plumbline::time::Instant;

/// ESR.LEC: the value that software sets after it has read the last error code.
const LEC_SEEN: u8 = 7;

/// The CAN controller of the board, for the bxcan crate.
struct Controller(CanPeripheral);

// SAFETY: the owner of the peripheral owns the registers at this address. The interrupts use the receive FIFO and the mailboxes, and MCR.NART
// in normal mode. The main loop uses these only within a critical section, except TSR. It reads TSR, or writes it with 0 in all bits that it
// does not use, which has no effect on them.
unsafe impl bxcan::Instance for Controller {
    const REGISTERS: *mut bxcan::RegisterBlock = CanPeripheral::PTR.cast_mut().cast();
}

/// Gives the interrupts of the controller and SysTick the same priority: none of them interrupts another one. That of the pulses
/// ([`on_pulse`]) keeps a higher priority. Call it before [`Bus::new`].
pub fn set_priorities() {
    const LOWER: u8 = 0x10;
    // SAFETY: no critical section depends on a priority, and this is the only code that changes them, before the interrupts are enabled.
    unsafe {
        let mut core = cortex_m::Peripherals::steal();
        core.NVIC.set_priority(board::CAN_RECEIVE_INTERRUPT, LOWER);
        core.NVIC.set_priority(board::CAN_TRANSMIT_INTERRUPT, LOWER);
        core.SCB.set_priority(SystemHandler::SysTick, LOWER);
    }
}

/// Unmasks the interrupts of the controller.
fn unmask_interrupts() {
    // SAFETY: the handlers work in any state of the controller, and code that needs these interrupts masked uses critical sections.
    unsafe {
        NVIC::unmask(board::CAN_RECEIVE_INTERRUPT);
        NVIC::unmask(board::CAN_TRANSMIT_INTERRUPT);
    }
}

/// The part of the CAN controller that the main loop uses: all except the receive FIFO and the mailboxes.
pub struct Bus {
    can: bxcan::Can<Controller>,
    setup: Setup,
    change: Change,
    /// The number of times that the controller did not acknowledge initialization mode, since it did last.
    tries: u8,
    /// The fault confinement state last reported.
    state: BusState,
    overruns: u32,
    pulses: Pulses,
    /// The time of the next comparison.
    inspection: Instant,
    /// The [difference](Self::difference) after the registers were set: values that the controller does not take.
    untaken: u32,
}

impl Bus {
    /// Takes the controller and keeps it in sleep mode, off the bus. None on a second call.
    pub fn new(peripheral: CanPeripheral) -> Option<&'static mut Self> {
        // The change from sleep to initialization mode and back is independent of the bus. A dead controller does not acknowledge it; then
        // the watchdog, which runs since the start of the boot, ends the wait.
        let can = bxcan::Can::builder(Controller(peripheral)).leave_disabled();
        unmask_interrupts();
        singleton!(BUS: Bus = Bus {
            can,
            setup: Setup::NONE,
            change: Change::Done,
            tries: 0,
            state: BusState::Active,
            overruns: 0,
            pulses: Pulses::NONE,
            inspection: clock::now(),
            untaken: 0,
        })
    }

    /// Begins the change to this mode and bit rate. [`step`](Self::step) performs the change.
    pub fn configure(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>) {
        // A reset that still runs is begun again, so that its effect is not lost.
        let listening = self.is_listening() || matches!(self.change, Change::Resetting { .. });
        self.setup = Setup::of(mode, rate, filters);
        if listening {
            // At a wrong bit rate the controller may never detect the end of a frame, and there is none of its own. Errors of
            // the search must not count in normal mode.
            self.reset(mode == BusMode::Normal);
        } else {
            self.leave();
        }
    }

    /// Changes the filters without a change of the mode. Filters that stay receive without a gap. Returns false if a change of the mode
    /// is running.
    pub fn refilter(&mut self, filters: Filters<'_>) -> bool {
        if self.restless() {
            return false;
        }
        self.setup.refilter(&self.can.instance().0, filters);
        self.inspection = clock::now();
        true
    }

    /// Starts the recovery from bus-off: enters and leaves initialization mode. Then the controller waits for 128 times 11
    /// recessive bits. A running change of mode has the same effect.
    pub fn recover(&mut self) {
        if matches!(self.change, Change::Done) && !self.setup.is_none() {
            self.leave();
        }
    }

    /// Starts the measurement of the bit time before the first change to listen mode, stops it in normal mode.
    pub fn measure(&mut self, mode: BusMode) {
        match mode {
            BusMode::Listen if self.is_listening() => {}
            BusMode::Listen => self.pulses.start(),
            BusMode::Normal => self.pulses.stop(),
        }
    }

    /// The measured bit time of the last frame, once.
    pub fn bit_time(&mut self) -> Option<BitTime> {
        let time = self.pulses.poll(clock::now());
        time.filter(|_| self.is_listening())
    }

    /// True while the bus must be polled every millisecond to measure the bit time, because there was a pulse.
    pub fn measures(&self) -> bool {
        self.is_listening() && self.pulses.is_pending()
    }

    /// True during a change of the bit rate on a busy bus: the next frame comes in less than a millisecond.
    pub fn is_urgent(&self) -> bool {
        self.restless() && self.measures()
    }

    /// True while the bus must be polled every millisecond, because a change of mode is running. No interrupt reports that the
    /// fault confinement state has improved; polling it once per sample is sufficient.
    pub fn restless(&self) -> bool {
        !matches!(self.change, Change::Done)
    }

    fn is_listening(&self) -> bool {
        self.setup.is_listening()
    }

    /// The next event of the controller since the last call. Call it until it returns None.
    pub fn event(&mut self) -> Option<BusEvent> {
        if receive::overrun() {
            self.overruns = self.overruns.saturating_add(1);
            warn!("received frames lost, {=u32} times", self.overruns);
            return Some(BusEvent::Overrun);
        }
        let listening = self.is_listening();
        if self.change.is_prevented() && !listening && self.state == BusState::Active {
            // On the bus, the receive error counter would reach this limit.
            self.state = BusState::Warning;
            return Some(BusEvent::State(self.state));
        }
        if !matches!(self.change, Change::Done) {
            return None;
        }
        let status = self.registers().esr().read();
        let code = status.lec().bits();
        let state = if listening || self.state == BusState::BusOff && code != LEC_SEEN {
            // Errors at a wrong bit rate are no fault. A controller in bus-off detects no frames and no errors. So if it has a new error
            // code after bus-off, it has recovered, and the next bus-off is reported again.
            BusState::Active
        } else if status.boff().bit_is_set() {
            BusState::BusOff
        } else if status.epvf().bit_is_set() {
            BusState::Passive
        } else if status.ewgf().bit_is_set() {
            BusState::Warning
        } else {
            BusState::Active
        };
        if state != self.state {
            self.state = state;
            if !listening {
                self.forget_error();
            }
            return Some(BusEvent::State(state));
        }
        if !listening || code == LEC_SEEN {
            return None;
        }
        self.forget_error();
        (code != 0).then_some(BusEvent::Error)
    }

    /// Marks the last error code as read.
    fn forget_error(&mut self) {
        self.registers()
            .esr()
            // SAFETY: 7 is the value that the manual defines for software. The other bits are read-only.
            .write(|w| unsafe { w.bits(u32::from(LEC_SEEN) << 4) });
    }

    fn registers(&mut self) -> &mut CanPeripheral {
        &mut self.can.instance().0
    }
}
