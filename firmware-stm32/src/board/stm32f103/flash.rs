//! Erasing and programming the flash (PM0075).

use super::pac;
use crate::board::{PARAMETERS, supply_is_low};
use crate::flash::Sectors;
use embedded_storage::nor_flash::NorFlashErrorKind;

/// `COUNT` pages of the flash from the address `START` on. regions.x excludes them from the program memory. The default is the parameter
/// memory: the last two pages.
pub struct Flash<const START: usize = PARAMETERS, const COUNT: usize = 2>(pac::FLASH);

impl<const START: usize, const COUNT: usize> Flash<START, COUNT> {
    pub(crate) fn new(registers: pac::FLASH) -> Self {
        Self(registers)
    }

    fn unlock(&mut self) {
        // SAFETY: the two unlock keys of PM0075 in their order.
        self.0.keyr().write(|w| unsafe { w.bits(0x4567_0123) });
        // SAFETY: as above.
        self.0.keyr().write(|w| unsafe { w.bits(0xCDEF_89AB) });
    }

    /// Waits for the end of the operation.
    fn wait(&mut self) {
        // BSY is set one cycle after the store that starts the operation (errata sheet ES096), which can still be in the write buffer.
        cortex_m::asm::dsb();
        while self.0.sr().read().bsy().bit_is_set() {}
    }

    /// Locks the control register and compares half-words with what is read back: this finds all errors of the operation.
    fn finish(
        &mut self,
        address: usize,
        mut expected: impl Iterator<Item = u16>,
    ) -> Result<(), NorFlashErrorKind> {
        // SAFETY: the error flags are cleared by writing 1.
        self.0
            .sr()
            .write(|w| w.pgerr().set_bit().wrprterr().set_bit());
        self.0.cr().write(|w| w.lock().set_bit());
        let mut place = address as *const u16;
        let same = expected.all(|half_word| {
            // SAFETY: the address is in the area. Volatile, because the flash changes by other means than stores.
            let read = unsafe { place.read_volatile() };
            place = place.wrapping_add(1);
            read == half_word
        });
        if same {
            Ok(())
        } else {
            Err(NorFlashErrorKind::Other)
        }
    }
}

impl<const START: usize, const COUNT: usize> Sectors for Flash<START, COUNT> {
    const START: usize = START;
    const SIZE: usize = 1024;
    const COUNT: usize = COUNT;
    const WRITE_SIZE: usize = 2;

    fn erase(&mut self, sector: usize) -> Result<(), NorFlashErrorKind> {
        if supply_is_low() {
            return Err(NorFlashErrorKind::Other);
        }
        let address = Self::START + sector * Self::SIZE;
        self.unlock();
        self.0.cr().write(|w| w.lock().clear_bit().per().set_bit());
        // SAFETY: the page is in the area, which contains no other data.
        self.0.ar().write(|w| unsafe { w.bits(address as u32) });
        self.0.cr().modify(|_, w| w.strt().set_bit());
        self.wait();
        self.finish(address, core::iter::repeat_n(0xFFFF, Self::SIZE / 2))
    }

    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let address = Self::START + offset;
        let half_words = bytes
            .as_chunks()
            .0
            .iter()
            .map(|&bytes| u16::from_le_bytes(bytes));
        self.unlock();
        self.0.cr().write(|w| w.lock().clear_bit().pg().set_bit());
        let mut place = address as *mut u16;
        for half_word in half_words.clone() {
            if supply_is_low() {
                // The comparison finds the missing half-words.
                break;
            }
            // SAFETY: the caller has checked that the half-word is aligned and inside the area, which contains no
            // other data. With PG set, a store there programs the flash.
            unsafe { place.write_volatile(half_word) };
            place = place.wrapping_add(1);
            self.wait();
        }
        self.finish(address, half_words)
    }
}
