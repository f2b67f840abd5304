//! The CAN controller of the bootloader: polled, with one filter and one mailbox.

use crate::bit_timing::btr;
use crate::board::{CanPeripheral, connect_transmitter, own_filters, reset_can};
use plumbline::can::{BitRate, CanId};

// CAN_MCR.
const INRQ: u32 = 1 << 0;
const TXFP: u32 = 1 << 2;
const ABOM: u32 = 1 << 6;
/// CAN_BTR: silent mode.
const SILENT: u32 = 1 << 31;
/// CAN_TSR: mailbox 0 is empty.
const TME0: u32 = 1 << 26;
/// CAN_TIxR and CAN_RIxR: an identifier of 29 bits.
const IDE: u32 = 1 << 2;
/// CAN_RF0R: frames in the FIFO, and its release.
const FMP: u32 = 0b11;
const RFOM: u32 = 1 << 5;

/// A data frame with eight bytes.
pub struct Request {
    pub id: CanId,
    pub data: [u8; 8],
}

/// The controller.
pub struct Can(pub CanPeripheral);

impl Can {
    /// Joins the bus and receives the frames with this identifier.
    pub fn join(&mut self, rate: BitRate, request: Option<CanId>) {
        self.begin(btr(rate), request);
        connect_transmitter(true);
    }

    /// Listens to all frames without a signal of its own.
    pub fn listen(&mut self, rate: BitRate) {
        self.begin(btr(rate) | SILENT, None);
    }

    /// The transmit pin is recessive until the controller has left its reset.
    fn begin(&mut self, timing: u32, request: Option<CanId>) {
        connect_transmitter(false);
        reset_can();
        let can = &self.0;
        // SAFETY: valid values of these registers. If the controller acknowledges nothing, the watchdog ends the wait.
        unsafe {
            can.mcr().write(|w| w.bits(INRQ));
            while can.msr().read().inak().bit_is_clear() {}
            can.btr().write(|w| w.bits(timing));
            can.fmr()
                .modify(|fmr, w| w.bits(own_filters(fmr.bits())).finit().set_bit());
            can.fs1r().write(|w| w.bits(1));
            can.fb(0).fr1().write(|w| w.bits(request.map_or(0, place)));
            can.fb(0).fr2().write(|w| w.bits(request.map_or(0, |_| !1)));
            can.fa1r().write(|w| w.bits(1));
            can.fmr().modify(|_, w| w.finit().clear_bit());
            // Leaves bus-off by itself.
            can.mcr().write(|w| w.bits(TXFP | ABOM));
        }
    }

    /// Whether a frame waits.
    pub fn has_received(&self) -> bool {
        self.0.rfr(0).read().bits() & FMP != 0
    }

    /// The next frame with eight bytes.
    pub fn receive(&mut self) -> Option<Request> {
        if !self.has_received() {
            return None;
        }
        let can = &self.0;
        let mailbox = can.rx(0);
        let (head, length) = (
            mailbox.rir().read().bits(),
            mailbox.rdtr().read().bits() & 0xF,
        );
        let words = [mailbox.rdlr().read().bits(), mailbox.rdhr().read().bits()];
        // SAFETY: a valid value of the register.
        can.rfr(0).write(|w| unsafe { w.bits(RFOM) });
        let id = if head & IDE != 0 {
            CanId::extended(head >> 3)
        } else {
            CanId::standard((head >> 21) as u16)
        };
        let [low, high] = words.map(u64::from);
        let data = (high << 32 | low).to_le_bytes();
        (length == 8).then_some(Request { id, data })
    }

    /// Sends a frame. If the one before it waits for a free bus, it is not sent: the client repeats its request.
    pub fn send(&mut self, id: CanId, data: [u8; 8], length: u32) {
        if !self.is_idle() {
            return;
        }
        let mailbox = self.0.tx(0);
        let data = u64::from_le_bytes(data);
        // SAFETY: valid values of these registers.
        unsafe {
            mailbox.tdtr().write(|w| w.bits(length));
            mailbox.tdlr().write(|w| w.bits(data as u32));
            mailbox.tdhr().write(|w| w.bits((data >> 32) as u32));
            mailbox.tir().write(|w| w.bits(place(id) | 1));
        }
    }

    /// The message at the start.
    pub fn send_boot_up(&mut self, id: CanId) {
        match id.bits() {
            0x701..=0x77F => self.send(id, [0; 8], 1),
            _ => self.send(id, *b"\x60BOOT\0\0\0", 5),
        }
    }

    /// Whether nothing waits to be sent.
    pub fn is_idle(&self) -> bool {
        self.0.tsr().read().bits() & TME0 != 0
    }
}

/// The identifier in CAN_TIxR and in a filter.
fn place(id: CanId) -> u32 {
    let bits = id.bits();
    if bits >> 31 != 0 {
        bits << 3 | IDE
    } else {
        bits << 21
    }
}
