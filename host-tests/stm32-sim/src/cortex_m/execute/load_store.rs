//! Loads and stores of one value (ARM ARM A4.6), and the address map (B3.1).

use super::super::CortexM3;
use super::super::decode::instruction::{Index, Register, Size};
use super::super::fault::{FaultKind, Result};
use crate::io::{Io, Width};

/// The bit-band alias of RAM: a word for each bit from 0x2000_0000 on.
const RAM_BITS: std::ops::Range<u32> = 0x2200_0000..0x2400_0000;
const PERIPHERALS: std::ops::Range<u32> = 0x4000_0000..0x4200_0000;
/// The bit-band alias of the peripherals.
const PERIPHERAL_BITS: std::ops::Range<u32> = 0x4200_0000..0x4400_0000;
/// System memory of the chip: boot loader, unique identifier, option bytes.
const SYSTEM_MEMORY: std::ops::Range<u32> = 0x1FFF_0000..0x2000_0000;
/// The registers of the core.
const SYSTEM_CONTROL: std::ops::Range<u32> = 0xE000_E000..0xE000_F000;
/// The DWT unit.
const DWT: std::ops::Range<u32> = 0xE000_1000..0xE000_2000;
/// DBGMCU.
const DEBUG: std::ops::Range<u32> = 0xE004_2000..0xE004_2400;

/// The word and the bit of an address in a bit-band alias (PM0056 2.2.5).
fn bit_of_alias(address: u32) -> (u32, u32) {
    let base = address & 0xF000_0000;
    let offset = address & 0x01FF_FFFF;
    (base + (offset >> 7 << 2), offset >> 2 & 31)
}

fn width(size: Size) -> Width {
    match size {
        Size::Byte | Size::SignedByte => Width::Byte,
        Size::HalfWord | Size::SignedHalfWord => Width::HalfWord,
        Size::Word => Width::Word,
    }
}

/// The size in bytes minus one: the address bits that are 0 when it is aligned.
#[inline(always)]
fn alignment(size: Size) -> u32 {
    match size {
        Size::Byte | Size::SignedByte => 0,
        Size::HalfWord | Size::SignedHalfWord => 1,
        Size::Word => 3,
    }
}

impl CortexM3 {
    /// The word-aligned PC: the base of literals.
    #[inline(always)]
    pub(super) fn literal_base(&self) -> u32 {
        self.registers.get(Register::PC) & !3
    }

    #[inline(always)]
    pub(super) fn indexed_address(&self, n: Register, m: Register, shift: u8) -> u32 {
        self.registers
            .get(n)
            .wrapping_add(self.registers.get(m) << (shift & 3))
    }

    /// Loads a value, extended to a word.
    #[inline(always)]
    pub(super) fn load_value(&mut self, io: &mut impl Io, size: Size, address: u32) -> Result<u32> {
        self.wait_for_load(address);
        let found = match size {
            Size::Word => self.memory.read(address).map(u32::from_le_bytes),
            Size::HalfWord => self
                .memory
                .read(address)
                .map(|bytes| u16::from_le_bytes(bytes).into()),
            Size::SignedHalfWord => self
                .memory
                .read(address)
                .map(|bytes| i32::from(i16::from_le_bytes(bytes)) as u32),
            Size::Byte => self
                .memory
                .read(address)
                .map(|bytes| u8::from_le_bytes(bytes).into()),
            Size::SignedByte => self
                .memory
                .read(address)
                .map(|bytes| i32::from(i8::from_le_bytes(bytes)) as u32),
        };
        match found {
            Some(value) if address & alignment(size) == 0 => Ok(value),
            Some(value) if !self.system.traps_unaligned() => {
                self.split_access(size, address);
                Ok(value)
            }
            _ => self.load_elsewhere(io, size, address),
        }
    }

    /// Stores the low bits of a value.
    #[inline(always)]
    pub(super) fn store_value(
        &mut self,
        io: &mut impl Io,
        size: Size,
        address: u32,
        value: u32,
    ) -> Result<()> {
        if address & alignment(size) != 0 && self.system.traps_unaligned() {
            return Err(FaultKind::Unaligned(address).into());
        }
        self.drain();
        let stored = match size {
            Size::Word => self.memory.write(address, value.to_le_bytes()),
            Size::HalfWord | Size::SignedHalfWord => {
                self.memory.write(address, (value as u16).to_le_bytes())
            }
            Size::Byte | Size::SignedByte => self.memory.write(address, [value as u8]),
        };
        if stored {
            return Ok(());
        }
        self.store_elsewhere(io, size, address, value)
    }

