//! The transmit mailboxes as the [`Controller`] of the driver, with single attempts.

use super::transmit::{self, End};
use super::{phase, receive, set_phase};
use crate::bit_timing::btr;
use crate::board::CanPeripheral;
use crate::clock;
use plumbline::can::{BitRate, Frame};
use plumbline::node::driver::{Controller, Phase};
use plumbline::time::Instant;

/// The three transmit mailboxes of bxCAN.
pub struct Mailboxes {
    /// The frame in a mailbox for which the controller makes a single attempt.
    once: Option<Frame>,
}

impl Mailboxes {
    /// No frame has a single attempt.
    pub const EMPTY: Self = Self { once: None };

    /// Handles the transmit interrupt. Returns true if the frame for which the controller made a single attempt ended in a bit error.
    pub fn complete(&mut self) -> bool {
        let Some(frame) = &self.once else {
            transmit::acknowledge();
            return false;
        };
        let end = transmit::end();
        transmit::acknowledge();
        // In another phase, the frame was aborted.
        if end == End::Again && phase() == Phase::Normal {
            transmit::put(frame);
            return false;
        }
        self.once = None;
        transmit::set_single_attempt(false);
        end == End::Failed
    }
}

impl Controller for Mailboxes {
    #[inline(always)]
    fn now(&self) -> Instant {
        clock::now()
    }

    #[inline(always)]
    fn phase(&self) -> Phase {
        phase()
    }

    fn pause(&mut self, phase: Phase) {
        set_phase(phase);
    }

    fn is_at(&self, rate: BitRate) -> bool {
        // SAFETY: reads registers without effect on them.
        let registers = unsafe { CanPeripheral::steal() };
        let control = registers.mcr().read();
        let status = registers.msr().read();
        // Not in initialization or sleep mode, and neither is requested.
        let runs = control.inrq().bit_is_clear()
            && control.reset().bit_is_clear()
            && status.inak().bit_is_clear()
            && status.slak().bit_is_clear();
        // In listen mode, the silent bit is set.
        let is_same = registers.btr().read().bits() == btr(rate);
        runs && is_same && registers.esr().read().boff().bit_is_clear()
    }

    #[inline(always)]
    fn has_room(&self) -> bool {
        transmit::has_room()
    }

    #[inline(always)]
    fn is_idle(&self) -> bool {
        transmit::is_idle()
    }

    #[inline(always)]
    fn put(&mut self, frame: &Frame, once: bool) {
        if once || self.once.is_some() {
            transmit::set_single_attempt(once);
            self.once = once.then_some(*frame);
        }
        transmit::put(frame);
    }

    #[inline(always)]
    fn abort(&mut self) {
        transmit::abort_all();
    }

    fn lose(&mut self) {
        receive::lose();
    }
}
