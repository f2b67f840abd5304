//! The transmit mailboxes.
//!
//! The controller sends the mailboxes in the order of the requests (MCR.TXFP), which is the order of the node's queue. At most two
//! of the three mailboxes are used: the second follows the first without a gap, and a newer cyclic value can replace an older one
//! in the queue that does not wait in a mailbox yet.
//!
//! A reset of the controller empties its mailboxes. If it only restores the controller, the frames are [held](hold) meanwhile.

use crate::board::CanPeripheral;
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use critical_section::{CriticalSection, Mutex};
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

/// The registers of a mailbox: TIR, TDTR, TDLR, TDHR. TIR is 0 if there is no frame.
type Words = [u32; 4];

/// The frames that are held, in their order.
static HELD: Mutex<Cell<[Words; 2]>> = Mutex::new(Cell::new([[0; 4]; 2]));

/// Frames are held, so no frame can be put into a mailbox.
static IS_HOLDING: AtomicBool = AtomicBool::new(false);

/// The mailbox of the newest frame.
static NEWEST: AtomicUsize = AtomicUsize::new(0);

/// Takes the frames out of the mailboxes before a reset of the controller, until [`release`].
pub fn hold(cs: CriticalSection<'_>) {
    IS_HOLDING.store(true, Ordering::Relaxed);
    let registers = registers();
    let empty = empty(&registers);
    let newest = NEWEST.load(Ordering::Relaxed);
    let mut held = HELD.borrow(cs).get();
    let [first, second] = &mut held;
    for (number, mailbox) in registers.tx_iter().enumerate() {
        let identifier = mailbox.tir().read().bits();
        if empty >> number & 1 == 0 && identifier & REQUEST != 0 {
            let place = if number == newest {
                &mut *second
            } else {
                &mut *first
            };
            *place = [
                identifier,
                mailbox.tdtr().read().bits(),
                mailbox.tdlr().read().bits(),
                mailbox.tdhr().read().bits(),
            ];
        }
    }
    HELD.borrow(cs).set(held);
}

/// Puts the frames that were held into mailboxes again.
pub fn release() {
    if !IS_HOLDING.load(Ordering::Relaxed) {
        return;
    }
    critical_section::with(|cs| {
        for words in HELD.borrow(cs).take() {
            if words != [0; 4] {
                put_words(words);
            }
        }
        IS_HOLDING.store(false, Ordering::Relaxed);
    });
}

/// Whether frames are held.
fn has_held() -> bool {
    IS_HOLDING.load(Ordering::Relaxed)
        && critical_section::with(|cs| HELD.borrow(cs).get() != [[0; 4]; 2])
}

/// Aborts the frames in the mailboxes, and those that are held. A frame on the bus is not aborted if its transmission succeeds.
pub fn abort_all() {
    critical_section::with(|cs| HELD.borrow(cs).take());
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
    empty & empty.wrapping_sub(1) != 0 && !IS_HOLDING.load(Ordering::Relaxed)
}

/// True if all mailboxes are empty.
pub fn is_idle() -> bool {
    empty(&registers()) == 0b111 && !has_held()
}

/// Puts a frame into an empty mailbox.
pub fn put(frame: &Frame) {
    let identifier = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let [low, high] = frame.data_words();
    put_words([identifier | remote | REQUEST, frame.dlc() as u32, low, high]);
}

fn put_words([identifier, length, low, high]: Words) {
    let registers = registers();
    // The lowest empty mailbox. CODE has its number, but some clones of the STM32F103 always return 0.
    let number = empty(&registers).trailing_zeros() as usize;
    let Some(mailbox) = registers.tx_iter().nth(number) else {
        return;
    };
    NEWEST.store(number, Ordering::Relaxed);
    // SAFETY: all values of these registers are valid.
    unsafe {
        mailbox.tdtr().write(|w| w.bits(length));
        mailbox.tdlr().write(|w| w.bits(low));
        mailbox.tdhr().write(|w| w.bits(high));
        mailbox.tir().write(|w| w.bits(identifier));
    }
}
