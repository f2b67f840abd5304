//! A disturbance can change a configuration register. Then the sensor could stop sending although its program runs. So the firmware
//! compares the configuration ten times a second with the right values, and restores it or restarts.

use super::{Bus, Change, transmit, unmask_interrupts};
use crate::board;
use crate::clock;
use plumbline::node::BusMode;
use plumbline::time::{Duration, Instant, after, millis};

/// The time between comparisons. If the disturbance has selected the internal oscillator, this time is up to eight times as long.
const PERIOD: Duration = millis(100);

/// CAN_MCR: NART, and the other bits that select a mode or function: INRQ, SLEEP, TXFP, RFLM, AWUM, ABOM, TTCM, RESET.
const NART: u32 = 1 << 4;
const OTHERS: u32 = 0x80EF;
/// CAN_MCR: TXFP, transmit mailboxes in the order of the requests; INRQ.
const TXFP: u32 = 1 << 2;
const INRQ: u32 = 1 << 0;
/// CAN_MSR: INAK and SLAK.
const OFF_THE_BUS: u32 = 0b11;
/// CAN_IER: TMEIE and FMPIE0, and all bits that are not reserved.
pub(super) const INTERRUPTS: u32 = 0b11;
const ALL_INTERRUPTS: u32 = 0x3_8F7F;

/// The mode that the controller must have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    Initialization,
    /// It waits for 11 recessive bits.
    Joining,
    Normal,
}

/// A number for a sequence of words: 0 if all are 0. A change of one of them changes it.
#[derive(Default)]
pub(super) struct Digest(u32);

impl Digest {
    /// Adds a word.
    pub(super) fn add(&mut self, word: u32) {
        // The step of FNV-1a.
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    /// The number.
    pub(super) fn value(&self) -> u32 {
        self.0
    }
}

impl Bus {
    /// Compares the configuration of board and controller with the values that were set, and restores it if it has changed. Call it often,
    /// while the SPI is idle. Returns false if it is not time for it.
    pub fn inspect(&mut self, now: Instant) -> bool {
        if !clock::is_due(now, self.inspection, PERIOD) {
            return false;
        }
        self.inspection = after(now, PERIOD);
        self.compare();
        true
    }

    fn compare(&mut self) {
        let restored = board::restore();
        unmask_interrupts();
        board::set_up_debugging();
        self.setup.verify();
        if self.setup.is_none() {
            return;
        }
        // The other steps of a change have a limit, and the last one sets the controller.
        let mode = match self.change {
            Change::Done => Mode::Normal,
            Change::Joining { .. } => Mode::Joining,
            Change::Resetting { .. } | Change::Leaving { .. } => return,
        };
        board::connect_transmitter(!self.setup.is_listening());
        self.pulses.restore();
        // A value that the controller does not take is no disturbance.
        if self.difference(mode) == self.untaken {
            if restored {
                warn!("a disturbed register is restored");
            }
            return;
        }
        if self.registers().esr().read().boff().bit_is_set() {
            // The disturbance can be its cause, for example a wrong bit rate, and the node does not end it without a recovery.
            error!("restart: bus-off with a disturbed CAN controller");
            board::restart();
        }
        warn!("the disturbed CAN controller is restored");
        transmit::abort_all();
        // RCC resets the controller: a disturbance can have set silent mode, in which the transmit output can stay dominant until such a
        // reset.
        self.reset(true);
    }

    /// The mode in which the node must take part in the bus. None while it cannot: the controller is not on the bus or in bus-off, or the bus
    /// takes no frame. This is from the registers, because a disturbance can have changed the variables.
    pub fn serving(&mut self) -> Option<BusMode> {
        let listens = self.is_listening();
        let registers = self.registers();
        let is_away = registers.msr().read().bits() & OFF_THE_BUS != 0;
        if is_away || self.setup.is_none() {
            return None;
        }
        if listens {
            return Some(BusMode::Listen);
        }
        let is_off = self.registers().esr().read().boff().bit_is_set();
        (!is_off && transmit::is_idle()).then_some(BusMode::Normal)
    }

    /// A number that changes if the bit timing or the filters that were set last change.
    pub fn check_value(&self) -> u32 {
        self.setup.check_value()
    }

    /// How the controller differs from the configuration that was set, and from its mode; 0 if it does not.
    pub(super) fn difference(&mut self, mode: Mode) -> u32 {
        let registers = &self.can.instance().0;
        // An interrupt can change NART.
        let (single, control) = critical_section::with(|_| {
            let control = registers.mcr().read().bits() & (OTHERS | NART);
            (transmit::is_single_attempt(), control)
        });
        let nart = if single { NART } else { 0 };
        let (inrq, acknowledged) = match mode {
            Mode::Initialization => (INRQ, 0),
            Mode::Joining => (0, 0),
            Mode::Normal => (0, OFF_THE_BUS),
        };
        let mut digest = Digest::default();
        digest.add(control ^ (TXFP | nart | inrq));
        digest.add(registers.msr().read().bits() & acknowledged);
        digest.add(registers.ier().read().bits() & ALL_INTERRUPTS ^ INTERRUPTS);
        self.setup.compare(registers, &mut digest);
        digest.value()
    }
}
