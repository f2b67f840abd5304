//! The parameter memory: two sectors of the internal flash, as embedded-storage's [`NorFlash`].
//!
//! Addresses count from the start of the area. Interrupts stay enabled, but both parts stall instruction fetches while they erase
//! (Blue Pill up to 40 ms, Nucleo up to 500 ms) or program (70 us a half-word, 100 us a word, at the most); bxCAN goes on
//! receiving into its three-frame FIFO.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// What differs between the parts: an area of flash in `COUNT` sectors of `SIZE` bytes each.
pub trait Sectors {
    /// The address of the first byte.
    const START: usize;
    /// Bytes in a sector.
    const SIZE: usize;
    /// The number of sectors.
    const COUNT: usize;
    /// The smallest write in bytes.
    const WRITE_SIZE: usize;

    /// Erases one sector, counted from the start of the area; it is within [`COUNT`](Self::COUNT).
    fn erase(&mut self, sector: usize) -> Result<(), NorFlashErrorKind>;

    /// Programs bytes at an offset from the start of the area, both multiples of [`WRITE_SIZE`](Self::WRITE_SIZE) and inside it.
    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind>;
}

/// The parameter memory on a board's flash.
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
            // SAFETY: the address lies in memory-mapped flash (checked against the area above), which is always readable.
            // Volatile, since it changes by other means than stores that the compiler sees.
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
