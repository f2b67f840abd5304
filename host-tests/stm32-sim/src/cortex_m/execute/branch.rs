//! Branches (ARM ARM A4.3), and writes to PC.

use super::super::CortexM3;
use super::super::decode::instruction::{Register, Size};
use super::super::fault::{FaultKind, Result};
use crate::io::Io;

impl CortexM3 {
    /// Relative to PC, which is the address of the instruction plus 4.
    #[inline(always)]
    pub(super) fn branch(&mut self, offset: i32) {
        self.next = self.registers.get(Register::PC).wrapping_add_signed(offset);
    }

    /// Sets LR to the address of the next instruction, with the bit of the Thumb state.
    #[inline(always)]
    pub(super) fn link(&mut self) {
        self.registers.set(Register::LR, self.next | 1);
    }

    /// Jumps to an address whose low bit selects the state (BLXWritePC).
    #[inline(always)]
    pub(in super::super) fn branch_to_state(&mut self, target: u32) -> Result<()> {
        if target & 1 == 0 {
            return Err(FaultKind::InvalidState(target).into());
        }
        self.next = target & !1;
        Ok(())
    }

    /// The same; in a handler it may also be the exception return (BXWritePC, LoadWritePC).
    #[inline(always)]
    pub(super) fn branch_exchange(&mut self, target: u32) -> Result<()> {
        if target >> 28 == 0xF && self.registers.in_handler() {
            return self.return_from_exception(target);
        }
        self.branch_to_state(target)
    }

    /// ADD PC, Rm: ignores the low bit, so the state does not change.
    pub(super) fn add_to_pc(&mut self, m: Register) {
        let sum = self
            .registers
            .get(Register::PC)
            .wrapping_add(self.registers.get(m));
        self.next = sum & !1;
    }

    /// TBB and TBH: forward by twice the table entry.
    pub(super) fn table_branch(
        &mut self,
        io: &mut impl Io,
        n: Register,
        m: Register,
        half_words: bool,
    ) -> Result<()> {
        let (base, index) = (self.registers.get(n), self.registers.get(m));
        let entry = if half_words {
            self.load_value(io, Size::HalfWord, base.wrapping_add(index << 1))?
        } else {
            self.load_value(io, Size::Byte, base.wrapping_add(index))?
        };
        self.branch(2 * entry as i32);
        Ok(())
    }
}
