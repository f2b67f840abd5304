//! bxCAN: frames in and out, listen-only mode, acceptance filters, fault state, bus-off.
//!
//! The bxcan crate sets the controller up and looks after filter banks and transmit mailboxes. Three things are done by registers:
//!
//! - Changes of mode and bit rate ([`Bus::step`]). The crate waits in a loop for the controller, which on a bus that is stuck is
//!   for ever, and it switches automatic bus-off recovery on (MCR.ABOM), which the node wants to decide itself. Here ABOM is never
//!   set, and the main loop looks in now and then whether the controller has followed.
//! - The fault state (CAN_ESR), which the crate does not have.
//! - Reading the receive FIFO (`can/receive.rs`).

mod receive;

pub use receive::on_received;

use crate::bit_timing::btr;
use crate::board::{self, CanPeripheral};
use crate::{clock, sleep};
use bxcan::filter::Mask32;
use bxcan::{ExtendedId, Fifo, Interrupts, StandardId};
use cortex_m::peripheral::NVIC;
use cortex_m::singleton;
use embedded_can::Id;
use heapless::spsc::{Consumer, Queue};
use plumbline::can::{BitRate, Filter, Frame};
use plumbline::node::{BusEvent, BusMode, BusState, Node};
use plumbline::time::{Duration, Instant, after, millis, reached};

/// Received frames that wait for the node: 1.5 ms of a full bus at 1 Mbit/s with the shortest frames.
const QUEUE: usize = 32 + 1; // one place stays empty

/// How long the controller may take to finish what it is doing on the bus: longer than the longest frame with its error frame
/// takes at 10 kbit/s.
const LEAVE_LIMIT: Duration = millis(25);

/// ESR.LEC: software has looked at the last error code.
const LEC_SEEN: u8 = 7;

/// The CAN controller of the board, for the bxcan crate.
struct Controller(CanPeripheral);

// SAFETY: owning the PAC's peripheral is owning the registers at this address. The interrupts reach around it, but only to registers
// that the main loop leaves alone.
unsafe impl bxcan::Instance for Controller {
    const REGISTERS: *mut bxcan::RegisterBlock = CanPeripheral::PTR.cast_mut().cast();
}

// SAFETY: the only, or the first, CAN controller owns the filter banks, and the board says how many there are.
unsafe impl bxcan::FilterOwner for Controller {
    const NUM_FILTER_BANKS: u8 = board::FILTER_BANKS;
}

/// The transmit interrupt: a mailbox has become free.
pub fn on_transmitted() {
    // SAFETY: only the request-completed flags of CAN_TSR are touched, which nobody else uses. They are cleared by writing 1, and
    // writing 0 to the rest changes nothing, so this cannot disturb what the main loop does with the register.
    let registers = unsafe { CanPeripheral::steal() };
    registers.tsr().write(|w| {
        w.rqcp0().set_bit();
        w.rqcp1().set_bit();
        w.rqcp2().set_bit()
    });
    sleep::wake();
}

/// Where a change of mode stands.
#[derive(Clone, Copy)]
enum Change {
    /// None under way.
    Done,
    /// The controller was asked for initialization mode and finishes a frame first.
    Leaving {
        /// When to stop waiting for it.
        limit: Instant,
    },
    /// The controller waits for 11 recessive bits to take part in the bus.
    Joining,
}

/// How to take part in the bus.
#[derive(Clone, Copy)]
struct Settings {
    mode: BusMode,
    rate: BitRate,
}

/// The CAN controller as the main loop sees it: everything but the receive FIFO.
pub struct Bus {
    can: bxcan::Can<Controller>,
    received: Consumer<'static, Frame>,
    /// A frame that no mailbox could take without overtaking or being overtaken.
    waiting: Option<bxcan::Frame>,
    /// None until the first [`configure`](Self::configure).
    settings: Option<Settings>,
    change: Change,
    /// The fault state last reported.
    state: BusState,
    /// Times that frames were lost.
    overruns: u32,
}

