//! The coding of a record. The byte map is in [`store`](super).

use super::{Owner, unit, usage};
use crate::measure::calibration;
use crate::walk::copy;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

const MAGIC: u8 = b'P';
/// The version of the record format without the payload.
const VERSION: u8 = 1;

/// The first word of a record of the device.
pub(super) const DEVICE_BEGIN: u32 = u32::from_le_bytes([MAGIC, VERSION, 0, 0]);

/// The size of the header before the payload.
pub(super) const HEADER: usize = 10;
const CRC_SIZE: usize = 4;

/// The kind of the records of the device: its calibration, its identity and its usage. No product has this [`ImageId`](super::ImageId).
const DEVICE: u16 = 0;
/// Bit of the kind of parameters: the payload begins with the layout. Without it, the payload is the parameters followed by the
/// calibration.
const WITH_LAYOUT: u16 = 0x8000;
/// The layout of the payload of a calibration.
const CALIBRATION_LAYOUT: u8 = 1;
/// The size of layout and serial number before the calibration in its payload.
pub(super) const CALIBRATION_OWNER: usize = 5;
const CALIBRATION_PAYLOAD: usize = CALIBRATION_OWNER + calibration::SIZE;

/// The payload of parameters before the parameters: layout and check of the calibration.
pub(super) const PARAMETERS_OWNER: usize = 2;

/// The size in bytes of the record of a calibration.
pub(super) const CALIBRATION_SIZE: usize = size(CALIBRATION_PAYLOAD);

/// The size in bytes of the record of the usage.
pub(super) const USAGE_SIZE: usize = size(usage::SIZE);

/// The size in bytes of the records of the device, with the longest identity.
pub(super) const fn device_size(keeps_usage: bool) -> usize {
    let usage = if keeps_usage { USAGE_SIZE } else { 0 };
    CALIBRATION_SIZE + size(unit::SIZE) + usage
}

/// Continues a CRC-32/ISO-HDLC with more bytes. 0 is the CRC of no bytes.
pub fn crc32(previous: u32, bytes: &[u8]) -> u32 {
    // The table-driven variant would need 1 KiB of flash and save one millisecond at boot.
    const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    // The crate mirrors its initial value and inverts its result.
    let mut digest = CRC.digest_with_initial((!previous).reverse_bits());
    digest.update(bytes);
    digest.finalize()
}

/// The size in bytes of a record with a payload of `payload` bytes; a multiple of 4.
const fn size(payload: usize) -> usize {
    (HEADER + payload).next_multiple_of(4) + CRC_SIZE
}

/// The size, in bytes, of the buffer of a [`Store`](super::Store) for a product with `stored` bytes of parameters: the records of
/// the device, with a usage or without, then the record of the parameters.
pub const fn buffer_size(stored: usize, keeps_usage: bool) -> usize {
    device_size(keeps_usage) + parameters_size(stored)
}

/// The size in bytes of a record with `stored` bytes of parameters.
pub(super) const fn parameters_size(stored: usize) -> usize {
    size(PARAMETERS_OWNER + stored)
}

/// A number from 1 to 255 that tells calibrations and identities apart; 0 stands for neither.
pub(super) fn check(calibration: &[u8], unit: &[u8]) -> u8 {
    if calibration.is_empty() && unit.is_empty() {
        return 0;
    }
    (crc32(crc32(0, calibration), unit) as u8).max(1)
}

/// The kind of a record in its header.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// Parameters of the product with this number.
    Parameters(u16),
    /// Old record: parameters of the product with this number, then the calibration.
    Old(u16),
    /// The calibration, the identity or the usage of the device.
    Device,
}

/// The header of a record.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Header {
    pub kind: Kind,
    pub sequence: u32,
    /// The length of the payload in bytes.
    pub length: usize,
}

impl Header {
    /// The header in these bytes; None if it is not valid.
    pub fn parse(bytes: &[u8; HEADER]) -> Option<Self> {
        let &[magic, version, k0, k1, s0, s1, s2, s3, l0, l1] = bytes;
        let kind = u16::from_le_bytes([k0, k1]);
        if [magic, version] != [MAGIC, VERSION] {
            return None;
        }
        let kind = match kind {
            DEVICE => Kind::Device,
            WITH_LAYOUT.. => Kind::Parameters(kind - WITH_LAYOUT),
            _ => Kind::Old(kind),
        };
        Some(Self {
            kind,
            sequence: u32::from_le_bytes([s0, s1, s2, s3]),
            length: u16::from_le_bytes([l0, l1]).into(),
        })
    }

