//! A microcontroller's flash memory: two pages as on the STM32F103 or two sectors as on the STM32F446, with a fuse that cuts the
//! power and with faults.
//!
//! The rules of the real memory apply. The STM32F103 is programmed in half-words, and only an erased half-word can be programmed,
//! except to 0000h (reference manual RM0008/PM0075: PGERR). On the STM32F446 a unit of one to eight bytes can be programmed again:
//! then its bits can only change to 0 (RM0390, section 3.6). A memory is erased in pages. A power cut leaves an operation
//! incomplete.

use super::flash_file::{FlashFile, first_bytes};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use std::fs::File;
use std::io;
use std::path::Path;

/// Size of an erase unit of the STM32F103, in bytes.
pub const PAGE_SIZE: usize = 1024;

/// The pages of a memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Geometry {
    /// The size of each of the two pages, in bytes.
    pub page_size: usize,
    /// Only an erased half-word can be programmed, except to 0000h.
    pub once_only: bool,
}

impl Geometry {
    /// Two pages of the STM32F103.
    pub const STM32F103: Self = Self {
        page_size: PAGE_SIZE,
        once_only: true,
    };

    /// Two sectors of 16 KiB of the STM32F446.
    pub const STM32F446: Self = Self {
        page_size: 16 * 1024,
        once_only: false,
    };

    /// The size of both pages, in bytes.
    pub const fn size(self) -> usize {
        2 * self.page_size
    }
}

/// The reason for a failed operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FlashError {
    /// The power is off.
    PowerCut,
    /// A half-word that is not erased cannot be programmed to anything but 0000h (STM32F103).
    NotErased,
    /// The memory is faulty, or its file cannot be written.
    Broken,
    /// Out of bounds, or not aligned.
    Address(NorFlashErrorKind),
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Address(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// When the power is cut.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Fuse {
    /// While a byte is programmed, after this many others.
    Byte(u64),
    /// While a page is erased, after this many others.
    Erase(u64),
    /// While a unit is programmed or a page is erased, after this many of both.
    Operation(u64),
}

/// Two pages of flash.
#[derive(Debug)]
pub struct Flash {
    geometry: Geometry,
    bytes: Vec<u8>,
    file: Option<FlashFile>,
    fuse: Option<Fuse>,
    cut: bool,
    fail_writes: bool,
    fail_erases: bool,
    worn: Vec<usize>,
    programmed: u64,
    erased: u64,
    last: Option<usize>,
    random: u64,
}

impl Default for Flash {
    /// An erased memory of the STM32F103.
    fn default() -> Self {
        Self::blank(Geometry::STM32F103)
    }
}

impl Flash {
    /// A memory of the STM32F103 with this content.
    ///
    /// # Panics
    /// When the size is not that of the memory.
    pub fn new(bytes: Vec<u8>) -> Self {
        Self::with_content(Geometry::STM32F103, bytes)
    }

    /// An erased memory.
    pub fn blank(geometry: Geometry) -> Self {
        Self::with_content(geometry, vec![0xFF; geometry.size()])
    }

    /// A memory with this content.
    ///
    /// # Panics
    /// When the size is not that of the memory.
    pub fn with_content(geometry: Geometry, bytes: Vec<u8>) -> Self {
        let size = geometry.page_size;
        assert_eq!(bytes.len(), geometry.size(), "two pages of {size} bytes");
        Self {
            geometry,
            bytes,
            file: None,
            fuse: None,
            cut: false,
            fail_writes: false,
            fail_erases: false,
            worn: Vec::new(),
            programmed: 0,
            erased: 0,
            last: None,
            random: 0x9E37_79B9_7F4A_7C15,
        }
    }

