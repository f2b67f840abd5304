//! The configuration that the controller gets: bit timing and filters, with a check value. It is kept to restore the controller, so a bit of
//! it that a disturbance inverts would get into the controller. The firmware restarts instead.

use super::filters::{self, Banks};
use super::inspection::Digest;
use crate::bit_timing::btr;
use crate::board::{self, CanPeripheral};
use plumbline::can::BitRate;
use plumbline::node::BusMode;
use plumbline::node::driver::Filters;

/// CAN_BTR: silent mode.
const SILENT: u32 = 1 << 31;

/// The configuration of the controller.
pub(super) struct Setup {
    /// The value of CAN_BTR; 0 before the first configuration.
    timing: u32,
    banks: Banks,
    check: u32,
}

impl Setup {
    /// Before the first configuration.
    pub(super) const NONE: Self = Self {
        timing: 0,
        banks: Banks::NONE,
        check: 0,
    };

    /// The configuration of this mode, bit rate and filters.
    pub(super) fn of(mode: BusMode, rate: BitRate, filters: Filters<'_>) -> Self {
        let silent = if mode == BusMode::Listen { SILENT } else { 0 };
        Self::with(btr(rate) | silent, Banks::of(mode, filters))
    }

    fn with(timing: u32, banks: Banks) -> Self {
        let check = digest(timing, &banks);
        Self {
            timing,
            banks,
            check,
        }
    }

    pub(super) fn check_value(&self) -> u32 {
        self.check
    }

    /// Sets other filters on the bus.
    pub(super) fn refilter(&mut self, registers: &CanPeripheral, filters: Filters<'_>) {
        self.verify();
        *self = Self::with(self.timing, Banks::of(BusMode::Normal, filters));
        filters::change(registers, &self.banks);
    }

    /// Restarts if a bit of the configuration has changed. Call it before each use.
    pub(super) fn verify(&self) {
        if digest(self.timing, &self.banks) != self.check {
            error!("restart: the kept configuration of the CAN controller is disturbed");
            board::restart();
        }
    }

    pub(super) fn is_none(&self) -> bool {
        self.timing == 0
    }

    pub(super) fn is_listening(&self) -> bool {
        self.timing & SILENT != 0
    }

    /// Sets bit timing and filters in initialization mode.
    pub(super) fn set(&self, registers: &CanPeripheral) {
        filters::set(registers, &self.banks);
        // SAFETY: timing fields from the tested table, and the silent bit. Loop back stays off.
        registers.btr().write(|w| unsafe { w.bits(self.timing) });
    }

    /// Adds the differences between the registers of the controller and this configuration.
    pub(super) fn compare(&self, registers: &CanPeripheral, digest: &mut Digest) {
        /// SILM, LBKM, SJW, TS2, TS1, BRP. The others are reserved, and can have any value on a clone.
        const TIMING: u32 = 0xC37F_03FF;
        digest.add(registers.btr().read().bits() & TIMING ^ self.timing);
        self.banks.compare(registers, digest);
    }
}

/// A number that is another one if a bit changes.
fn digest(timing: u32, banks: &Banks) -> u32 {
    let mut digest = Digest::default();
    digest.add(timing);
    banks.sum(&mut digest);
    digest.value()
}
