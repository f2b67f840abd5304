//! One record as it lies in memory; the byte map is in [`store`](super).

use super::Owner;
use crate::measure::calibration;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

const MAGIC: u8 = b'P';
/// The version of everything but the payload.
const VERSION: u8 = 1;

/// The size of what stands before the payload.
pub(super) const HEADER: usize = 10;
const CRC_SIZE: usize = 4;

/// The kind of a calibration; no product has this [`ImageId`](super::ImageId).
const CALIBRATION: u16 = 0;
/// Set in the kind of parameters whose payload begins with the layout. Without it, the payload is parameters, then calibration.
const WITH_LAYOUT: u16 = 0x8000;
/// The layout of a calibration's payload.
const CALIBRATION_LAYOUT: u8 = 1;
/// What stands before the calibration in its payload: layout and serial number.
const CALIBRATION_OWNER: usize = 5;
const CALIBRATION_PAYLOAD: usize = CALIBRATION_OWNER + calibration::SIZE;

/// Set in the layout of parameters that were saved by a unit with a calibration.
pub(super) const CALIBRATED: u8 = 0x80;

/// The size in bytes of the record of a calibration.
pub(super) const CALIBRATION_SIZE: usize = size(CALIBRATION_PAYLOAD);

// The table-driven variant would cost 1 KiB of flash to save a millisecond at boot.
pub(super) const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The size in bytes of a record with a payload of `payload` bytes; a multiple of 4.
const fn size(payload: usize) -> usize {
    (HEADER + payload).next_multiple_of(4) + CRC_SIZE
}

/// The size of the buffer of a [`Store`](super::Store) for the parameters of a product with so many stored bytes: the record of the
/// calibration, then that of the parameters.
pub const fn buffer_size(stored: usize) -> usize {
    CALIBRATION_SIZE + size(1 + stored)
}

/// What a record is, as far as its header tells.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// Parameters of the product with this number.
    Parameters(u16),
    /// Parameters of the product with this number, then the calibration.
    Old(u16),
    /// A calibration.
    Calibration,
}

/// The header of a record.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Header {
    pub kind: Kind,
    pub sequence: u32,
    /// The length of the payload.
    pub length: usize,
}

impl Header {
    /// The header in these bytes, if it is one.
    pub fn parse(bytes: &[u8; HEADER]) -> Option<Self> {
        let &[magic, version, k0, k1, s0, s1, s2, s3, l0, l1] = bytes;
        let kind = u16::from_le_bytes([k0, k1]);
        if [magic, version] != [MAGIC, VERSION] {
            return None;
        }
        let kind = match kind {
            CALIBRATION => Kind::Calibration,
            WITH_LAYOUT.. => Kind::Parameters(kind - WITH_LAYOUT),
            _ => Kind::Old(kind),
        };
        Some(Self {
            kind,
            sequence: u32::from_le_bytes([s0, s1, s2, s3]),
            length: u16::from_le_bytes([l0, l1]).into(),
        })
    }

    /// The size of the whole record.
    pub const fn size(&self) -> usize {
        size(self.length)
    }

    /// The size of the record up to its CRC.
    pub const fn checked_size(&self) -> usize {
        size(self.length) - CRC_SIZE
    }
}

/// Finishes the record in `buffer` whose payload of `length` bytes is there already; returns its size, or None when the buffer is
/// too small.
fn seal(buffer: &mut [u8], kind: u16, sequence: u32, length: usize) -> Option<usize> {
    let record = buffer.get_mut(..size(length))?;
    let (body, crc) = record.split_last_chunk_mut::<CRC_SIZE>()?;
    body.get_mut(HEADER + length..)?.fill(0);
    let [k0, k1] = kind.to_le_bytes();
    let [s0, s1, s2, s3] = sequence.to_le_bytes();
    let [l0, l1] = (length as u16).to_le_bytes();
    *body.first_chunk_mut::<HEADER>()? = [MAGIC, VERSION, k0, k1, s0, s1, s2, s3, l0, l1];
    *crc = CRC.checksum(body).to_le_bytes();
    Some(size(length))
}

/// Writes the record of parameters, which `encode` puts into their place; returns its size, or None when they do not fit.
pub(super) fn encode_parameters(
    buffer: &mut [u8],
    owner: Owner,
    is_calibrated: bool,
    sequence: u32,
    encode: impl FnOnce(&mut [u8]) -> Option<usize>,
) -> Option<usize> {
    let (layout, parameters) = buffer.get_mut(HEADER..)?.split_first_mut()?;
    *layout = owner.layout | if is_calibrated { CALIBRATED } else { 0 };
    let length = 1 + encode(parameters)?;
    seal(buffer, owner.image.0 | WITH_LAYOUT, sequence, length)
}

/// Where the calibration is in its record.
pub(super) const CALIBRATION_AT: usize = HEADER + CALIBRATION_OWNER;

/// What stands before the calibration of the unit with this serial number.
pub(super) fn calibration_owner(serial: u32) -> [u8; CALIBRATION_OWNER] {
    let [s0, s1, s2, s3] = serial.to_le_bytes();
    [CALIBRATION_LAYOUT, s0, s1, s2, s3]
}

/// Finishes the record of the calibration that is in `buffer` at [`CALIBRATION_AT`] already.
pub(super) fn seal_calibration(buffer: &mut [u8], serial: u32) {
    let place = buffer.iter_mut().skip(HEADER);
    for (to, from) in place.zip(calibration_owner(serial)) {
        *to = from;
    }
    // It fits into every buffer of a store. There is no newer or older calibration, so it has no sequence number.
    let _ = seal(buffer, CALIBRATION, 0, CALIBRATION_PAYLOAD);
}
