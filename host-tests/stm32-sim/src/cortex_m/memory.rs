//! The memories of the microcontroller: flash, which also appears at address 0, and RAM.

/// The start address of the flash.
pub const FLASH_START: u32 = 0x0800_0000;
/// The largest flash of a simulated chip: 512 KiB.
const LARGEST_FLASH: usize = 512 * 1024;
/// The start address of the RAM.
pub const RAM_START: u32 = 0x2000_0000;
/// The largest RAM of a simulated chip: 128 KiB.
const LARGEST_RAM: usize = 128 * 1024;

/// The sizes of the memories in bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MemorySizes {
    /// Flash: a power of two, at most 512 KiB.
    pub flash: usize,
    /// RAM: at most 128 KiB.
    pub ram: usize,
    /// The RAM appears again behind its end; otherwise an access there is a bus fault.
    pub ram_repeats: bool,
}

/// The content of RAM after power-up, which is undefined on the chip: neither zero nor an initial value of a variable.
const AFTER_POWER_UP: u8 = 0xA5;

/// The offset of an address in the largest flash, also in the alias at 0. The flash of the chip can be smaller.
#[inline(always)]
pub const fn flash_offset(address: u32) -> Option<usize> {
    if address & !(FLASH_START | (LARGEST_FLASH as u32 - 1)) == 0 {
        Some(address as usize & (LARGEST_FLASH - 1))
    } else {
        None
    }
}

/// The flash and the RAM of the processor.
#[derive(Clone, Debug)]
pub struct Memory {
    flash: Box<[u8]>,
    ram: Box<[u8]>,
    ram_repeats: bool,
}

impl Memory {
    /// Erased flash, and RAM of zeros.
    pub fn new(sizes: MemorySizes) -> Self {
        Self {
            flash: vec![0xFF; sizes.flash].into(),
            ram: vec![0; sizes.ram].into(),
            ram_repeats: sizes.ram_repeats,
        }
    }

    /// True for an address in flash, also in the alias at 0.
    pub fn is_flash(&self, address: u32) -> bool {
        flash_offset(address).is_some_and(|offset| offset < self.flash.len())
    }

    /// True for an address in RAM.
    pub fn is_ram(&self, address: u32) -> bool {
        (address.wrapping_sub(RAM_START) as usize) < self.ram.len()
    }

    /// Overwrites all of RAM, as after a power loss.
    pub fn overwrite_ram(&mut self) {
        self.ram.fill(AFTER_POWER_UP);
    }

    /// The bytes at this address; None when they are not all in one memory.
    #[inline(always)]
    pub fn read<const COUNT: usize>(&self, address: u32) -> Option<[u8; COUNT]> {
        let offset = address.wrapping_sub(RAM_START) as usize;
        if offset < LARGEST_RAM {
            let place = self.ram.get(self.in_ram(offset)..)?;
            return place.first_chunk().copied();
        }
        self.flash
            .get(flash_offset(address)?..)?
            .first_chunk()
            .copied()
    }

    /// Writes to RAM; false when the range is not completely in RAM.
    #[inline(always)]
    pub fn write<const COUNT: usize>(&mut self, address: u32, bytes: [u8; COUNT]) -> bool {
        let offset = address.wrapping_sub(RAM_START) as usize;
        let offset = self.in_ram(offset);
        let place = self
            .ram
            .get_mut(offset..)
            .and_then(|rest| rest.first_chunk_mut());
        place.map(|place| *place = bytes).is_some()
    }

    /// The place of an offset in a RAM that repeats.
    #[inline(always)]
    fn in_ram(&self, offset: usize) -> usize {
        if self.ram_repeats && offset < LARGEST_RAM {
            offset % self.ram.len()
        } else {
            offset
        }
    }

    /// A word of either memory.
    pub fn word(&self, address: u32) -> Option<u32> {
        self.read(address).map(u32::from_le_bytes)
    }

    /// The bytes at an address, if all of them are in flash or in RAM.
    pub fn bytes(&self, address: u32, length: usize) -> Option<&[u8]> {
        if let Some(offset) = flash_offset(address) {
            return self.flash.get(offset..)?.get(..length);
        }
        let offset = address.wrapping_sub(RAM_START) as usize;
        self.ram.get(offset..)?.get(..length)
    }

    /// Bytes of either memory, mutable, for changes from outside the processor.
    pub fn bytes_mut(&mut self, address: u32, length: usize) -> Option<&mut [u8]> {
        if let Some(offset) = flash_offset(address) {
            return self.flash.get_mut(offset..)?.get_mut(..length);
        }
        let offset = address.wrapping_sub(RAM_START) as usize;
        self.ram.get_mut(offset..)?.get_mut(..length)
    }
}