impl Bus {
    /// Takes the controller over and leaves it asleep, off the bus. None when called a second time.
    #[inline(never)] // so that only the boot needs its stack
    pub fn new(peripheral: CanPeripheral) -> Option<&'static mut Self> {
        let queue = singleton!(: Queue<Frame, QUEUE> = Queue::new())?;
        let (producer, consumer) = queue.split();
        // From sleep to initialization mode and back the controller does not look at the bus: no endless wait here.
        let can = bxcan::Can::builder(Controller(peripheral)).leave_disabled();
        receive::into(producer);
        // SAFETY: the handlers cope with any state of the controller, and no code relies on these interrupts being masked except
        // through critical sections.
        unsafe {
            NVIC::unmask(board::CAN_RECEIVE_INTERRUPT);
            NVIC::unmask(board::CAN_TRANSMIT_INTERRUPT);
        }
        singleton!(: Bus = Bus {
            can,
            received: consumer,
            waiting: None,
            settings: None,
            change: Change::Done,
            state: BusState::Active,
            overruns: 0,
        })
    }

    /// Changes over to this mode and bit rate, dropping whatever waits to be sent. [`step`](Self::step) carries it out.
    pub fn configure(&mut self, mode: BusMode, rate: BitRate) {
        self.settings = Some(Settings { mode, rate });
        self.waiting = None;
        abort_all(self.registers());
        self.leave();
    }

    /// Starts the recovery from bus-off: a visit to initialization mode, after which the controller counts 128 times 11
    /// recessive bits by itself. A change under way has the same effect.
    pub fn recover(&mut self) {
        if matches!(self.change, Change::Done) && self.settings.is_some() {
            self.leave();
        }
    }

    /// Asks for initialization mode.
    fn leave(&mut self) {
        request_initialization(self.registers());
        let limit = after(clock::now(), LEAVE_LIMIT);
        self.change = Change::Leaving { limit };
    }

    /// Carries a change of mode on; call it every millisecond or more often. In listen mode everything is accepted, otherwise what
    /// the filters of `node` let pass.
    pub fn step(&mut self, node: &impl Node) {
        match self.change {
            Change::Done => {}
            Change::Leaving { limit } => {
                if self.registers().msr().read().inak().bit_is_set() {
                    self.join(node);
                } else if reached(clock::now(), limit) {
                    // At a wrong bit rate the end of a frame may never be seen. Off the bus by force, into sleep.
                    self.registers().mcr().write(|w| w.reset().set_bit());
                    self.leave();
                }
            }
            Change::Joining => {
                let status = self.registers().msr().read();
                if status.inak().bit_is_clear() && status.slak().bit_is_clear() {
                    self.change = Change::Done;
                }
            }
        }
    }

    /// True while the bus must be looked at every millisecond: a change of mode is under way, or bus errors count. The fault state
    /// alone, of which no interrupt tells that it has become better, is seen soon enough with the samples.
    pub fn restless(&self) -> bool {
        !matches!(self.change, Change::Done) || self.is_listening()
    }

    fn is_listening(&self) -> bool {
        self.settings
            .as_ref()
            .is_some_and(|settings| settings.mode == BusMode::Listen)
    }

    /// In initialization mode: sets bit timing, mode, filters and interrupts, and joins the bus. What was heard at the rate before,
    /// frames and errors, is forgotten: it would be taken for the new rate's.
    fn join(&mut self, node: &impl Node) {
        while self.received.dequeue().is_some() {}
        self.forget_error();
        let Some(settings) = self.settings else {
            return;
        };
        let silent = u32::from(settings.mode == BusMode::Listen) << 31;
        let timing = btr(settings.rate) | silent;
        set_filters(&mut self.can, settings.mode, node);
        // SAFETY: timing fields from the table, which is tested, and the silent bit; loop back stays off.
        self.registers().btr().write(|w| unsafe { w.bits(timing) });
        self.can.enable_interrupts(
            Interrupts::FIFO0_MESSAGE_PENDING | Interrupts::TRANSMIT_MAILBOX_EMPTY,
        );
        self.registers().mcr().modify(|_, w| {
            w.abom().clear_bit();
            w.sleep().clear_bit();
            w.inrq().clear_bit()
        });
        self.change = Change::Joining;
    }

    /// What the controller has noticed since the last call; call until None.
    pub fn event(&mut self) -> Option<BusEvent> {
        if receive::overrun() {
            self.overruns = self.overruns.saturating_add(1);
            warn!("received frames lost, {=u32} times", self.overruns);
            return Some(BusEvent::Overrun);
        }
        if !matches!(self.change, Change::Done) {
            return None;
        }
        let status = self.registers().esr().read();
        let state = if status.boff().bit_is_set() {
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
        if !self.is_listening() || code == LEC_SEEN {
            return None;
        }
        self.forget_error();
        (code != 0).then_some(BusEvent::Error)
    }

    /// Marks the last error code as seen.
    fn forget_error(&mut self) {
        self.registers()
            .esr()
            // SAFETY: 7 is the value that the manual gives to software; the other bits are read-only.
            .write(|w| unsafe { w.bits(u32::from(LEC_SEEN) << 4) });
    }

    /// The oldest received frame that has not been taken; none while a change of mode is under way.
    pub fn receive(&mut self) -> Option<Frame> {
        if !matches!(self.change, Change::Done) {
            return None;
        }
        self.received.dequeue()
    }

    /// True when [`send`](Self::send) may be called: a mailbox is free and no frame waits for one.
    pub fn can_send(&mut self) -> bool {
        if let Some(frame) = self.waiting.take() {
            self.place(frame);
        }
        self.waiting.is_none() && self.is_normal() && mailbox_free(self.registers())
    }

    /// Sends a frame. Frames of the same identifier leave in the order of the calls.
    pub fn send(&mut self, frame: &Frame) {
        if let Some(frame) = to_bxcan(frame) {
            self.place(frame);
        }
    }

    /// True when every frame has left, or none ever will.
    pub fn sent(&mut self) -> bool {
        self.waiting.is_none() && self.can.is_transmitter_idle()
    }

    /// True when frames can be sent: not listening only, and no change of mode under way.
    fn is_normal(&self) -> bool {
        matches!(self.change, Change::Done)
            && self
                .settings
                .as_ref()
                .is_some_and(|settings| settings.mode == BusMode::Normal)
    }

    /// Puts the frame into a mailbox, or keeps it waiting: bxcan takes a frame only if it has a higher priority than all that are
    /// pending, because the controller sends equal ones in the order of the mailboxes, not of the requests.
    fn place(&mut self, frame: bxcan::Frame) {
        // With three pending mailboxes bxcan would take the lowest one back, and wait for its end if it is on the bus.
        if !self.is_normal() || !mailbox_free(self.registers()) {
            self.waiting = Some(frame);
            return;
        }
        self.waiting = match self.can.transmit(&frame) {
            Ok(status) => status.dequeued_frame().cloned(),
            Err(_) => Some(frame),
        };
    }

    fn registers(&mut self) -> &mut CanPeripheral {
        &mut self.can.instance().0
    }
}

