//! The transmit mailboxes.
//!
//! The controller sends the mailboxes in the order of the requests (MCR.TXFP), which is the order of the node's queue. At most two
//! of the three mailboxes are used: the second follows the first without a gap, and a newer cyclic value can replace an older one
//! in the queue that does not wait in a mailbox yet.

use crate::board::CanPeripheral;
use core::sync::atomic::{AtomicBool, Ordering};
use embedded_can::Id;
use plumbline::can::Frame;

/// TIR: request to send.
const REQUEST: u32 = 1 << 0;
/// TIR: remote frame.
const REMOTE: u32 = 1 << 1;
/// TIR: 29-bit identifier.
const EXTENDED: u32 = 1 << 2;

/// The registers of the mailboxes.
fn registers() -> CanPeripheral {
    // SAFETY: only this module uses the registers of the mailboxes.
    unsafe { CanPeripheral::steal() }
}

/// ESR.LEC: no acknowledge.
const NO_ACKNOWLEDGE: u8 = 3;

/// The end of a frame that the controller does not repeat.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// It was sent, or aborted.
    Done,
    /// It lost the arbitration, or nobody acknowledged it: it must be sent again at once.
    Again,
    /// It ended in another error.
    Failed,
}

/// The controller makes a single attempt.
static SINGLE: AtomicBool = AtomicBool::new(false);

/// Whether the controller makes a single attempt to send a frame.
pub(super) fn is_single_attempt() -> bool {
    SINGLE.load(Ordering::Relaxed)
}

/// Sets whether the controller makes a single attempt to send a frame (MCR.NART).
pub fn set_single_attempt(single: bool) {
    SINGLE.store(single, Ordering::Relaxed);
    registers().mcr().modify(|_, w| w.nart().bit(single));
}

/// The end of the frame for which the controller made a single attempt, before [`acknowledge`].
pub fn end() -> End {
    let status = registers().tsr().read();
    if status.terr0().bit_is_set() || status.terr1().bit_is_set() || status.terr2().bit_is_set() {
        if registers().esr().read().lec().bits() == NO_ACKNOWLEDGE {
            return End::Again;
        }
        return End::Failed;
    }
    if status.alst0().bit_is_set() || status.alst1().bit_is_set() || status.alst2().bit_is_set() {
        return End::Again;
    }
    End::Done
}

/// Clears the request of the transmit interrupt.
pub fn acknowledge() {
    // Writing 1 clears the request-completed flags, and writing 0 to the other bits has no effect.
    registers().tsr().write(|w| {
        w.rqcp0().set_bit();
        w.rqcp1().set_bit();
        w.rqcp2().set_bit()
    });
}

/// Aborts the frames in the mailboxes. A frame on the bus is not aborted if its transmission succeeds.
pub fn abort_all() {
    registers().tsr().write(|w| {
        w.abrq0().set_bit();
        w.abrq1().set_bit();
        w.abrq2().set_bit()
    });
}

/// The empty mailboxes, one bit for each.
fn empty(registers: &CanPeripheral) -> u32 {
    registers.tsr().read().bits() >> 26 & 0b111
}

/// True if a frame can be put into a mailbox: at least two are empty.
pub fn has_room() -> bool {
    let empty = empty(&registers());
    empty & empty.wrapping_sub(1) != 0
}

/// True if all mailboxes are empty.
pub fn is_idle() -> bool {
    empty(&registers()) == 0b111
}

/// Puts a frame into an empty mailbox.
pub fn put(frame: &Frame) {
    let registers = registers();
    // The lowest empty mailbox. CODE has its number, but some clones of the STM32F103 always return 0.
    let number = empty(&registers).trailing_zeros();
    let Some(mailbox) = registers.tx_iter().nth(number as usize) else {
        return;
    };
    let identifier = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let [low, high] = frame.data_words();
    // SAFETY: all values of these registers are valid.
    unsafe {
        mailbox.tdtr().write(|w| w.bits(frame.dlc() as u32));
        mailbox.tdlr().write(|w| w.bits(low));
        mailbox.tdhr().write(|w| w.bits(high));
        mailbox
            .tir()
            .write(|w| w.bits(identifier | remote | REQUEST));
    }
}
