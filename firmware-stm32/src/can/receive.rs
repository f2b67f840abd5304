//! The receive FIFO.
//!
//! It is read without the bxcan crate: a classic frame can have a data length code of 9 to 15, which means 8 bytes. The crate would
//! index its data with it and panic.

use crate::board::CanPeripheral;
use core::sync::atomic::{AtomicBool, Ordering};
use plumbline::can::{Frame, extended, standard};

/// Frames were lost, because the FIFO of the controller was full.
static OVERRUN: AtomicBool = AtomicBool::new(false);

/// Takes the next frame out of FIFO 0; None if it is empty. The frame is None if it is not a valid one.
pub fn next() -> Option<Option<Frame>> {
    // SAFETY: no other code uses the registers of the receive FIFO.
    let registers = unsafe { CanPeripheral::steal() };
    let fifo = registers.rfr(0);
    // While RFOM is set, for a few clock cycles, the mailbox still contains the last frame.
    let status = loop {
        let status = fifo.read();
        if status.rfom().bit_is_clear() {
            break status;
        }
    };
    if status.fovr().bit_is_set() {
        fifo.write(|w| w.fovr().clear());
        OVERRUN.store(true, Ordering::Relaxed);
    }
    if status.fmp().bits() == 0 {
        return None;
    }
    let frame = head(&registers);
    fifo.write(|w| w.rfom().release());
    Some(frame)
}

/// The frame at the head of FIFO 0.
fn head(registers: &CanPeripheral) -> Option<Frame> {
    let mailbox = registers.rx(0);
    let identifier = mailbox.rir().read();
    let id = if identifier.ide().is_extended() {
        extended(identifier.bits() >> 3)
    } else {
        standard((identifier.bits() >> 21) as u16)
    };
    // A data length code of 9 to 15 means 8 bytes.
    let length = mailbox.rdtr().read().dlc().bits().min(8);
    if identifier.rtr().is_remote() {
        return Frame::remote(id, length.into());
    }
    let low = mailbox.rdlr().read().bits();
    let high = mailbox.rdhr().read().bits();
    let data = u64::from(high) << 32 | u64::from(low);
    Some(Frame::of(id, data.to_le_bytes(), length))
}

/// Whether frames were lost since the last call.
pub(super) fn overrun() -> bool {
    let lost = OVERRUN.load(Ordering::Relaxed);
    if lost {
        OVERRUN.store(false, Ordering::Relaxed);
    }
    lost
}
