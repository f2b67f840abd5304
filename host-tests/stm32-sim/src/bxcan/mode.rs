//! The modes of operation and CAN_MCR (RM0008, 24.4 and 24.9.2).
//!
//! | Bits | Field | Content |
//! |---|---|---|
//! | 16 | DBF | debug freeze: ignored here |
//! | 15 | RESET | back to the state after a reset |
//! | 7 | TTCM | time-triggered communication: not modelled |
//! | 6 | ABOM | automatic bus-off recovery |
//! | 5 | AWUM | automatic wakeup by bus activity |
//! | 4 | NART | no automatic retransmission |
//! | 3 | RFLM | a full FIFO is locked |
//! | 2 | TXFP | transmit mailboxes in the order of the requests |
//! | 1, 0 | SLEEP, INRQ | requests: sleep mode, initialization mode |
//!
//! A mode is requested in CAN_MCR and acknowledged in CAN_MSR (SLAK, INAK). The controller leaves the bus at the end of the
//! current frame, and joins it after 11 recessive bits; until then the previous mode is acknowledged. A sleeping controller also
//! enters initialization mode while SLEEP is set; then both modes are acknowledged (drivers of ST, Zephyr and candleLight_fw).

use super::transmit::Order;

/// CAN_MCR.RESET.
pub(super) const RESET: u32 = 1 << 15;
/// CAN_MCR.TTCM.
pub(super) const TIME_TRIGGERED: u32 = 1 << 7;
const AUTOMATIC_RECOVERY: u32 = 1 << 6;
const AUTOMATIC_WAKE_UP: u32 = 1 << 5;
const ONCE: u32 = 1 << 4;
const LOCKED_FIFO: u32 = 1 << 3;
const REQUEST_ORDER: u32 = 1 << 2;
const SLEEP: u32 = 1 << 1;
const INITIALIZATION: u32 = 1;
const IMPLEMENTED: u32 = 0x0001_00FF;

/// DBF and SLEEP.
const AFTER_RESET: u32 = 0x0001_0002;

/// The recessive bits after which the controller joins the bus.
const SYNCHRONIZATION: u8 = 11;

/// CAN_MSR.INAK and SLAK.
const INITIALIZATION_ACKNOWLEDGED: u32 = 1;
const SLEEP_ACKNOWLEDGED: u32 = 1 << 1;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Mode {
    /// CAN_MCR.RESET is set, or sleep mode is not acknowledged yet after it.
    Resetting,
    Sleep,
    Initialization,
    Normal,
}

/// A pending change of mode.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Change {
    /// Start to wait for 11 recessive bits.
    Join,
    /// Leave the bus, if joined, and acknowledge this mode.
    Acknowledge(Mode),
}

/// CAN_MCR, and the mode that follows from it.
#[derive(Debug)]
pub(super) struct Control {
    bits: u32,
    /// The mode that CAN_MSR acknowledges.
    mode: Mode,
    /// Initialization mode was entered from sleep mode, and SLEEP was not cleared since then.
    from_sleep: bool,
    /// Waits for 11 recessive bits.
    joining: bool,
    /// Recessive bits counted in bus-off.
    recessive: u8,
}

impl Default for Control {
    fn default() -> Self {
        Self {
            bits: AFTER_RESET,
            mode: Mode::Sleep,
            from_sleep: false,
            joining: false,
            recessive: 0,
        }
    }
}

impl Control {
    /// The value of CAN_MCR.
    pub(super) fn value(&self) -> u32 {
        self.bits
    }

    pub(super) fn write(&mut self, value: u32) {
        self.bits = value & IMPLEMENTED;
        self.from_sleep &= self.has(SLEEP);
    }

    /// CAN_MCR.RESET is written: CAN_MCR gets its reset value, and the controller is off the bus.
    pub(super) fn reset(&mut self) {
        *self = Self {
            mode: Mode::Resetting,
            ..Self::default()
        };
    }

