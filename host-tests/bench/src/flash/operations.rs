//! The operations of the driver: programming, erasing and reading, with their faults.

use super::faults::Fuse;
use super::{Flash, FlashError, PAGE_SIZE};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, ReadNorFlash, check_erase, check_read, check_write,
};

impl Flash {
    /// Programs one unit: two bytes on the STM32F103, one to eight on the STM32F446. The fuse may blow in each of its bytes.
    fn program(&mut self, at: usize, value: &[u8]) -> Result<(), FlashError> {
        let range = at..at + value.len();
        let old = self.bytes[range].to_vec();
        let is = |bytes: &[u8], byte: u8| bytes.iter().all(|one| *one == byte);
        if self.geometry.once_only && !is(&old, 0xFF) && !is(value, 0) {
            return Err(FlashError::NotErased);
        }
        if self.operation_blows() {
            let mut half_done = old;
            for (half_done, value) in half_done.iter_mut().zip(value) {
                *half_done &= value | self.random() as u8;
            }
            self.put(at, &half_done)?;
            self.last = Some(at);
            return Err(FlashError::PowerCut);
        }
        let mut new = old.clone();
        let mut programmed = 0;
        for (new, value) in new.iter_mut().zip(value) {
            if self.fuse == Some(Fuse::Byte(0)) {
                *new &= value | self.random() as u8;
                self.cut = true;
                break;
            }
            if let Some(Fuse::Byte(others)) = &mut self.fuse {
                *others -= 1;
            }
            *new &= value;
            programmed += 1;
        }
        for bit in &self.worn {
            if let Some(index) = (bit / 8).checked_sub(at).filter(|index| *index < new.len()) {
                new[index] |= old[index] & 1 << (bit % 8);
            }
        }
        self.put(at, &new)?;
        self.programmed += programmed;
        self.last = Some(at);
        if self.cut {
            return Err(FlashError::PowerCut);
        }
        Ok(())
    }

    /// Programs one unit of this length at an offset, as the flash interface of a microcontroller does.
    ///
    /// # Errors
    /// [`FlashError`].
    ///
    /// # Panics
    /// When the unit is not in the memory.
    pub fn program_unit(&mut self, offset: usize, value: &[u8]) -> Result<(), FlashError> {
        self.powered()?;
        if self.fail_writes {
            return Err(self.broken());
        }
        self.program(offset, value)
    }

    /// Erases the page at an offset, as the flash interface of a microcontroller does.
    ///
    /// # Errors
    /// [`FlashError`].
    ///
    /// # Panics
    /// When there is no page at the offset.
    pub fn erase_page_at(&mut self, offset: usize) -> Result<(), FlashError> {
        self.powered()?;
        if self.fail_erases {
            return Err(self.broken());
        }
        self.erase_page(offset)
    }

    /// Erases one page; the fuse may blow in it.
    fn erase_page(&mut self, at: usize) -> Result<(), FlashError> {
        if self.fuse == Some(Fuse::Erase(0)) || self.operation_blows() {
            let half_done = self.half_erased(at);
            self.cut = true;
            self.put(at, &half_done)?;
            return Err(FlashError::PowerCut);
        }
        if let Some(Fuse::Erase(others)) = &mut self.fuse {
            *others -= 1;
        }
        self.put(at, &vec![0xFF; self.geometry.page_size])?;
        self.erased += 1;
        Ok(())
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.powered()?;
        check_read(self, offset, bytes.len()).map_err(FlashError::Address)?;
        let at = offset as usize;
        bytes.copy_from_slice(&self.bytes[at..at + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.geometry.size()
    }
}

/// For sensors built for the PC, which have the memory of the STM32F103.
impl NorFlash for Flash {
    const WRITE_SIZE: usize = 2;
    const ERASE_SIZE: usize = PAGE_SIZE;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.powered()?;
        check_write(self, offset, bytes.len()).map_err(FlashError::Address)?;
        if self.fail_writes {
            return Err(self.broken());
        }
        for (index, pair) in bytes.chunks_exact(2).enumerate() {
            self.program(offset as usize + 2 * index, pair)?;
        }
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.powered()?;
        check_erase(self, from, to).map_err(FlashError::Address)?;
        if self.fail_erases {
            return Err(self.broken());
        }
        (from as usize..to as usize)
            .step_by(PAGE_SIZE)
            .try_for_each(|at| self.erase_page(at))
    }
}
