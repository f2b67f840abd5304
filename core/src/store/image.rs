//! One image as it lies in memory.
//!
//! ```text
//!  byte 0      1         2       4          8        10          10 + n ...     p            p + 4
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//!       | 'P'  | version | model | sequence | length | payload   | 00h padding  | CRC-32     |
//!       | 50h  | 01h     | u16   | u32      | u16 n  | n bytes   | to 4 bytes   | of 0..p    |
//!       +------+---------+-------+----------+--------+-----------+--------------+------------+
//! ```
//!
//! Numbers are little-endian. The CRC is CRC-32/ISO-HDLC (the one of Ethernet and zip); it is programmed last, so an image that
//! was cut off does not check. Erased memory reads FFh.

use super::{ImageId, Payload};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

const MAGIC: u8 = b'P';
const VERSION: u8 = 1;
const HEADER: usize = 10;
const CRC_SIZE: usize = 4;

/// The largest image in bytes.
pub(super) const IMAGE_MAX: usize = image_size(super::PAYLOAD_MAX);

/// An image, ready to be programmed.
pub(super) type Image = heapless::Vec<u8, IMAGE_MAX>;

/// The size in bytes of an image with a payload of `payload` bytes; a multiple of 4.
pub(super) const fn image_size(payload: usize) -> usize {
    (HEADER + payload).next_multiple_of(4) + CRC_SIZE
}

// The table-driven variant would cost 1 KiB of flash to save a millisecond at boot.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Writes the image of `payload`; None when the payload is too long.
pub(super) fn encode(id: ImageId, sequence: u32, payload: &[u8]) -> Option<Image> {
    if payload.len() > super::PAYLOAD_MAX {
        return None;
    }
    let mut image = Image::new();
    let length = u16::try_from(payload.len()).ok()?;
    image.extend_from_slice(&[MAGIC, VERSION]).ok()?;
    image.extend_from_slice(&id.0.to_le_bytes()).ok()?;
    image.extend_from_slice(&sequence.to_le_bytes()).ok()?;
    image.extend_from_slice(&length.to_le_bytes()).ok()?;
    image.extend_from_slice(payload).ok()?;
    image
        .resize(image_size(payload.len()).checked_sub(CRC_SIZE)?, 0)
        .ok()?;
    let crc = CRC.checksum(&image);
    image.extend_from_slice(&crc.to_le_bytes()).ok()?;
    Some(image)
}

/// What stands in the place of an image.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Content {
    /// Erased.
    Blank,
    /// A whole image of this model, with its sequence number.
    Whole(u32),
    /// Anything else: cut off, damaged, of another model, version or length.
    Unusable,
}

/// Judges the bytes of one place: an image of `id` with a payload of exactly `payload` bytes, or not.
pub(super) fn judge(bytes: &[u8], id: ImageId, payload: usize) -> Content {
    if bytes.iter().all(|&byte| byte == 0xFF) {
        return Content::Blank;
    }
    whole(bytes, id, payload).map_or(Content::Unusable, Content::Whole)
}

/// The sequence number of a whole image of `id`; every field is checked, also those that the CRC vouches for.
fn whole(bytes: &[u8], id: ImageId, payload: usize) -> Option<u32> {
    let image = bytes.get(..image_size(payload))?;
    let (body, crc) = image.split_last_chunk::<CRC_SIZE>()?;
    let (header, _) = body.split_first_chunk::<HEADER>()?;
    let &[magic, version, m0, m1, s0, s1, s2, s3, l0, l1] = header;
    let fits = magic == MAGIC
        && version == VERSION
        && u16::from_le_bytes([m0, m1]) == id.0
        && usize::from(u16::from_le_bytes([l0, l1])) == payload
        && CRC.checksum(body) == u32::from_le_bytes(*crc);
    fits.then_some(u32::from_le_bytes([s0, s1, s2, s3]))
}

/// The payload of an image that was judged whole.
pub(super) fn payload(bytes: &[u8], length: usize) -> Option<Payload> {
    Payload::from_slice(bytes.get(HEADER..)?.get(..length)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: ImageId = ImageId(0x1234);

    #[test]
    fn an_image_is_laid_out_as_the_byte_map_says() {
        let image = encode(ID, 0x0403_0201, &[0xAA, 0xBB, 0xCC]).unwrap();
        assert_eq!(
            image[..16],
            [
                0x50, 1, 0x34, 0x12, 1, 2, 3, 4, 3, 0, 0xAA, 0xBB, 0xCC, 0, 0, 0
            ]
        );
        // zlib.crc32 of those sixteen bytes
        assert_eq!(image[16..], 0xE3AE_C296_u32.to_le_bytes());
        assert_eq!(judge(&image, ID, 3), Content::Whole(0x0403_0201));
        assert_eq!(payload(&image, 3).unwrap(), [0xAA, 0xBB, 0xCC]);
    }

    #[test]
    fn another_model_version_or_length_is_refused() {
        let image = encode(ID, 7, &[1, 2, 3, 4]).unwrap();
        assert_eq!(judge(&image, ImageId(0x1235), 4), Content::Unusable);
        assert_eq!(judge(&image, ID, 3), Content::Unusable);
        assert_eq!(judge(&image, ID, 5), Content::Unusable);
        // A version that does not exist, with a CRC that is right.
        let mut newer = image.clone();
        newer[1] = 2;
        let end = newer.len() - 4;
        let crc = CRC.checksum(&newer[..end]).to_le_bytes();
        newer[end..].copy_from_slice(&crc);
        assert_eq!(judge(&newer, ID, 4), Content::Unusable);
    }

    #[test]
    fn every_flipped_bit_is_seen() {
        let image = encode(ID, 7, &[1, 2, 3, 4, 5]).unwrap();
        for bit in 0..image.len() * 8 {
            let mut flipped = image.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(judge(&flipped, ID, 5), Content::Unusable, "bit {bit}");
        }
    }

    #[test]
    fn a_payload_that_is_too_long_makes_no_image() {
        assert!(encode(ID, 0, &[0; super::super::PAYLOAD_MAX]).is_some());
        assert!(encode(ID, 0, &[0; super::super::PAYLOAD_MAX + 1]).is_none());
    }
}
