//! The pages of the flash: the slots of programs and the boot record.

use crate::board::{Flash, LAYOUT, clock_crc_unit, pac};
use crate::flash::Sectors;
#[cfg(feature = "signature")]
use plumbline::update::PublicKey;
use plumbline::update::record;
use plumbline::update::{Program, Record, Slot, SlotError};

/// The address of the program.
pub const PROGRAM: usize = LAYOUT.start as usize;
/// The address of the slot that takes a download: the second one, if there are two.
pub const DOWNLOAD: usize = match LAYOUT.download {
    Some(download) => download as usize,
    None => PROGRAM,
};
/// The size of a page in bytes. Both slots and the boot record are whole pages.
const PAGE: usize = <Flash<PROGRAM, 1> as Sectors>::SIZE;
/// The part of its page that the boot record uses.
const RECORD: usize = 1024;
/// The number of pages up to that of the boot record.
const COUNT: usize = (LAYOUT.record as usize - PROGRAM) / PAGE + 1;

/// The pages of the slot at `START`, and that of the boot record.
pub struct Pages<const START: usize>(Flash<PROGRAM, COUNT>);

/// The slot from which the program runs.
pub type Running = Pages<PROGRAM>;
/// The slot that takes a download.
pub type Download = Pages<DOWNLOAD>;

impl<const START: usize> Pages<START> {
    /// The number of the first page, from that of the program on.
    const FIRST: usize = (START - PROGRAM) / PAGE;
    /// The number of the page of the boot record, from the first page on.
    const RECORD: usize = (LAYOUT.record as usize - START) / PAGE;

    /// # Safety
    /// No other operation of the flash runs at the same time.
    pub unsafe fn take() -> Self {
        // SAFETY: as the caller promises.
        Self(Flash::new(unsafe { pac::FLASH::steal() }))
    }

    /// The contents of the page of the boot record.
    fn record_page(&self) -> &[u8; RECORD] {
        // SAFETY: flash, which is always readable, and does not change while this is borrowed.
        unsafe { &*(LAYOUT.record as *const [u8; RECORD]) }
    }

    /// The newest boot record.
    pub fn newest_record(&self) -> Option<Record> {
        record::newest(self.record_page(), crc)
    }

    /// Stores a boot record, unless it is the newest one.
    pub fn keep(&mut self, record: &Record) -> Result<(), SlotError> {
        if self.newest_record().as_ref() == Some(record) {
            return Ok(());
        }
        let place = match record::next_place(self.record_page()) {
            Some(place) => place,
            None => {
                self.erase(Self::RECORD)?;
                0
            }
        };
        self.program(Self::RECORD * PAGE + place, record.bytes())
    }
}

impl<const START: usize> Slot for Pages<START> {
    const PAGE: usize = PAGE;
    const SIZE: usize = LAYOUT.size;
    #[cfg(feature = "signature")]
    const SIGNATURES: bool = true;

    #[cfg(feature = "signature")]
    fn key(&self) -> Option<&PublicKey> {
        // SAFETY: flash, which is always readable and does not change while this program runs. All values are valid.
        let key = unsafe { &*(LAYOUT.key as *const PublicKey) };
        (!key.is_erased()).then_some(key)
    }

    fn other(&self) -> Program {
        match START {
            PROGRAM => Program::None,
            // SAFETY: it only reads.
            _ => Program::of(&unsafe { Running::take() }),
        }
    }

    fn bytes(&self) -> &[u8] {
        // SAFETY: flash, which is always readable, and does not change while this is borrowed.
        unsafe { &*(START as *const [u8; LAYOUT.size]) }
    }

    fn erase(&mut self, page: usize) -> Result<(), SlotError> {
        self.0.erase(Self::FIRST + page).map_err(|_| SlotError)
    }

    fn program(&mut self, place: usize, bytes: &[u8]) -> Result<(), SlotError> {
        let place = Self::FIRST * PAGE + place;
        self.0.program(place, bytes).map_err(|_| SlotError)
    }

    fn crc(&self, parts: &[&[u8]]) -> u32 {
        crc(parts)
    }
}

/// By the CRC unit, which takes a word in four cycles. Its clock is off afterwards, as after a reset.
pub fn crc(parts: &[&[u8]]) -> u32 {
    // SAFETY: this is the only code that uses it.
    let unit = unsafe { pac::CRC::steal() };
    clock_crc_unit(true);
    cortex_m::asm::dsb();
    // SAFETY: RESET is bit 0.
    unit.cr().write(|w| unsafe { w.bits(1) });
    for part in parts {
        for word in part.as_chunks().0 {
            // SAFETY: all values of the register are valid.
            unit.dr()
                .write(|w| unsafe { w.bits(u32::from_le_bytes(*word)) });
        }
    }
    let crc = unit.dr().read().bits();
    clock_crc_unit(false);
    crc
}
