//! The acceptance filters of the controller, for receive FIFO 0.
//!
//! One bank for each filter, 32 bits wide and in mask mode. So all filters have equal priority, and a frame that passes two filters
//! is stored once. Data and remote frames pass.
//!
//! ```text
//!  bit 31            21          3   2     1     0
//!      +--------------+-----------+-----+-----+---+
//!      | 11-bit identifier        | IDE | RTR | 0 |   FxR1: the bits, FxR2: the mask
//!      | 29-bit identifier        |     |     |   |
//!      +--------------------------+-----+-----+---+
//! ```

use super::inspection::Digest;
use crate::board::{self, CanPeripheral};
use embedded_can::Id;
use plumbline::can::Filter;
use plumbline::node::BusMode;
use plumbline::node::driver::Filters;

/// FMR.FINIT: the filters are being set.
const INITIALIZATION: u32 = 1 << 0;
/// IDE: 29-bit identifier.
const EXTENDED: u32 = 1 << 2;

/// The contents of the banks.
pub(super) struct Banks {
    words: [(u32, u32); board::FILTER_BANKS as usize],
    active: u8,
}

impl Banks {
    pub(super) const NONE: Self = Self {
        words: [(0, 0); board::FILTER_BANKS as usize],
        active: 0,
    };

    /// The banks of these filters. In listen mode, one accepts all frames.
    pub(super) fn of(mode: BusMode, filters: Filters<'_>) -> Self {
        let mut banks = Self::NONE;
        match mode {
            BusMode::Listen => banks.push((0, 0)),
            BusMode::Normal => filters.for_each(|filter| banks.push(words(&filter))),
        }
        banks
    }

    /// Adds this content.
    pub(super) fn sum(&self, digest: &mut Digest) {
        digest.add(self.active.into());
        for (bits, mask) in self.active() {
            digest.add(*bits);
            digest.add(*mask);
        }
    }

    fn active(&self) -> impl Iterator<Item = &(u32, u32)> {
        self.words.iter().take(self.active.into())
    }

    fn push(&mut self, words: (u32, u32)) {
        // There is a bank for each filter: this is checked at compile time.
        if let Some(place) = self.words.get_mut(usize::from(self.active)) {
            *place = words;
            self.active += 1;
        }
    }

    /// Adds the differences between the registers of the controller and this content.
    pub(super) fn compare(&self, registers: &CanPeripheral, digest: &mut Digest) {
        const ALL: u32 = (1 << board::FILTER_BANKS) - 1;
        let master = registers.fmr().read().bits();
        for (bank, (bits, mask)) in registers.fb_iter().zip(self.active()) {
            digest.add(bank.fr1().read().bits() ^ bits);
            digest.add(bank.fr2().read().bits() ^ mask);
        }
        digest.add(master & INITIALIZATION | board::own_filters(master) ^ master);
        digest.add(registers.fm1r().read().bits() & ALL);
        digest.add(!registers.fs1r().read().bits() & ALL);
        digest.add(registers.ffa1r().read().bits() & ALL);
        digest.add(registers.fa1r().read().bits() & ALL ^ ((1 << self.active) - 1));
    }
}

/// Sets the filters while the controller is off the bus.
pub(super) fn set(registers: &CanPeripheral, set: &Banks) {
    // SAFETY: all bits of these registers are filters of this controller, or reserved bits that keep their value.
    unsafe {
        registers
            .fmr()
            .modify(|fmr, w| w.bits(board::own_filters(fmr.bits()) | INITIALIZATION));
        registers.fa1r().write(|w| w.bits(0));
        registers.fm1r().write(|w| w.bits(0));
        registers.ffa1r().write(|w| w.bits(0));
        registers
            .fs1r()
            .write(|w| w.bits((1 << board::FILTER_BANKS) - 1));
    }
    for (bank, (bits, mask)) in registers.fb_iter().zip(set.active()) {
        // SAFETY: all values of these registers are valid.
        unsafe {
            bank.fr1().write(|w| w.bits(*bits));
            bank.fr2().write(|w| w.bits(*mask));
        }
    }
    // SAFETY: as above.
    unsafe {
        registers.fa1r().write(|w| w.bits((1 << set.active) - 1));
        registers
            .fmr()
            .modify(|fmr, w| w.bits(fmr.bits() & !INITIALIZATION));
    }
}

/// Changes the filters on the bus. A filter that stays in its place receives without a gap: FMR.FINIT would stop the reception of all, so
/// only the banks that change are deactivated.
pub(super) fn change(registers: &CanPeripheral, set: &Banks) {
    for ((number, bank), (bits, mask)) in (0..).zip(registers.fb_iter()).zip(set.active()) {
        let stays = bank.fr1().read().bits() == *bits && bank.fr2().read().bits() == *mask;
        if !stays {
            activate(registers, number, false);
            // SAFETY: all values of these registers are valid, and the bank is not active.
            unsafe {
                bank.fr1().write(|w| w.bits(*bits));
                bank.fr2().write(|w| w.bits(*mask));
            }
        }
        activate(registers, number, true);
    }
    for rest in set.active..board::FILTER_BANKS {
        activate(registers, rest, false);
    }
}

/// Sets FA1R.FACT of a bank.
fn activate(registers: &CanPeripheral, bank: u8, active: bool) {
    let fact = 1_u32 << bank;
    // SAFETY: a bit of a bank of this controller.
    unsafe {
        registers.fa1r().modify(|banks, w| {
            let others = banks.bits() & !fact;
            w.bits(if active { others | fact } else { others })
        });
    }
}

/// The contents of FxR1 and FxR2.
fn words(filter: &Filter) -> (u32, u32) {
    match filter.id {
        Id::Standard(id) => (u32::from(id.as_raw()) << 21, filter.mask << 21 | EXTENDED),
        Id::Extended(id) => (id.as_raw() << 3 | EXTENDED, filter.mask << 3 | EXTENDED),
    }
}
