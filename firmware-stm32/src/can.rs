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

mod filters;
mod pulses;
mod receive;
mod transmit;

pub use pulses::on_pulse;
pub use receive::on_received;

use crate::bit_timing::btr;
use crate::board::{self, CanPeripheral};
use crate::{clock, sleep};
use bxcan::Interrupts;
use cortex_m::peripheral::NVIC;
use cortex_m::singleton;
use heapless::spsc::{Consumer, Queue};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BitTime, BusEvent, BusMode, BusState, Node};
use plumbline::time::{Duration, Instant, after, millis, reached};

/// The size of the receive queue: 1.5 ms at 1 Mbit/s with the shortest frames and 100 % bus load.
const QUEUE: usize = 32 + 1; // one element stays empty

/// The longest time that the controller needs to leave the bus: longer than the longest frame with its error frame at 10 kbit/s.
const LEAVE_LIMIT: Duration = millis(25);

/// The longest time that the controller may need for MCR.RESET. Then it is reset by RCC.
const RESET_LIMIT: Duration = millis(2);

/// The number of times that a step polls a change of mode. Most changes take a few clock cycles and end in one step.
const POLLS: u32 = 16;

/// ESR.LEC: the value that software sets after it has read the last error code.
const LEC_SEEN: u8 = 7;

/// The CAN controller of the board, for the bxcan crate.
struct Controller(CanPeripheral);

// SAFETY: the owner of the peripheral owns the registers at this address. The interrupts access only registers that the main loop
// does not use.
unsafe impl bxcan::Instance for Controller {
    const REGISTERS: *mut bxcan::RegisterBlock = CanPeripheral::PTR.cast_mut().cast();
}

/// The transmit interrupt: a mailbox has become free.
pub fn on_transmitted() {
    // SAFETY: only the request-completed flags of CAN_TSR are written, and no other code uses them. Writing 1 clears them, and
    // writing 0 to the other bits has no effect, so this does not affect the use of the register by the main loop.
    let registers = unsafe { CanPeripheral::steal() };
    registers.tsr().write(|w| {
        w.rqcp0().set_bit();
        w.rqcp1().set_bit();
        w.rqcp2().set_bit()
    });
    sleep::wake();
}

/// The state of a change of mode.
#[derive(Clone, Copy)]
enum Change {
    /// No change is running.
    Done,
    /// MCR.RESET is set. Sleep mode follows.
    Resetting {
        /// The end of the wait.
        limit: Instant,
        /// The error counters must be reset too.
        counters: bool,
    },
    /// Initialization mode is requested. The controller finishes a frame first.
    Leaving {
        /// The end of the wait.
        limit: Instant,
    },
    /// The controller waits for 11 recessive bits before it takes part in the bus.
    Joining,
}

/// The mode and bit rate of the bus.
#[derive(Clone, Copy)]
struct Settings {
    mode: BusMode,
    rate: BitRate,
}

/// The part of the CAN controller that the main loop uses: all except the receive FIFO.
pub struct Bus {
    can: bxcan::Can<Controller>,
    received: Consumer<'static, Frame>,
    /// None until the first [`configure`](Self::configure).
    settings: Option<Settings>,
    change: Change,
    /// The fault confinement state last reported.
    state: BusState,
    /// The number of overruns.
    overruns: u32,
}

