//! Erasing and programming the flash (RM0390).

use crate::board::{pac, supply_is_low};
use crate::flash::Sectors;
use embedded_storage::nor_flash::NorFlashErrorKind;

/// `COUNT` sectors of the flash from the address `START` on. regions.x excludes them from the program memory. The default is the parameter
/// memory: sectors 2 and 3.
///
/// It uses the registers directly, because the HAL erases 128 KiB at a time, programs single bytes and does not reset the data
/// cache.
pub struct Flash<const START: usize = 0x0800_8000, const COUNT: usize = 2>(pac::FLASH);

impl<const START: usize, const COUNT: usize> Flash<START, COUNT> {
    /// The number of the first sector, and the size of all of them: sectors 0 to 3 have 16 KiB, sectors 5 to 7 have 128 KiB (RM0390).
    const SECTORS: (u8, usize) = match START {
        0x0800_8000 => (2, 16 * 1024),
        0x0802_0000 => (5, 128 * 1024),
        _ => panic!("an area of the flash begins with sector 2 or 5"),
    };
}

impl<const START: usize, const COUNT: usize> Sectors for Flash<START, COUNT> {
    const START: usize = START;
    const SIZE: usize = Self::SECTORS.1;
    const COUNT: usize = COUNT;
    const WRITE_SIZE: usize = 4;

    fn erase(&mut self, sector: usize) -> Result<(), NorFlashErrorKind> {
        if supply_is_low() {
            return Err(NorFlashErrorKind::Other);
        }
        self.unlock();
        // `write` starts from the reset value, in which the register is locked.
        self.0.cr().write(|w| {
            w.lock().clear_bit();
            w.psize().psize32();
            w.ser().set_bit();
            // SAFETY: sectors 0 to 7 exist, and the area ends with the last one at most.
            unsafe { w.snb().bits(Self::SECTORS.0 + sector as u8) }
        });
        self.0.cr().modify(|_, w| w.strt().set_bit());
        let result = self.finish();
        // The data cache still contains the old data. It can be reset only while it is disabled (RM0390, FLASH_ACR).
        self.0.acr().modify(|_, w| w.dcen().clear_bit());
        self.0.acr().modify(|_, w| w.dcrst().set_bit());
        self.0.acr().modify(|_, w| w.dcrst().clear_bit());
        self.0.acr().modify(|_, w| w.dcen().set_bit());
        result
    }

    /// Units of words, and of a half-word where no whole word is left, so that also multiples of 2 can be programmed. All are compared
    /// with what is read back.
    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let mut address = START + offset;
        let mut rest = bytes;
        while let Some((half, after)) = rest.split_first_chunk() {
            if supply_is_low() {
                return Err(NorFlashErrorKind::Other);
            }
            let word = rest
                .split_first_chunk()
                .filter(|_| address.is_multiple_of(4));
            (address, rest) = match word {
                Some((word, after)) => (self.program_word(address, *word)?, after),
                None => (self.program_half_word(address, *half)?, after),
            };
        }
        Ok(())
    }
}

impl<const START: usize, const COUNT: usize> Flash<START, COUNT> {
    pub(crate) fn new(registers: pac::FLASH) -> Self {
        Self(registers)
    }

    /// Programs a word at this address and returns the address after it.
    fn program_word(&mut self, address: usize, word: [u8; 4]) -> Result<usize, NorFlashErrorKind> {
        let (place, word) = (address as *mut u32, u32::from_le_bytes(word));
        self.unlock();
        self.0.cr().write(|w| {
            w.lock().clear_bit();
            w.psize().psize32();
            w.pg().set_bit()
        });
        // SAFETY: the word is aligned and inside the area, which contains no other data. With PG set, a store there programs the flash.
        unsafe { place.write_volatile(word) };
        self.finish()?;
        // SAFETY: as above.
        let read = unsafe { place.read_volatile() };
        compared(read == word, address + 4)
    }

    /// Programs a half-word at this address and returns the address after it.
    fn program_half_word(
        &mut self,
        address: usize,
        half: [u8; 2],
    ) -> Result<usize, NorFlashErrorKind> {
        let (place, half) = (address as *mut u16, u16::from_le_bytes(half));
        self.unlock();
        self.0.cr().write(|w| {
            w.lock().clear_bit();
            w.psize().psize16();
            w.pg().set_bit()
        });
        // SAFETY: as for a word.
        unsafe { place.write_volatile(half) };
        self.finish()?;
        // SAFETY: as above.
        let read = unsafe { place.read_volatile() };
        compared(read == half, address + 2)
    }

    /// Unlocks the control register and clears earlier errors, which would otherwise be reported for this operation.
    fn unlock(&mut self) {
        // Each operation has locked it.
        // SAFETY: the two unlock keys of RM0390 in their order.
        self.0.keyr().write(|w| unsafe { w.bits(0x4567_0123) });
        // SAFETY: as above.
        self.0.keyr().write(|w| unsafe { w.bits(0xCDEF_89AB) });
        // SAFETY: the error flags (bits 1 and 4 to 7) are cleared by writing 1.
        self.0.sr().write(|w| unsafe { w.bits(ERRORS) });
    }

    /// Waits for the end of the operation and locks the control register.
    fn finish(&mut self) -> Result<(), NorFlashErrorKind> {
        cortex_m::asm::dsb();
        while self.0.sr().read().bsy().bit_is_set() {}
        self.0.cr().write(|w| w.lock().set_bit());
        if self.0.sr().read().bits() & ERRORS == 0 {
            Ok(())
        } else {
            Err(NorFlashErrorKind::Other)
        }
    }
}

/// The next address, if the unit before it has its value.
fn compared(same: bool, next: usize) -> Result<usize, NorFlashErrorKind> {
    match same {
        true => Ok(next),
        false => Err(NorFlashErrorKind::Other),
    }
}

/// FLASH_SR: OPERR, WRPERR, PGAERR, PGPERR and PGSERR.
const ERRORS: u32 = 0xF2;
