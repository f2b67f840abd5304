//! Data accesses: how long an access to a register waits, and how long the write buffer is occupied.
//!
//! The system bus has RAM and the peripherals. A store is buffered: the processor continues, and its next access to the system bus
//! waits until the store has ended. An access to an APB takes two cycles of its clock, and the bridge (RM0008, figure 1) adds
//! to them.

use super::super::CortexM3;
use super::super::decode::instruction::Size;
use super::Cycles;

/// The clocks of the buses: how many cycles of HCLK a cycle of PCLK1 and PCLK2 has.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Buses {
    /// The ratio HCLK / PCLK1.
    pub apb1: u8,
    /// The ratio HCLK / PCLK2.
    pub apb2: u8,
}

impl Default for Buses {
    /// After a reset: all clocks are equal.
    fn default() -> Self {
        Self { apb1: 1, apb2: 1 }
    }
}

impl Buses {
    /// Cycles that an access to a register of a peripheral takes longer than one to RAM.
    pub fn wait(&self, address: u32, cycles: &Cycles) -> u64 {
        let ratio = match address {
            0x4000_0000..0x4001_0000 => self.apb1,
            0x4001_0000..0x4001_8000 => self.apb2,
            // The core's own APB has DBGMCU.
            0xE004_0000..0xE010_0000 => 1,
            _ => return cycles.ahb_register.into(),
        };
        let edge = cycles.bridge_edge * (ratio - 1);
        u64::from(2 * ratio - 1 + edge + cycles.bridge)
    }
}

impl CortexM3 {
    /// Waits until the write buffer is empty.
    #[inline(always)]
    pub(in super::super) fn drain(&mut self) {
        if self.buffer_free_at > self.cycle {
            self.cycle = self.buffer_free_at;
        }
    }

    /// A load from memory or a register at this address: waits for it, so that it happens in the present cycle.
    #[inline(always)]
    pub(in super::super) fn wait_for_load(&mut self, address: u32) {
        if !super::fetch::is_code(address) {
            self.drain();
        } else if self.cycles.is_some() {
            self.wait_for_flash();
        }
    }

    #[inline(never)]
    fn wait_for_flash(&mut self) {
        if let Some(cycles) = &self.cycles {
            self.cycle = self.fetch.read_data(self.cycle, cycles);
        }
    }

    /// An unaligned load is two accesses, and three for a word at an odd address. The write buffer hides those of a store.
    #[cold]
    pub(in super::super) fn split_access(&mut self, size: Size, address: u32) {
        if self.cycles.is_some() {
            self.cycle += if size == Size::Word && address & 1 != 0 {
                2
            } else {
                1
            };
        }
    }

    /// A load from a register of a peripheral.
    pub(in super::super) fn wait_for_register(&mut self, address: u32) {
        self.drain();
        if let Some(cycles) = &self.cycles {
            self.cycle += self.buses.wait(address, cycles);
        }
    }

    /// A store to a register of a peripheral occupies the write buffer.
    pub(in super::super) fn occupy_buffer(&mut self, address: u32) {
        if let Some(cycles) = &self.cycles {
            self.buffer_free_at = self.cycle + 1 + self.buses.wait(address, cycles);
        }
    }

    /// An access to a register of the core.
    pub(in super::super) fn wait_for_core_register(&mut self) {
        if let Some(cycles) = &self.cycles {
            self.cycle += u64::from(cycles.core_register);
        }
    }
}
