//! The receive interrupt: moves frames from FIFO 0 of the controller into the queue.
//!
//! It uses the registers directly: a classic frame can have a data length code of 9 to 15, which means 8 bytes. The bxcan crate
//! would index its data with it and panic.

use crate::board::CanPeripheral;
use crate::sleep;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use heapless::spsc::Producer;
use plumbline::can::{Frame, extended, standard};

/// The receiving part of the driver, used by the receive interrupt.
struct Receiver {
    registers: CanPeripheral,
    queue: Producer<'static, Frame>,
}

static RECEIVER: Mutex<RefCell<Option<Receiver>>> = Mutex::new(RefCell::new(None));

/// Frames were lost, because the FIFO of the controller or the queue was full.
static OVERRUN: AtomicBool = AtomicBool::new(false);

impl Receiver {
    /// Empties receive FIFO 0 into the queue.
    fn fetch(&mut self) {
        let fifo = self.registers.rfr(0);
        loop {
            let status = fifo.read();
            if status.fovr().bit_is_set() {
                fifo.write(|w| w.fovr().clear());
                OVERRUN.store(true, Ordering::Relaxed);
            }
            if status.rfom().bit_is_set() {
                // The mailbox still contains the last frame, for a few clock cycles.
                continue;
            }
            if status.fmp().bits() == 0 {
                return;
            }
            let frame = read_fifo(&self.registers);
            fifo.write(|w| w.rfom().release());
            let queued = frame.is_some_and(|frame| self.queue.enqueue(frame).is_ok());
            if !queued {
                OVERRUN.store(true, Ordering::Relaxed);
            }
        }
    }
}

/// The frame at the head of receive FIFO 0.
fn read_fifo(registers: &CanPeripheral) -> Option<Frame> {
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

/// Starts to move received frames into `queue`.
pub(super) fn into(queue: Producer<'static, Frame>) {
    let receiver = Receiver {
        // SAFETY: the receiver uses only the registers of the receive FIFO, and no other code uses them.
        registers: unsafe { CanPeripheral::steal() },
        queue,
    };
    critical_section::with(|cs| RECEIVER.replace(cs, Some(receiver)));
}

/// Whether frames were lost since the last call.
pub(super) fn overrun() -> bool {
    let lost = OVERRUN.load(Ordering::Relaxed);
    if lost {
        OVERRUN.store(false, Ordering::Relaxed);
    }
    lost
}

/// The receive interrupt.
pub fn on_received() {
    critical_section::with(|cs| {
        if let Some(receiver) = RECEIVER.borrow_ref_mut(cs).as_mut() {
            receiver.fetch();
        }
    });
    sleep::wake();
}
