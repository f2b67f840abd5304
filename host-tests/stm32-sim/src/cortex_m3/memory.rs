//! The memories of the STM32F103C8 (RM0008 3.3): flash, which also appears at address 0, and RAM.

/// Start address of flash.
pub const FLASH_START: u32 = 0x0800_0000;
/// 64 KiB of flash.
pub const FLASH_SIZE: usize = 64 * 1024;
/// Start address of RAM.
pub const RAM_START: u32 = 0x2000_0000;
/// 20 KiB of RAM.
pub const RAM_SIZE: usize = 20 * 1024;

/// The content of RAM after power-up, which is undefined on the chip: neither zero nor an initial value of a variable.
const AFTER_POWER_UP: u8 = 0xA5;

/// The offset of an address in flash, also in the alias at 0.
#[inline(always)]
pub const fn flash_offset(address: u32) -> Option<usize> {
    if address & !(FLASH_START | (FLASH_SIZE as u32 - 1)) == 0 {
        Some(address as usize & (FLASH_SIZE - 1))
    } else {
        None
    }
}

/// Flash and RAM.
#[derive(Clone, Debug)]
pub struct Memory {
    flash: Box<[u8]>,
    ram: Box<[u8]>,
}

impl Memory {
    /// Erased flash, and RAM of zeros.
    pub fn new() -> Self {
        Self {
            flash: vec![0xFF; FLASH_SIZE].into(),
            ram: vec![0; RAM_SIZE].into(),
        }
    }

    /// Overwrites all of RAM, as after a power loss.
    pub fn overwrite_ram(&mut self) {
        self.ram.fill(AFTER_POWER_UP);
    }

    /// The bytes at this address; None when they are not all in one memory.
    #[inline(always)]
    pub fn read<const COUNT: usize>(&self, address: u32) -> Option<[u8; COUNT]> {
        let offset = address.wrapping_sub(RAM_START) as usize;
        if offset < RAM_SIZE {
            return self.ram.get(offset..)?.first_chunk().copied();
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
        let place = self
            .ram
            .get_mut(offset..)
            .and_then(|rest| rest.first_chunk_mut());
        place.map(|place| *place = bytes).is_some()
    }

    /// A word of either memory.
    pub fn word(&self, address: u32) -> Option<u32> {
        self.read(address).map(u32::from_le_bytes)
    }

    /// Bytes of either memory.
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