    /// A memory in a file: erased when the file does not exist yet; every change is written to the file. While the file cannot be
    /// written, programming and erasing fail.
    ///
    /// # Errors
    /// The file exists but cannot be read, is in use by another program ([`io::ErrorKind::ResourceBusy`]), or is longer than the
    /// memory ([`io::ErrorKind::InvalidData`]).
    pub fn in_file(geometry: Geometry, path: &Path) -> io::Result<Self> {
        let (file, bytes) = FlashFile::open(path, geometry.size())?;
        let bytes = bytes.unwrap_or_else(|| vec![0xFF; geometry.size()]);
        Ok(Self {
            file: Some(file),
            ..Self::with_content(geometry, bytes)
        })
    }

    /// A memory with the first bytes of a file, which is not changed: programming and erasing fail.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read_only(geometry: Geometry, path: &Path) -> io::Result<Self> {
        let size = geometry.size();
        let mut bytes = first_bytes(&File::open(path)?, size)?;
        bytes.resize(size, 0xFF);
        Ok(Self {
            fail_writes: true,
            fail_erases: true,
            ..Self::with_content(geometry, bytes)
        })
    }

    /// The pages.
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// The content of the memory.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes programmed so far.
    pub fn programmed(&self) -> u64 {
        self.programmed
    }

    /// Pages erased so far.
    pub fn erased(&self) -> u64 {
        self.erased
    }

    /// Sets the fuse: the power is cut while a byte is programmed, after `others` more bytes. Some bits of that byte are
    /// programmed, no later byte is, and every operation fails until [`power_on`](Self::power_on).
    pub fn cut_in_byte_after(&mut self, others: u64) {
        self.fuse = Some(Fuse::Byte(others));
    }

    /// Sets the fuse: the power is cut while a page is erased, after `others` more pages. The page is left in one of the states
    /// of an incomplete erase, selected by `seed`.
    pub fn cut_in_erase_after(&mut self, others: u64, seed: u64) {
        self.fuse = Some(Fuse::Erase(others));
        self.stir(seed);
    }

    /// Sets the fuse: the power is cut while a unit is programmed or a page is erased, after `others` more of both. `seed`
    /// selects the content that remains.
    pub fn cut_in_operation_after(&mut self, others: u64, seed: u64) {
        self.fuse = Some(Fuse::Operation(others));
        self.stir(seed);
    }

    /// True when the fuse has blown and the power is off.
    pub fn is_cut(&self) -> bool {
        self.cut
    }

    /// Switches the power on again and removes the fuse.
    pub fn power_on(&mut self) {
        self.cut = false;
        self.fuse = None;
    }

    /// Makes every attempt to program fail without a change.
    pub fn fail_writes(&mut self, fail: bool) {
        self.fail_writes = fail;
    }

    /// Makes every attempt to erase fail without a change.
    pub fn fail_erases(&mut self, fail: bool) {
        self.fail_erases = fail;
    }

    /// Wears out a bit: it can no longer be programmed to 0, and the memory reports no error.
    pub fn wear_out(&mut self, bit: usize) {
        self.worn.push(bit);
    }

    /// Flips one bit.
    ///
    /// # Errors
    /// The file of the memory cannot be written.
    pub fn flip_bit(&mut self, bit: usize) -> Result<(), FlashError> {
        let at = bit / 8;
        self.put(at, &[self.bytes[at] ^ 1 << (bit % 8)])
    }

    /// Flips a bit in the unit that was programmed last, that is, in the newest record. False when nothing has been
    /// programmed yet.
    pub fn corrupt_newest(&mut self) -> bool {
        self.last.is_some_and(|at| self.flip_bit(8 * at).is_ok())
    }

    /// Changes bytes in the memory and in the file; in neither when the file cannot be written.
    fn put(&mut self, at: usize, bytes: &[u8]) -> Result<(), FlashError> {
        let range = at..at + bytes.len();
        if let Some(file) = &self.file {
            let mut after = self.bytes.clone();
            after[range.clone()].copy_from_slice(bytes);
            file.write(&after, range.clone())
                .map_err(|_| FlashError::Broken)?;
        }
        self.bytes[range].copy_from_slice(bytes);
        Ok(())
    }

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
            self.programmed += 1;
        }
        for bit in &self.worn {
            if let Some(index) = (bit / 8).checked_sub(at).filter(|index| *index < new.len()) {
                new[index] |= old[index] & 1 << (bit % 8);
            }
        }
        self.put(at, &new)?;
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
            return Err(FlashError::Broken);
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
            return Err(FlashError::Broken);
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

    /// The content of a page after an incomplete erase: its first part erased, or some bytes, or single bits; or the complete
    /// page, or nothing yet.
    fn half_erased(&mut self, at: usize) -> Vec<u8> {
        let size = self.geometry.page_size;
        let mut page = self.bytes[at..at + size].to_vec();
        match self.random() % 5 {
            0 => {}
            1 => page.fill(0xFF),
            2 => {
                let length = self.random() as usize % size;
                page[..length].fill(0xFF);
            }
            3 => {
                for byte in &mut page {
                    *byte |= if self.random().is_multiple_of(2) {
                        0xFF
                    } else {
                        0
                    };
                }
            }
            _ => {
                for byte in &mut page {
                    *byte |= self.random() as u8;
                }
            }
        }
        page
    }

    /// Counts an operation; true when the fuse blows in it.
    fn operation_blows(&mut self) -> bool {
        match &mut self.fuse {
            Some(Fuse::Operation(0)) => self.cut = true,
            Some(Fuse::Operation(others)) => *others -= 1,
            _ => {}
        }
        self.cut
    }

    /// Mixes `seed` into the state of the random numbers.
    fn stir(&mut self, seed: u64) {
        self.random ^= seed.wrapping_mul(0xD134_2543_DE82_EF95);
    }

    /// The next number of a xorshift generator: the upper half, whose bits are of better quality.
    fn random(&mut self) -> u32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 32) as u32
    }

    fn powered(&self) -> Result<(), FlashError> {
        if self.cut {
            return Err(FlashError::PowerCut);
        }
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
            return Err(FlashError::Broken);
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
            return Err(FlashError::Broken);
        }
        (from as usize..to as usize)
            .step_by(PAGE_SIZE)
            .try_for_each(|at| self.erase_page(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Erases a page and programs three half-words, until the power is cut.
    fn work(flash: &mut Flash) -> Result<(), FlashError> {
        flash.erase(0, PAGE_SIZE as u32)?;
        (0..3).try_for_each(|at| flash.write(2 * at, &[0x12, 0x34]))
    }

    #[test]
    fn operation_fuse_counts_erases_and_half_words() {
        for others in 0..5 {
            let mut flash = Flash::default();
            flash.cut_in_operation_after(others, 1);
            let result = work(&mut flash);
            assert_eq!(result.is_err(), others < 4);
            assert_eq!(flash.is_cut(), others < 4);
            assert_eq!(flash.erased(), others.min(1));
            assert_eq!(flash.programmed(), 2 * others.saturating_sub(1).min(3));
        }
    }

    #[test]
    fn sector_is_programmed_again_towards_0() {
        let mut flash = Flash::blank(Geometry::STM32F446);
        assert_eq!(
            flash.program_unit(0x4000, &[0x12, 0x34, 0xF6, 0x78]),
            Ok(())
        );
        assert_eq!(flash.program_unit(0x4002, &[0x0F]), Ok(()));
        assert_eq!(
            flash.bytes()[0x4000..0x4005],
            [0x12, 0x34, 0x06, 0x78, 0xFF]
        );
        assert_eq!(flash.erase_page_at(0x4000), Ok(()));
        assert_eq!(flash.bytes(), [0xFF; 0x8000]);
        assert_eq!((flash.programmed(), flash.erased()), (5, 1));
    }

    #[test]
    fn power_cut_leaves_half_word_between_old_and_new_value() {
        for seed in 0..100 {
            let mut flash = Flash::default();
            flash.cut_in_operation_after(0, seed);
            assert_eq!(flash.write(0, &[0x0F, 0xF0]), Err(FlashError::PowerCut));
            assert_eq!(
                [flash.bytes()[0] & 0x0F, flash.bytes()[1] & 0xF0],
                [0x0F, 0xF0]
            );
        }
    }
}
