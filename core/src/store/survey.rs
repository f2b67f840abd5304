//! What there is in one slot: walks from record to record, and from word to word where there is none.

use super::Owner;
use super::record::{CALIBRATED, CALIBRATION_AT, CRC, HEADER, Header, Kind, calibration_owner};
use crate::measure::calibration;
use embedded_storage::nor_flash::ReadNorFlash;

/// Records begin at multiples of this.
pub(super) const WORD: usize = 4;

/// A whole record with parameters of the product. An address of 0 means that there is none: a payload is never there.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Found {
    pub sequence: u32,
    /// Where the stored parameters are,
    pub address: usize,
    /// and how many bytes they are.
    pub length: usize,
    /// Where the calibration of an old record is; 0: it is a new one.
    pub calibration: usize,
    /// The unit had a calibration when they were saved.
    pub is_calibrated: bool,
}

impl Found {
    /// The parameters of a record at this address.
    fn of(header: Header, address: usize, layout: u8) -> Self {
        let payload = address + HEADER;
        if let Kind::Old(_) = header.kind {
            let length = header.length.saturating_sub(calibration::SIZE);
            return Self {
                sequence: header.sequence,
                address: payload,
                length,
                calibration: payload + length,
                is_calibrated: true,
            };
        }
        Self {
            sequence: header.sequence,
            address: payload + 1,
            length: header.length.saturating_sub(1),
            calibration: 0,
            is_calibrated: layout & CALIBRATED != 0,
        }
    }

    /// Whether there is a record.
    pub fn is_there(&self) -> bool {
        self.address > 0
    }

    /// Whether it is newer than another one; with equal numbers it is.
    pub fn is_newer(&self, than: &Self) -> bool {
        let ahead = self.sequence.wrapping_sub(than.sequence);
        self.is_there() && (!than.is_there() || ahead < 1 << 31)
    }
}

/// What there is in one slot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Survey {
    /// Behind the last word that is not blank, from the start of the slot.
    pub used: usize,
    /// Behind the address of the last word that is neither blank nor part of a whole record of this product; 0: there is none.
    pub unusable: usize,
    /// The newest parameters.
    pub parameters: Found,
    /// Where the calibration of this unit is; 0: there is none.
    pub calibration: usize,
}

/// Looks through the slot of `size` bytes at `start`.
pub(super) fn survey(
    memory: &mut impl ReadNorFlash,
    owner: Owner,
    start: usize,
    size: usize,
) -> Survey {
    let mut survey = Survey::default();
    let mut at = 0;
    while at < size {
        let address = start + at;
        if let Some(header) = whole(memory, address, size - at)
            && survey.takes(memory, owner, address, header)
        {
            at += header.size();
            survey.used = at;
            continue;
        }
        at += WORD;
        if !is_blank(memory, address, WORD) {
            survey.unusable = address + WORD;
            survey.used = at;
        }
    }
    survey
}

impl Survey {
    /// Takes a whole record into account; false when it is of another product or layout.
    fn takes(
        &mut self,
        memory: &mut impl ReadNorFlash,
        owner: Owner,
        address: usize,
        header: Header,
    ) -> bool {
        // Layout and, of a calibration, the serial number.
        let mut begin = [0; 5];
        let read = memory.read((address + HEADER) as u32, &mut begin).is_ok();
        let [layout, ..] = begin;
        let own = match header.kind {
            Kind::Calibration => {
                if read && begin == calibration_owner(owner.serial) {
                    self.calibration = address + CALIBRATION_AT;
                }
                return true;
            }
            Kind::Parameters(of) => of == owner.image.0 && layout & !CALIBRATED == owner.layout,
            // Its layout is the first one.
            Kind::Old(of) => of == owner.image.0 && owner.layout == 1,
        };
        if read && own {
            let found = Found::of(header, address, layout);
            if found.is_newer(&self.parameters) {
                self.parameters = found;
            }
        }
        read && own
    }
}

/// The header of the whole record at an address, with at most `limit` bytes; None when there is none.
fn whole(memory: &mut impl ReadNorFlash, address: usize, limit: usize) -> Option<Header> {
    let mut bytes = [0; HEADER];
    memory.read(address as u32, &mut bytes).ok()?;
    let header = Header::parse(&bytes).filter(|header| header.size() <= limit)?;
    let mut digest = CRC.digest();
    let end = address + header.checked_size();
    let mut word = [0; WORD];
    for at in (address..end).step_by(WORD) {
        memory.read(at as u32, &mut word).ok()?;
        digest.update(&word);
    }
    memory.read(end as u32, &mut word).ok()?;
    (digest.finalize() == u32::from_le_bytes(word)).then_some(header)
}

/// Whether so many bytes, a multiple of [`WORD`], are erased.
pub(super) fn is_blank(memory: &mut impl ReadNorFlash, address: usize, size: usize) -> bool {
    (address..address + size).step_by(WORD).all(|address| {
        let mut word = [0; WORD];
        memory.read(address as u32, &mut word).is_ok() && word == [0xFF; WORD]
    })
}