    /// INAK and SLAK at their bit positions in CAN_MSR.
    pub(super) fn acknowledged(&self) -> u32 {
        match self.mode {
            Mode::Resetting => 0,
            Mode::Initialization if self.from_sleep && self.has(SLEEP) => {
                INITIALIZATION_ACKNOWLEDGED | SLEEP_ACKNOWLEDGED
            }
            Mode::Sleep => SLEEP_ACKNOWLEDGED,
            Mode::Initialization => INITIALIZATION_ACKNOWLEDGED,
            Mode::Normal => 0,
        }
    }

    pub(super) fn mode(&self) -> Mode {
        self.mode
    }

    /// True in normal mode and while waiting for 11 recessive bits.
    pub(super) fn is_on(&self) -> bool {
        self.joining || self.mode == Mode::Normal
    }

    /// True in initialization mode, if no other mode is requested.
    pub(super) fn is_initializing(&self) -> bool {
        self.mode == Mode::Initialization && !self.joining
    }

    /// True when a frame may be started: in normal mode, if no other mode is requested.
    pub(super) fn may_start(&self) -> bool {
        self.mode == Mode::Normal && self.requested() == Mode::Normal
    }

    pub(super) fn order(&self) -> Order {
        if self.has(REQUEST_ORDER) {
            Order::Request
        } else {
            Order::Identifier
        }
    }

    pub(super) fn retransmits(&self) -> bool {
        !self.has(ONCE)
    }

    pub(super) fn locks_fifo(&self) -> bool {
        self.has(LOCKED_FIFO)
    }

    pub(super) fn recovers(&self) -> bool {
        self.has(AUTOMATIC_RECOVERY)
    }

    /// The change of mode that is due. `busy`: there is a frame on the bus.
    pub(super) fn due(&self, busy: bool) -> Option<Change> {
        let requested = self.requested();
        match requested {
            Mode::Normal if !self.is_on() => Some(Change::Join),
            Mode::Normal => None,
            // Not synchronized to the bus yet, so there is no frame to wait for.
            _ if self.joining => Some(Change::Acknowledge(requested)),
            _ if self.mode == requested || (self.mode == Mode::Normal && busy) => None,
            _ => Some(Change::Acknowledge(requested)),
        }
    }

    /// Waiting for 11 recessive bits has begun.
    pub(super) fn joining(&mut self) {
        self.joining = true;
        self.recessive = 0;
    }

    /// Processes a bit while waiting for them.
    pub(super) fn listen(&mut self, dominant: bool) {
        self.recessive = if dominant { 0 } else { self.recessive + 1 };
        if self.recessive == SYNCHRONIZATION {
            self.joined();
            self.recessive = 0;
        }
    }

    /// The controller has seen 11 recessive bits: it takes part in the traffic.
    pub(super) fn joined(&mut self) {
        if self.joining {
            self.enter(Mode::Normal);
        }
    }

    /// Changes the mode, and acknowledges it in CAN_MSR.
    pub(super) fn enter(&mut self, mode: Mode) {
        self.joining = false;
        self.from_sleep =
            mode == Mode::Initialization && self.mode == Mode::Sleep && self.has(SLEEP);
        self.mode = mode;
    }

    /// A start of frame was detected in sleep mode.
    pub(super) fn wake_up(&mut self) {
        if self.has(AUTOMATIC_WAKE_UP) {
            self.bits &= !SLEEP;
        }
    }

    /// The mode that CAN_MCR requests.
    pub(super) fn requested(&self) -> Mode {
        if self.has(INITIALIZATION) {
            Mode::Initialization
        } else if self.has(SLEEP) {
            Mode::Sleep
        } else {
            Mode::Normal
        }
    }

    fn has(&self, bit: u32) -> bool {
        self.bits & bit != 0
    }
}

#[cfg(test)]
mod tests;
