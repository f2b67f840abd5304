//! The parameter memory: two sectors of the internal flash, as a [`NorFlash`].
//!
//! Addresses are relative to the start of the area. Interrupts stay enabled, but both microcontrollers stall instruction fetches
//! during an erase (Blue Pill up to 40 ms, Nucleo up to 500 ms) and during programming (up to 70 us for a half-word, up to 100 us
//! for a word). bxCAN continues to receive into its FIFO of three frames.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// The part that depends on the microcontroller: an area of flash with `COUNT` sectors of `SIZE` bytes each.
pub trait Sectors {
    /// The address of the first byte.
    const START: usize;
    /// The size of a sector in bytes.
    const SIZE: usize;
    /// The number of sectors of the memory.
    const COUNT: usize;
    /// The smallest write in bytes.
    const WRITE_SIZE: usize;

    /// Erases one sector. `sector` counts from the start of the area and is below [`COUNT`](Self::COUNT).
    fn erase(&mut self, sector: usize) -> Result<(), NorFlashErrorKind>;

    /// Programs bytes at an offset from the start of the area. Offset and length are multiples of
    /// [`WRITE_SIZE`](Self::WRITE_SIZE) and inside the area.
    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind>;
}

/// The parameter memory in the flash of a board.
pub struct ParameterFlash<S>(pub S);

impl<S> ErrorType for ParameterFlash<S> {
    type Error = NorFlashErrorKind;
}

impl<S: Sectors> ReadNorFlash for ParameterFlash<S> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        let start = S::START + offset as usize;
        for (address, byte) in (start..).zip(bytes) {
            // SAFETY: the address is in memory-mapped flash (checked against the area above), which is always readable. Volatile,
            // because the contents change by means other than stores visible to the compiler.
            *byte = unsafe { core::ptr::read_volatile(address as *const u8) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        S::SIZE * S::COUNT
    }
}

impl<S: Sectors> NorFlash for ParameterFlash<S> {
    const WRITE_SIZE: usize = S::WRITE_SIZE;
    const ERASE_SIZE: usize = S::SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        (from as usize / S::SIZE..to as usize / S::SIZE).try_for_each(|sector| self.0.erase(sector))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        self.0.program(offset as usize, bytes)
    }
}