impl Bus {
    /// Takes the controller and keeps it in sleep mode, off the bus. None on a second call.
    #[inline(never)] // so that only the boot needs its stack
    pub fn new(peripheral: CanPeripheral) -> Option<&'static mut Self> {
        let queue = singleton!(: Queue<Frame, QUEUE> = Queue::new())?;
        let (producer, consumer) = queue.split();
        // The change from sleep to initialization mode and back is independent of the bus, so the wait always ends.
        let can = bxcan::Can::builder(Controller(peripheral)).leave_disabled();
        receive::into(producer);
        // SAFETY: the handlers work in any state of the controller, and code that needs these interrupts masked uses critical
        // sections.
        unsafe {
            NVIC::unmask(board::CAN_RECEIVE_INTERRUPT);
            NVIC::unmask(board::CAN_TRANSMIT_INTERRUPT);
        }
        singleton!(: Bus = Bus {
            can,
            received: consumer,
            settings: None,
            change: Change::Done,
            state: BusState::Active,
            overruns: 0,
        })
    }

    /// Begins the change to this mode and bit rate. Discards the frames that are not sent yet. [`step`](Self::step) performs the
    /// change.
    pub fn configure(&mut self, mode: BusMode, rate: BitRate) {
        // A reset that still runs is begun again, so that its effect is not lost.
        let listening = self.is_listening() || matches!(self.change, Change::Resetting { .. });
        self.settings = Some(Settings { mode, rate });
        transmit::abort_all(self.registers());
        if listening {
            // At a wrong bit rate the controller may never detect the end of a frame, and there is none of its own. Errors of
            // the search must not count in normal mode.
            self.reset(mode == BusMode::Normal);
        } else {
            self.leave();
        }
    }

    /// Starts the recovery from bus-off: enters and leaves initialization mode. Then the controller waits for 128 times 11
    /// recessive bits. A running change of mode has the same effect.
    pub fn recover(&mut self) {
        if matches!(self.change, Change::Done) && self.settings.is_some() {
            self.leave();
        }
    }

    /// Begins to reset the controller by MCR.RESET. The transmit pin is recessive from now on.
    fn reset(&mut self, counters: bool) {
        board::connect_transmitter(false);
        self.registers().mcr().write(|w| w.reset().set_bit());
        let limit = after(clock::now(), RESET_LIMIT);
        self.change = Change::Resetting { limit, counters };
    }

    /// Begins to enter initialization mode.
    fn leave(&mut self) {
        // The other bits get their reset values, until `join`: bus-off recovery is not automatic.
        self.registers()
            .mcr()
            .write(|w| w.sleep().clear_bit().inrq().set_bit());
        let limit = after(clock::now(), LEAVE_LIMIT);
        self.change = Change::Leaving { limit };
    }

    /// Performs a step of a change of mode. Call it at least every millisecond. In listen mode all frames are accepted, otherwise
    /// those that pass the filters of `node`.
    pub fn step(&mut self, node: &impl Node) {
        if self.restless() {
            self.proceed(node);
        }
    }

    /// Performs a step of a running change of mode.
    #[inline(never)] // so that the main loop keeps its registers
    fn proceed(&mut self, node: &impl Node) {
        for _ in 0..POLLS {
            let registers = self.registers();
            let status = registers.msr().read();
            let resets = registers.mcr().read().reset().bit_is_set();
            match self.change {
                Change::Done => return,
                Change::Resetting { limit, counters } => {
                    let ended = !resets && status.slak().bit_is_set();
                    let late = reached(clock::now(), limit);
                    if late || ended && counters {
                        // The controller is off the bus, without its pin, and has no cause of an interrupt.
                        board::reset_can();
                    }
                    if late || ended {
                        self.leave();
                    }
                }
                Change::Leaving { limit } => {
                    if status.inak().bit_is_set() {
                        return self.join(node);
                    }
                    if reached(clock::now(), limit) {
                        self.reset(false);
                    }
                }
                Change::Joining => {
                    // No limit: the controller waits for the bus, drives nothing, and the node can change the mode again.
                    if status.inak().bit_is_clear() && status.slak().bit_is_clear() {
                        self.change = Change::Done;
                    }
                    return;
                }
            }
        }
    }

    /// Starts the measurement of the bit time before the first change to listen mode, stops it in normal mode.
    pub fn measure(&mut self, mode: BusMode) {
        match mode {
            BusMode::Listen if self.is_listening() => {}
            BusMode::Listen => pulses::start(),
            BusMode::Normal => pulses::stop(),
        }
    }

    /// The measured bit time of the last frame, once.
    pub fn bit_time(&mut self) -> Option<BitTime> {
        pulses::poll(clock::now()).filter(|_| self.is_listening())
    }

    /// True while the bus must be polled every millisecond to measure the bit time, because there was a pulse.
    pub fn measures(&self) -> bool {
        self.is_listening() && pulses::is_pending()
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
        self.settings
            .as_ref()
            .is_some_and(|settings| settings.mode == BusMode::Listen)
    }

    /// In initialization mode: sets bit timing, mode, filters and interrupts, and joins the bus. Frames and errors of the
    /// previous bit rate are discarded, so that they are not attributed to the new one.
    fn join(&mut self, node: &impl Node) {
        while self.received.dequeue().is_some() {}
        self.forget_error();
        let Some(settings) = self.settings else {
            return;
        };
        let silent = u32::from(settings.mode == BusMode::Listen) << 31;
        let timing = btr(settings.rate) | silent;
        filters::set(self.registers(), settings.mode, node);
        // SAFETY: timing fields from the tested table, and the silent bit. Loop back stays off.
        self.registers().btr().write(|w| unsafe { w.bits(timing) });
        self.can.enable_interrupts(
            Interrupts::FIFO0_MESSAGE_PENDING | Interrupts::TRANSMIT_MAILBOX_EMPTY,
        );
        // In initialization mode the output of the controller is recessive (RM0008, 24.4.1).
        board::connect_transmitter(settings.mode == BusMode::Normal);
        self.registers().mcr().modify(|_, w| {
            w.txfp().set_bit();
            w.abom().clear_bit();
            w.sleep().clear_bit();
            w.inrq().clear_bit()
        });
        self.change = Change::Joining;
    }

    /// The next event of the controller since the last call. Call it until it returns None.
    pub fn event(&mut self) -> Option<BusEvent> {
        if receive::overrun() {
            self.overruns = self.overruns.saturating_add(1);
            warn!("received frames lost, {=u32} times", self.overruns);
            return Some(BusEvent::Overrun);
        }
        if !matches!(self.change, Change::Done) {
            return None;
        }
        let listening = self.is_listening();
        let status = self.registers().esr().read();
        let state = if listening {
            // Errors at a wrong bit rate are no fault.
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
            return Some(BusEvent::State(state));
        }
        let code = status.lec().bits();
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

    /// The next received frame; None while a change of mode is running.
    pub fn receive(&mut self) -> Option<Frame> {
        if !matches!(self.change, Change::Done) {
            return None;
        }
        self.received.dequeue()
    }

    /// True if [`send`](Self::send) can be called.
    pub fn can_send(&mut self) -> bool {
        self.is_normal() && transmit::has_room(self.registers())
    }

    /// Sends a frame. The frames are sent in the order of the calls.
    pub fn send(&mut self, frame: &Frame) {
        transmit::put(self.registers(), frame);
    }

    /// True if all frames are sent or aborted.
    pub fn sent(&mut self) -> bool {
        transmit::is_idle(self.registers())
    }

    /// True if frames can be sent: normal mode, and no change of mode is running.
    fn is_normal(&self) -> bool {
        matches!(self.change, Change::Done)
            && self
                .settings
                .as_ref()
                .is_some_and(|settings| settings.mode == BusMode::Normal)
    }

    fn registers(&mut self) -> &mut CanPeripheral {
        &mut self.can.instance().0
    }
}
