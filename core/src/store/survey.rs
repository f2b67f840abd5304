//! The contents of one slot: reads record after record, and word after word where there is no valid record.

use super::record::{
    CALIBRATION_AT, CALIBRATION_OWNER, DEVICE_BEGIN, HEADER, Header, Kind, PARAMETERS_OWNER,
    USAGE_SIZE, calibration_owner, crc32, usage_owner,
};
use super::{Buffer, Owner, unit, usage};
use crate::measure::calibration;
use embedded_storage::nor_flash::ReadNorFlash;

/// The alignment of records in bytes.
pub(super) const WORD: usize = 4;

/// A valid record with parameters of the product. Address 0 means that there is none: a payload is never at address 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Found {
    pub sequence: u32,
    /// The address of the stored parameters.
    pub address: usize,
    /// The length of the stored parameters in bytes.
    pub length: usize,
    /// The calibration in an old record.
    pub calibration: Place,
    /// The check of the records that the device had when they were saved; 0: it had none, or they are in this record.
    pub check: u8,
}

impl Found {
    pub const NONE: Self = Self {
        sequence: 0,
        address: 0,
        length: 0,
        calibration: Place::NONE,
        check: 0,
    };

    /// The parameters in the record at this address.
    fn of(header: Header, address: usize, check: u8) -> Self {
        let payload = address + HEADER;
        if let Kind::Old(_) = header.kind {
            let length = header
                .length
                .saturating_sub(calibration::ACCELEROMETER_SIZE);
            return Self {
                sequence: header.sequence,
                address: payload,
                length,
                calibration: Place {
                    address: payload + length,
                    length: calibration::ACCELEROMETER_SIZE,
                },
                check: 0,
            };
        }
        Self {
            sequence: header.sequence,
            address: payload + PARAMETERS_OWNER,
            length: header.length.saturating_sub(PARAMETERS_OWNER),
            calibration: Place::NONE,
            check,
        }
    }

    /// Whether there is a record.
    pub fn is_there(&self) -> bool {
        self.address > 0
    }

    /// Whether it is newer than another one, or has the same sequence number.
    pub fn is_newer(&self, than: &Self) -> bool {
        let ahead = self.sequence.wrapping_sub(than.sequence);
        self.is_there() && (!than.is_there() || ahead < 1 << 31)
    }
}

/// The contents of one slot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Survey {
    /// The end of the last word that is not blank, relative to the start of the slot.
    pub used: usize,
    /// The end address of the last word that is neither blank nor part of a valid record of this product; 0: there is none.
    pub unusable: usize,
    /// The newest valid parameters of this product.
    pub parameters: Found,
    /// The newest calibration of this device.
    pub calibration: Place,
    /// The newest identity of this device.
    pub unit: Place,
    /// The address of the newest usage of this device; 0: there is none.
    pub usage: usize,
    /// A calibration or an identity at the start of the slot whose first word is not complete: the copy of one, or a damaged one.
    pub torn: [Place; 2],
    /// The sequence number of the newest one of these three.
    pub device_sequence: u32,
}

/// The payload of a record; address 0: there is none.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Place {
    pub address: usize,
    pub length: usize,
}

impl Place {
    pub const NONE: Self = Self {
        address: 0,
        length: 0,
    };
}

/// Reads the slot of `size` bytes at `start`.
pub(super) fn survey<B: Buffer>(
    memory: &mut impl ReadNorFlash,
    owner: Owner,
    start: usize,
    size: usize,
) -> Survey {
    let mut survey = Survey::default();
    let mut at = 0;
    let mut follows_blank = false;
    // The end of what was not completed with a usage because of a power cut: the record, or at the start of a slot the copy of all records. Its
    // first word is programmed last; the first word of an incomplete save is never blank.
    let mut cut_until = 0;
    while at < size {
        let address = start + at;
        if let Some(header) = valid_record(memory, address, None, size - at)
            && survey.takes::<B>(memory, owner, address, header)
        {
            at += header.size();
            survey.used = at;
            follows_blank = false;
            continue;
        }
        if is_blank(memory, address, WORD) {
            follows_blank = true;
            at += WORD;
            continue;
        }
        if B::USAGE && at >= cut_until {
            if follows_blank {
                cut_until = if at == WORD {
                    size
                } else {
                    at - WORD + USAGE_SIZE
                };
            } else if let Some(header) =
                valid_record(memory, address, Some(DEVICE_BEGIN), size - at)
            {
                let mut torn = Survey::default();
                torn.takes::<B>(memory, owner, address, header);
                if at == 0 || torn.usage > 0 {
                    cut_until = at + header.size();
                }
                if at == 0 {
                    survey.torn = [torn.calibration, torn.unit];
                }
            }
        }
        follows_blank = false;
        at += WORD;
        survey.used = at;
        if at > cut_until {
            survey.unusable = start + at;
        }
    }
    survey
}