    /// Loads from a register. Such an access cannot be unaligned (A3.2.1).
    #[inline(never)]
    fn load_elsewhere(&mut self, io: &mut impl Io, size: Size, address: u32) -> Result<u32> {
        if address & alignment(size) != 0 {
            return Err(FaultKind::Unaligned(address).into());
        }
        self.waiting.read(address);
        let value = if PERIPHERALS.contains(&address)
            || SYSTEM_MEMORY.contains(&address)
            || DEBUG.contains(&address)
        {
            self.read_io(io, address, width(size))?
        } else if SYSTEM_CONTROL.contains(&address) {
            self.wait_for_core_register();
            self.read_system(address, width(size))?
        } else if DWT.contains(&address) {
            self.wait_for_core_register();
            self.read_dwt(address, width(size))?
        } else if PERIPHERAL_BITS.contains(&address) {
            let (word, bit) = bit_of_alias(address);
            self.read_io(io, word, Width::Word)? >> bit & 1
        } else if RAM_BITS.contains(&address) {
            let (word, bit) = bit_of_alias(address);
            self.memory.word(word).ok_or(FaultKind::Unmapped(address))? >> bit & 1
        } else {
            return Err(FaultKind::Unmapped(address).into());
        };
        Ok(match size {
            Size::SignedByte => i32::from(value as i8) as u32,
            Size::SignedHalfWord => i32::from(value as i16) as u32,
            _ => value,
        })
    }

    #[inline(never)]
    fn store_elsewhere(
        &mut self,
        io: &mut impl Io,
        size: Size,
        address: u32,
        value: u32,
    ) -> Result<()> {
        let width = width(size);
        let value = match width {
            Width::Byte => value & 0xFF,
            Width::HalfWord => value & 0xFFFF,
            Width::Word => value,
        };
        if address & alignment(size) != 0 {
            return Err(FaultKind::Unaligned(address).into());
        }
        if PERIPHERALS.contains(&address)
            || DEBUG.contains(&address)
            || self.memory.is_flash(address)
        {
            return self.write_io(io, address, width, value);
        }
        if SYSTEM_CONTROL.contains(&address) {
            self.wait_for_core_register();
            return self.write_system(address, width, value);
        }
        if DWT.contains(&address) {
            self.wait_for_core_register();
            return self.write_dwt(address, width, value);
        }
        let (word, bit) = bit_of_alias(address);
        let with_bit = |before: u32| before & !(1 << bit) | (value & 1) << bit;
        if PERIPHERAL_BITS.contains(&address) {
            let before = self.read_io(io, word, Width::Word)?;
            return self.write_io(io, word, Width::Word, with_bit(before));
        }
        let is_ram = RAM_BITS.contains(&address) && self.memory.is_ram(word);
        match self.memory.word(word) {
            Some(before) if is_ram => {
                self.memory.write(word, with_bit(before).to_le_bytes());
                Ok(())
            }
            _ => Err(FaultKind::Unmapped(address).into()),
        }
    }

    fn read_io(&mut self, io: &mut impl Io, address: u32, width: Width) -> Result<u32> {
        self.wait_for_register(address);
        let value = io
            .read(self.cycle, address, width)
            .map_err(|error| FaultKind::Access(address, error))?;
        self.note_change(io);
        Ok(value)
    }

    fn write_io(&mut self, io: &mut impl Io, address: u32, width: Width, value: u32) -> Result<()> {
        io.write(self.cycle, address, width, value)
            .map_err(|error| FaultKind::Access(address, error))?;
        self.occupy_buffer(address);
        self.note_change(io);
        Ok(())
    }

    /// Ends the run after this instruction when the machine has to update.
    fn note_change(&mut self, io: &mut impl Io) {
        if io.take_changed() {
            self.changed = true;
            self.interrupt();
        }
    }

    /// Loads to a register; a load to PC branches.
    #[inline(always)]
    pub(super) fn load_to(
        &mut self,
        io: &mut impl Io,
        size: Size,
        t: Register,
        address: u32,
    ) -> Result<()> {
        let value = self.load_value(io, size, address)?;
        self.write_loaded(t, address, value)
    }

    /// Writes the loaded value to a register. The target of a branch must be loaded from an aligned word (A7.7.43).
    #[inline(always)]
    fn write_loaded(&mut self, t: Register, address: u32, value: u32) -> Result<()> {
        if t != Register::PC {
            self.registers.set(t, value);
            return Ok(());
        }
        if address & 3 != 0 {
            return Err(FaultKind::Unaligned(address).into());
        }
        self.branch_exchange(value)
    }

    /// The address of the access, and the new value of the base.
    #[inline(always)]
    pub(super) fn index(&self, n: Register, index: Index, offset: i16) -> (u32, u32) {
        let base = self.registers.get(n);
        let moved = base.wrapping_add_signed(offset.into());
        match index {
            Index::Offset => (moved, base),
            Index::Pre => (moved, moved),
            Index::Post => (base, moved),
        }
    }

    pub(super) fn load_indexed(
        &mut self,
        io: &mut impl Io,
        size: Size,
        t: Register,
        n: Register,
        index: Index,
        offset: i16,
    ) -> Result<()> {
        let (address, base) = self.index(n, index, offset);
        let value = self.load_value(io, size, address)?;
        self.registers.set(n, base);
        self.write_loaded(t, address, value)
    }

    pub(super) fn store_indexed(
        &mut self,
        io: &mut impl Io,
        size: Size,
        t: Register,
        n: Register,
        index: Index,
        offset: i16,
    ) -> Result<()> {
        let (address, base) = self.index(n, index, offset);
        self.store_value(io, size, address, self.registers.get(t))?;
        self.registers.set(n, base);
        Ok(())
    }
}
