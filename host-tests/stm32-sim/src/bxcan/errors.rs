//! The error status CAN_ESR, the interrupt flags of CAN_MSR, CAN_IER and the four interrupt lines (RM0008, 24.7.6, 24.8 and
//! 24.9.2).
//!
//! CAN_ESR:
//!
//! | Bits | Field | Content |
//! |---|---|---|
//! | 31..24, 23..16 | REC, TEC | receive and transmit error counters |
//! | 6..4 | LEC | last error code: 0 after a valid frame, 7 when software has written it |
//! | 2, 1, 0 | BOFF, EPVF, EWGF | bus-off, error passive, warning |

use super::receive::{FULL, OVERRUN, PENDING};
use can_wire::protocol::{ErrorCode, Protocol};
use plumbline::node::BusState;

/// Bit n of CAN_ESR's three flags is enabled by bit 8 + n of CAN_IER (EWGIE, EPVIE, BOFIE).
const FLAG_ENABLES: u32 = 8;
const LAST_ERROR_ENABLE: u32 = 1 << 11;
const ERROR_ENABLE: u32 = 1 << 15;
const WAKE_UP_ENABLE: u32 = 1 << 16;
const SLEEP_ENABLE: u32 = 1 << 17;
const IMPLEMENTED: u32 = 0x0003_8F7F;

/// CAN_MSR.ERRI, WKUI and SLAKI.
const ERROR: u32 = 1 << 2;
const WAKE_UP: u32 = 1 << 3;
const SLEEP: u32 = 1 << 4;

const WARNING_LIMIT: u16 = 96;
const PASSIVE_LIMIT: u16 = 128;

/// CAN_ESR.LEC written by software.
const SEEN: u32 = 7;

/// The error state of the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Confinement {
    pub(super) state: BusState,
    pub(super) transmit_errors: u16,
    pub(super) receive_errors: u16,
}

impl From<&Protocol> for Confinement {
    fn from(protocol: &Protocol) -> Self {
        Self {
            state: protocol.state(),
            transmit_errors: protocol.transmit_errors(),
            receive_errors: protocol.receive_errors(),
        }
    }
}

impl Confinement {
    /// CAN_ESR.BOFF, EPVF and EWGF.
    fn flags(self) -> u32 {
        let highest = self.transmit_errors.max(self.receive_errors);
        let off = self.state == BusState::BusOff;
        u32::from(highest >= WARNING_LIMIT)
            | u32::from(highest >= PASSIVE_LIMIT) << 1
            | u32::from(off) << 2
    }
}

#[derive(Debug, Default)]
pub(super) struct Status {
    enabled: u32,
    interrupts: u32,
    last_error: u32,
    flags: u32,
    counters: u32,
    /// Not in sleep mode, which is the state after a reset.
    awake: bool,
}

impl Status {
    /// CAN_IER.
    pub(super) fn enabled(&self) -> u32 {
        self.enabled
    }

    pub(super) fn enable(&mut self, value: u32) {
        self.enabled = value & IMPLEMENTED;
    }

    /// CAN_ESR.
    pub(super) fn error_status(&self) -> u32 {
        self.counters | self.last_error << 4 | self.flags
    }

    /// Writes CAN_ESR, of which only LEC is writable; false when software must not write this value.
    pub(super) fn write_error_status(&mut self, value: u32) -> bool {
        self.last_error = value >> 4 & 7;
        matches!(self.last_error, 0 | SEEN)
    }

    /// ERRI, WKUI and SLAKI at their bit positions in CAN_MSR.
    pub(super) fn interrupts(&self) -> u32 {
        self.interrupts
    }

    /// Clears those whose bit is 1 in `value`.
    pub(super) fn clear_interrupts(&mut self, value: u32) {
        self.interrupts &= !value;
    }

    /// A frame was sent or received successfully.
    pub(super) fn succeeded(&mut self) {
        self.last_error = 0;
    }

    pub(super) fn failed(&mut self, code: ErrorCode) {
        self.last_error = code as u32;
        if self.enabled & LAST_ERROR_ENABLE != 0 {
            self.interrupts |= ERROR;
        }
    }

    /// Updates the error state. A flag that becomes set sets ERRI, if enabled.
    pub(super) fn follow(&mut self, confinement: Confinement) {
        let byte = |counter: u16| u32::from(counter.min(255));
        self.counters =
            byte(confinement.receive_errors) << 24 | byte(confinement.transmit_errors) << 16;
        let flags = confinement.flags();
        let new = flags & !self.flags;
        self.flags = flags;
        if new & self.enabled >> FLAG_ENABLES != 0 {
            self.interrupts |= ERROR;
        }
    }

    /// Updates sleep mode: entering it sets SLAKI, if enabled; leaving it clears SLAKI.
    pub(super) fn sleeps(&mut self, asleep: bool) {
        let entered = asleep && self.awake;
        self.awake = !asleep;
        if entered && self.enabled & SLEEP_ENABLE != 0 {
            self.interrupts |= SLEEP;
        }
        if !asleep {
            self.interrupts &= !SLEEP;
        }
    }

    /// A start of frame was detected in sleep mode.
    pub(super) fn disturbed_in_sleep(&mut self) {
        self.interrupts |= WAKE_UP;
    }

    /// The interrupt lines: transmit (19), FIFO 0 (20), FIFO 1 (21), status change and error (22). `completed`: a transmit
    /// request is completed; `fifos`: CAN_RF0R and CAN_RF1R.
    pub(super) fn lines(&self, completed: bool, fifos: [u32; 2]) -> [bool; 4] {
        // FMPIE, FFIE and FOVIE of FIFO 0 are bits 1 to 3, those of FIFO 1 are bits 4 to 6.
        let fifo = |number: usize| {
            let enabled = self.enabled >> (1 + 3 * number);
            [PENDING, FULL, OVERRUN]
                .iter()
                .enumerate()
                .any(|(bit, condition)| enabled >> bit & 1 != 0 && fifos[number] & condition != 0)
        };
        let status = [
            (ERROR_ENABLE, ERROR),
            (WAKE_UP_ENABLE, WAKE_UP),
            (SLEEP_ENABLE, SLEEP),
        ]
        .iter()
        .any(|(enable, flag)| self.enabled & enable != 0 && self.interrupts & flag != 0);
        [self.enabled & 1 != 0 && completed, fifo(0), fifo(1), status]
    }
}

#[cfg(test)]
mod tests;