impl Survey {
    /// Whether it contains a record of the device.
    fn has_device(&self) -> bool {
        self.calibration.address > 0 || self.unit.address > 0 || self.usage > 0
    }

    /// Whether its records of the device are newer than those of another slot.
    pub fn has_newer_device(&self, than: &Self) -> bool {
        let ahead = self.device_sequence.wrapping_sub(than.device_sequence);
        self.has_device() && (!than.has_device() || ahead < 1 << 31)
    }

    /// Adds a valid record. Returns false if it has another product or layout.
    fn takes<B: Buffer>(
        &mut self,
        memory: &mut impl ReadNorFlash,
        owner: Owner,
        address: usize,
        header: Header,
    ) -> bool {
        // The layout and the check of parameters, or the owner of a record of the device.
        let mut begin = [0; 5];
        let read = memory.read((address + HEADER) as u32, &mut begin).is_ok();
        let [layout, check, ..] = begin;
        let own = match header.kind {
            Kind::Device => {
                let is_unit = begin.starts_with(&unit::owner_of(owner.image));
                if read && begin == calibration_owner(owner.serial) {
                    let length = header.length.saturating_sub(CALIBRATION_OWNER);
                    self.calibration = Place {
                        address: address + CALIBRATION_AT,
                        length: length.min(calibration::SIZE),
                    };
                    self.device_sequence = header.sequence;
                } else if read && is_unit && header.length <= unit::SIZE {
                    self.unit = Place {
                        address: address + HEADER,
                        length: header.length,
                    };
                    self.device_sequence = header.sequence;
                } else if B::USAGE
                    && read
                    && begin == usage_owner(owner.serial)
                    && header.length == usage::SIZE
                {
                    self.usage = address + HEADER;
                    self.device_sequence = header.sequence;
                }
                return true;
            }
            Kind::Parameters(of) => of == owner.image.0 && layout == owner.layout,
            // Old records have layout 1.
            Kind::Old(of) => of == owner.image.0 && owner.layout == 1,
        };
        if read && own {
            let found = Found::of(header, address, check);
            if found.is_newer(&self.parameters) {
                self.parameters = found;
            }
        }
        read && own
    }
}

/// The header of the valid record at an address, with at most `limit` bytes, and with this first word in place of that in the memory; None if
/// there is none.
fn valid_record(
    memory: &mut impl ReadNorFlash,
    address: usize,
    first: Option<u32>,
    limit: usize,
) -> Option<Header> {
    let mut bytes = [0; HEADER];
    memory.read(address as u32, &mut bytes).ok()?;
    if let Some(first) = first {
        *bytes.first_chunk_mut()? = first.to_le_bytes();
    }
    let header = Header::parse(&bytes).filter(|header| header.size() <= limit)?;
    let mut crc = 0;
    let mut at = address;
    let end = address + header.checked_size();
    while at < end {
        let word = match first {
            Some(first) if at == address => first,
            _ => read_word(memory, at)?,
        };
        crc = crc32(crc, &word.to_le_bytes());
        at += WORD;
    }
    (read_word(memory, end)? == crc).then_some(header)
}

/// The word at an address; None if it cannot be read.
pub(super) fn read_word(memory: &mut impl ReadNorFlash, address: usize) -> Option<u32> {
    let mut word = [0; WORD];
    memory.read(address as u32, &mut word).ok()?;
    Some(u32::from_le_bytes(word))
}

/// Whether `size` bytes, a multiple of [`WORD`], are erased.
pub(super) fn is_blank(memory: &mut impl ReadNorFlash, address: usize, size: usize) -> bool {
    let mut at = address;
    while at < address + size {
        if read_word(memory, at) != Some(u32::MAX) {
            return false;
        }
        at += WORD;
    }
    true
}