    /// The size of the complete record.
    pub const fn size(&self) -> usize {
        size(self.length)
    }

    /// The size of the record before its CRC.
    pub const fn checked_size(&self) -> usize {
        size(self.length) - CRC_SIZE
    }
}

/// Completes the record in `buffer`, which already contains its payload of `length` bytes. Returns its size; None if the buffer
/// is too small.
fn seal(buffer: &mut [u8], kind: u16, sequence: u32, length: usize) -> Option<usize> {
    let record = buffer.get_mut(..size(length))?;
    let (body, crc) = record.split_last_chunk_mut::<CRC_SIZE>()?;
    body.get_mut(HEADER + length..)?.fill(0);
    let [k0, k1] = kind.to_le_bytes();
    let [s0, s1, s2, s3] = sequence.to_le_bytes();
    let [l0, l1] = (length as u16).to_le_bytes();
    *body.first_chunk_mut::<HEADER>()? = [MAGIC, VERSION, k0, k1, s0, s1, s2, s3, l0, l1];
    *crc = crc32(0, body).to_le_bytes();
    Some(size(length))
}

/// Writes the record of parameters of a device whose records have this [`check`]; `encode` writes the parameters into the
/// payload. Returns its size; None if they do not fit.
pub(super) fn encode_parameters(
    buffer: &mut [u8],
    owner: Owner,
    check: u8,
    sequence: u32,
    encode: impl FnOnce(&mut [u8]) -> Option<usize>,
) -> Option<usize> {
    let payload = buffer.get_mut(HEADER..)?;
    let (of, parameters) = payload.split_first_chunk_mut::<PARAMETERS_OWNER>()?;
    *of = [owner.layout, check];
    let length = PARAMETERS_OWNER + encode(parameters)?;
    seal(buffer, owner.image.0 | WITH_LAYOUT, sequence, length)
}

/// The offset of the calibration in its record.
pub(super) const CALIBRATION_AT: usize = HEADER + CALIBRATION_OWNER;

/// The bytes before the calibration of the device with this serial number.
pub(super) fn calibration_owner(serial: u32) -> [u8; CALIBRATION_OWNER] {
    let [s0, s1, s2, s3] = serial.to_le_bytes();
    [CALIBRATION_LAYOUT, s0, s1, s2, s3]
}

/// Writes the record of a calibration. Returns its size; None if the buffer is too small.
pub(super) fn encode_calibration(
    buffer: &mut [u8],
    serial: u32,
    sequence: u32,
    calibration: &[u8; calibration::SIZE],
) -> Option<usize> {
    let payload = buffer.get_mut(HEADER..HEADER + CALIBRATION_PAYLOAD)?;
    let (owner, place) = payload.split_first_chunk_mut()?;
    *owner = calibration_owner(serial);
    place.copy_from_slice(calibration);
    seal(buffer, DEVICE, sequence, CALIBRATION_PAYLOAD)
}

/// Writes the record of an identity with this encoding. Returns its size; None if the buffer is too small.
pub(super) fn encode_unit(buffer: &mut [u8], sequence: u32, unit: &[u8]) -> Option<usize> {
    let place = buffer.get_mut(HEADER..HEADER + unit.len())?;
    copy(place, unit);
    seal(buffer, DEVICE, sequence, unit.len())
}

/// The first bytes of a usage of the device with this serial number.
pub(super) fn usage_owner(serial: u32) -> [u8; usage::OWNER] {
    let [s0, s1, s2, s3] = serial.to_le_bytes();
    [usage::MARK, s0, s1, s2, s3]
}

/// Writes the record of a usage. Returns its size; None if the buffer is too small.
pub(super) fn encode_usage(
    buffer: &mut [u8],
    sequence: u32,
    usage: &[u8; usage::SIZE],
) -> Option<usize> {
    let place = buffer.get_mut(HEADER..HEADER + usage::SIZE)?;
    copy(place, usage);
    seal(buffer, DEVICE, sequence, usage::SIZE)
}