/// Asks for initialization mode, out of normal or sleep mode, with automatic bus-off recovery off.
fn request_initialization(registers: &CanPeripheral) {
    registers.mcr().modify(|_, w| {
        w.abom().clear_bit();
        w.sleep().clear_bit();
        w.inrq().set_bit()
    });
}

/// Takes back the frames in the mailboxes; the one on the bus, if any, is given up unless it succeeds.
fn abort_all(registers: &CanPeripheral) {
    registers.tsr().write(|w| {
        w.abrq0().set_bit();
        w.abrq1().set_bit();
        w.abrq2().set_bit()
    });
}

fn mailbox_free(registers: &CanPeripheral) -> bool {
    let status = registers.tsr().read();
    status.tme0().bit_is_set() || status.tme1().bit_is_set() || status.tme2().bit_is_set()
}

/// Gives each filter a bank of its own, all of them 32 bits wide, in mask mode and for FIFO 0: so none outranks another and a
/// frame that agrees with two is stored once. Data and remote frames pass.
fn set_filters(can: &mut bxcan::Can<Controller>, mode: BusMode, node: &impl Node) {
    let mut banks = can.modify_filters();
    banks.clear();
    if mode == BusMode::Listen {
        banks.enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
        return;
    }
    let mut bank = 0;
    node.filters(&mut |filter| {
        // There is a bank for each filter: the firmware checks it when it is built.
        if bank < board::FILTER_BANKS
            && let Some(mask) = mask(&filter)
        {
            banks.enable_bank(bank, Fifo::Fifo0, mask);
            bank += 1;
        }
    });
}

fn mask(filter: &Filter) -> Option<Mask32> {
    Some(match filter.id {
        Id::Standard(id) => Mask32::frames_with_std_id(
            StandardId::new(id.as_raw())?,
            StandardId::new((filter.mask & 0x7FF) as u16)?,
        ),
        Id::Extended(id) => Mask32::frames_with_ext_id(
            ExtendedId::new(id.as_raw())?,
            ExtendedId::new(filter.mask & 0x1FFF_FFFF)?,
        ),
    })
}

fn to_bxcan(frame: &Frame) -> Option<bxcan::Frame> {
    let id: bxcan::Id = match frame.id() {
        Id::Standard(id) => StandardId::new(id.as_raw())?.into(),
        Id::Extended(id) => ExtendedId::new(id.as_raw())?.into(),
    };
    Some(if frame.is_remote() {
        bxcan::Frame::new_remote(id, frame.dlc() as u8)
    } else {
        bxcan::Frame::new_data(id, bxcan::Data::new(frame.bytes())?)
    })
}
