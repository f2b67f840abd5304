//! Loads and stores of several words, and the exclusive ones: all of them must be aligned (ARM ARM A3.2.1).

use super::super::CortexM3;
use super::super::decode::instruction::{Index, Instruction, Multiple, Register, Size};
use super::super::fault::{FaultKind, Result};
use crate::io::Io;

fn aligned(address: u32, mask: u32) -> Result<()> {
    if address & mask == 0 {
        Ok(())
    } else {
        Err(FaultKind::Unaligned(address).into())
    }
}

/// The address of the first word, and the new value of the base.
fn span(base: u32, kind: Multiple, list: u16) -> (u32, u32) {
    let length = 4 * list.count_ones();
    match kind {
        Multiple::IncrementAfter => (base, base.wrapping_add(length)),
        Multiple::DecrementBefore => (base.wrapping_sub(length), base.wrapping_sub(length)),
    }
}

/// The registers of a list, starting with the lowest.
#[inline(always)]
fn registers(mut list: u16) -> impl Iterator<Item = Register> {
    std::iter::from_fn(move || {
        let number = (list != 0).then(|| list.trailing_zeros())?;
        list &= list - 1;
        Some(Register::new(number))
    })
}

impl CortexM3 {
    /// LDM. The base is written back before the registers, and PC is loaded last: it may end a handler.
    pub(super) fn load_multiple(
        &mut self,
        io: &mut impl Io,
        n: Register,
        kind: Multiple,
        write_back: bool,
        list: u16,
    ) -> Result<()> {
        let (mut address, base) = span(self.registers.get(n), kind, list);
        aligned(address, 3)?;
        if let Some(words) = self.abandoned_after(list.count_ones()) {
            for register in registers(list).take(words) {
                let value = self.load_value(io, Size::Word, address)?;
                if register != n {
                    self.registers.set(register, value);
                }
                address = address.wrapping_add(4);
            }
            self.abandon();
            return Ok(());
        }
        let mut target = None;
        for register in registers(list) {
            let value = self.load_value(io, Size::Word, address)?;
            if register == Register::PC {
                target = Some(value);
            } else {
                self.registers.set(register, value);
            }
            address = address.wrapping_add(4);
        }
        if write_back {
            self.registers.set(n, base);
        }
        match target {
            Some(target) => self.branch_exchange(target),
            None => Ok(()),
        }
    }

    pub(super) fn store_multiple(
        &mut self,
        io: &mut impl Io,
        n: Register,
        kind: Multiple,
        write_back: bool,
        list: u16,
    ) -> Result<()> {
        let (mut address, base) = span(self.registers.get(n), kind, list);
        aligned(address, 3)?;
        let abandoned = self.abandoned_after(list.count_ones());
        let words = abandoned.unwrap_or(usize::MAX);
        for register in registers(list).take(words) {
            self.store_value(io, Size::Word, address, self.registers.get(register))?;
            address = address.wrapping_add(4);
        }
        if abandoned.is_some() {
            self.abandon();
        } else if write_back {
            self.registers.set(n, base);
        }
        Ok(())
    }

    /// LDRD. With PC as the base, the address is relative to the word-aligned PC.
    pub(super) fn load_dual(
        &mut self,
        io: &mut impl Io,
        (t, t2): (Register, Register),
        n: Register,
        index: Index,
        offset: i16,
    ) -> Result<()> {
        let (address, base) = if n == Register::PC {
            let address = self.literal_base().wrapping_add_signed(offset.into());
            (address, 0)
        } else {
            self.index(n, index, offset)
        };
        aligned(address, 3)?;
        let first = self.load_value(io, Size::Word, address)?;
        if self.abandoned_after(2).is_some() {
            // The base: see `restart_load`.
            if t != n {
                self.registers.set(t, first);
            }
            self.abandon();
            return Ok(());
        }
        let second = self.load_value(io, Size::Word, address.wrapping_add(4))?;
        if index != Index::Offset {
            self.registers.set(n, base);
        }
        self.registers.set(t, first);
        self.registers.set(t2, second);
        Ok(())
    }

    /// At an exception: if the next instruction is an LDRD with its base as the first destination, its first load is done.
    pub(in super::super) fn restart_load(&mut self) {
        let half_word = |address| self.memory.read(address).map_or(0, u16::from_le_bytes);
        let next = self.next;
        let decoded = self
            .model
            .decode(half_word(next), half_word(next.wrapping_add(2)));
        let Instruction::LoadDual { t, n, offset, .. } = decoded.instruction else {
            return;
        };
        let address = self.registers.get(n).wrapping_add_signed(offset.into());
        // Peripherals are not modelled here: no program loads their registers in pairs.
        if t == n
            && let Some(first) = self.memory.word(address)
        {
            self.registers.set(t, first);
        }
    }

    pub(super) fn store_dual(
        &mut self,
        io: &mut impl Io,
        (t, t2): (Register, Register),
        n: Register,
        index: Index,
        offset: i16,
    ) -> Result<()> {
        let (address, base) = self.index(n, index, offset);
        aligned(address, 3)?;
        self.store_value(io, Size::Word, address, self.registers.get(t))?;
        if self.abandoned_after(2).is_some() {
            self.abandon();
            return Ok(());
        }
        self.store_value(
            io,
            Size::Word,
            address.wrapping_add(4),
            self.registers.get(t2),
        )?;
        if index != Index::Offset {
            self.registers.set(n, base);
        }
        Ok(())
    }

    /// LDREX: opens the local monitor, which ignores the address on this core (A3.4.1).
    pub(super) fn load_exclusive(
        &mut self,
        io: &mut impl Io,
        size: Size,
        t: Register,
        n: Register,
        offset: u16,
    ) -> Result<()> {
        let address = self.exclusive_address(size, n, offset)?;
        let value = self.load_value(io, size, address)?;
        self.registers.set(t, value);
        self.exclusive = true;
        Ok(())
    }

    /// STREX: if the monitor is still open, stores and returns 0; closes it.
    pub(super) fn store_exclusive(
        &mut self,
        io: &mut impl Io,
        size: Size,
        (d, t): (Register, Register),
        n: Register,
        offset: u16,
    ) -> Result<()> {
        let address = self.exclusive_address(size, n, offset)?;
        let open = std::mem::take(&mut self.exclusive);
        if open {
            self.store_value(io, size, address, self.registers.get(t))?;
        }
        self.registers.set(d, u32::from(!open));
        Ok(())
    }

    fn exclusive_address(&self, size: Size, n: Register, offset: u16) -> Result<u32> {
        let address = self.registers.get(n).wrapping_add(offset.into());
        let mask = match size {
            Size::Word => 3,
            Size::HalfWord | Size::SignedHalfWord => 1,
            Size::Byte | Size::SignedByte => 0,
        };
        aligned(address, mask)?;
        Ok(address)
    }
}
