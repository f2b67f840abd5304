//! The parameter memory: the flash of the STM32F446.

use crate::board::{pac, supply_is_low};
use crate::flash::Sectors;
use embedded_storage::nor_flash::NorFlashErrorKind;

/// Sectors 2 and 3 of the flash. regions.x excludes them from the program memory.
///
/// It uses the registers directly, because the HAL erases 128 KiB at a time, programs single bytes and does not reset the data
/// cache.
pub struct Flash(pac::FLASH);

/// The number of the first sector.
const FIRST_SECTOR: u8 = 2;

impl Sectors for Flash {
    const START: usize = 0x0800_8000;
    const SIZE: usize = 16 * 1024;
    const COUNT: usize = 2;
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
            // SAFETY: sectors 0 to 7 exist, and this is 2 or 3.
            unsafe { w.snb().bits(FIRST_SECTOR + sector as u8) }
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

    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let (words, _) = bytes.as_chunks::<4>();
        for (index, word) in words.iter().enumerate() {
            if supply_is_low() {
                return Err(NorFlashErrorKind::Other);
            }
            self.unlock();
            self.0.cr().write(|w| {
                w.lock().clear_bit();
                w.psize().psize32();
                w.pg().set_bit()
            });
            let address = (Self::START + offset + 4 * index) as *mut u32;
            // SAFETY: the caller has checked that the word is aligned and inside the parameter area, which contains no other
            // data. With PG set, a store there programs the flash.
            unsafe { address.write_volatile(u32::from_ne_bytes(*word)) };
            self.finish()?;
        }
        Ok(())
    }
}

impl Flash {
    pub(super) fn new(registers: pac::FLASH) -> Self {
        Self(registers)
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

/// FLASH_SR: OPERR, WRPERR, PGAERR, PGPERR and PGSERR.
const ERRORS: u32 = 0xF2;
