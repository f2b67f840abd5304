//! Charges the processor for its instructions and their fetch.

use super::super::CortexM3;
use super::fetch::is_code;
use super::{Buses, Cost, Cycles, FlashTiming};

impl CortexM3 {
    /// Sets the cycles of the instructions; None: each takes one cycle, memories and buses have no wait states, and an exception
    /// takes 12 cycles to enter and to return. The worst of each range is set at first.
    pub fn set_cycles(&mut self, cycles: Option<Cycles>) {
        self.cycles = cycles;
        self.cache.clear();
    }

    /// Sets the wait states of the flash and the clocks of the buses.
    pub fn set_memories(&mut self, flash: FlashTiming, buses: Buses) {
        self.fetch.set_flash(flash);
        self.buses = buses;
    }

    /// Fetches an instruction that is not completely in the present line. False when the flash was busy: time has passed.
    #[inline(never)]
    pub(in super::super) fn fetch_more(&mut self, pc: u32, length: u32) -> bool {
        let Some(cycles) = &self.cycles else {
            self.fetch.have_everything();
            return true;
        };
        let end = pc.wrapping_add(length - 1);
        let fetched = self.fetch.fetch(pc, end, self.cycle, cycles);
        self.cycle = fetched.unwrap_or_else(|busy_until| busy_until);
        fetched.is_ok()
    }

    /// Charges what the executed instruction takes beyond its first cycle. `after` is the address of the instruction behind it.
    #[inline(always)]
    pub(in super::super) fn charge(&mut self, after: u32, cost: &Cost) {
        let cycles = if cost.is_access() {
            if self.fetch.is_in_ram() {
                self.contend();
            }
            cost.after(self.left)
        } else {
            cost.extra()
        };
        self.cycle = self.cycle.wrapping_add_signed(cycles.into());
        self.left = cost.leaves();
        if self.next != after {
            self.charge_branch();
            self.note_branch(after);
        }
    }

    /// Charges the refill of the pipeline.
    #[inline(always)]
    fn charge_branch(&mut self) {
        // An exception return, which has its own cycles, leaves nothing of what was fetched.
        if let Some(cycles) = &self.cycles
            && !std::mem::take(&mut self.returned)
        {
            self.cycle += u64::from(cycles.refill);
            self.fetch.branch(cycles);
        }
    }

    #[cold]
    fn contend(&mut self) {
        if let Some(cycles) = &self.cycles {
            self.fetch.contend(cycles);
        }
    }

    /// The flash is busy for this many cycles: code in it waits, and so does an exception with a vector in it.
    pub fn occupy_flash(&mut self, cycles: u64) {
        let until = self.cycle + cycles;
        self.fetch.set_busy(until);
        if self.sleep.is_none() && is_code(self.next) {
            self.cycle = until;
        }
    }
}
