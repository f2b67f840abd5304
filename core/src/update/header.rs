//! The image file of an update, and the header of a program.
//!
//! # The file
//!
//! ```text
//!  byte 0        64            64 (2572)              + length
//!       +--------+-------------+----------------------+
//!       | header | (signature) | body                 |
//!       +--------+-------------+----------------------+
//! ```
//!
//! The [signature](super::lms) has 2508 bytes and is there if the key id is not 0. It is of the 64 bytes of the header, which has the SHA-256
//! of the body.
//!
//! The body is the contents of the slot from its first byte, with FFh in place of the header: the vectors, the header at byte
//! [`PLACE`], the code. Its length is a multiple of 4.
//!
//! # The header
//!
//! ```text
//!  byte 0       4        5        6         8       10       12        16       20       24        56          60       62       64
//!       +-------+--------+--------+---------+-------+--------+---------+--------+--------+---------+-----------+--------+--------+
//!       | magic | format | layout | product | board | key id | version | length | CRC of | SHA-256 | CRC of    | unused | commit |
//!       | PLUM  | 01h    | u8     | u16     | u16   | u16    | u32     | u32    | body   | or 0    | first page| FFFFh  | FFFFh  |
//!       +-------+--------+--------+---------+-------+--------+---------+--------+--------+---------+-----------+--------+--------+
//! ```
//!
//! Numbers are little-endian. The product is the number of its [`ImageId`](crate::store::ImageId), with the [measuring element](Element) in
//! bit 15. The version is 65536 * major + 256 * minor + patch; a higher number is a newer program. The key id is 0 for an image without a
//! signature, otherwise the first two bytes of the identifier of the key. The commit is programmed to 0000h at the end of an update.
//!
//! Both CRCs are CRC-32/MPEG-2 of words in the order of the CRC unit of an STM32: the most significant byte of each little-endian word
//! first. That of the body counts FFh in place of the header. That of the first page is of bytes 0 to [`PAGE`] of the slot with the header in
//! its place, and FFh from its CRC on. So it covers product and board before anything is erased.

use super::element::Element;
use super::failure::Failure;
use super::installed::{Hardware, Installed};
use super::lms::{Signature, sha256};
use crc::{CRC_32_MPEG_2, Crc, NoTable};

/// The length of a header in bytes.
pub const SIZE: usize = 64;
/// The place of the header in the slot, behind the vectors of each board.
pub const PLACE: usize = 512;
/// The part of the body that is in the memory of the bootloader before the flash is erased, in bytes.
pub const PAGE: usize = 1024;
/// The place of the commit in the slot.
pub const COMMIT: usize = PLACE + 62;

const MAGIC: [u8; 4] = *b"PLUM";
const FORMAT: u8 = 1;
/// The bytes of the header that the CRC of the first page covers.
const COVERED: usize = 56;

/// For which device a program is made.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Contents {
    /// The product, the number of its [`ImageId`](crate::store::ImageId).
    pub product: u16,
    /// The measuring element.
    pub element: Element,
    /// The number of the board.
    pub board: u16,
    /// The layout of the memory for which the program is linked.
    pub layout: u8,
    /// The key of the signature; 0: none.
    pub key: u16,
    /// The version: 65536 * major + 256 * minor + patch.
    pub version: u32,
    /// The SHA-256 of the body; 0 without a signature.
    pub hash: [u8; 32],
}

/// A header of this format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Header([u8; SIZE]);

/// The sensor for which an image must be made.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Device {
    /// The number of its product with the [element](Element); None: any, for a bootloader that does not know its product yet.
    pub product: Option<u16>,
    /// The number of the board.
    pub board: u16,
    /// The layout of its memory.
    pub layout: u8,
}

impl Header {
    /// The header of a program with this body, without the commit. What the body has in place of the header does not matter. None: the body
    /// is shorter than its first page.
    pub fn new(contents: &Contents, body: &[u8]) -> Option<Self> {
        let mut header = Self([0xFF; SIZE]);
        let [product, board, key] = [
            contents.element.with(contents.product),
            contents.board,
            contents.key,
        ]
        .map(u16::to_le_bytes);
        let [version, length] = [contents.version, body.len() as u32].map(u32::to_le_bytes);
        let fields: [&[u8]; 9] = [
            &MAGIC,
            &[FORMAT, contents.layout],
            &product,
            &board,
            &key,
            &version,
            &length,
            &crc(&body_parts(body)).to_le_bytes(),
            &contents.hash,
        ];
        for (to, from) in header.0.iter_mut().zip(fields.into_iter().flatten()) {
            *to = *from;
        }
        let mut page = *body.first_chunk::<PAGE>()?;
        page.get_mut(PLACE..)?
            .first_chunk_mut()?
            .clone_from(&header.0);
        let first_page = crc(&first_page_parts(&page)).to_le_bytes();
        header
            .0
            .get_mut(COVERED..)?
            .first_chunk_mut()?
            .clone_from(&first_page);
        Some(header)
    }

    /// The header in these bytes; None if they are not one of this format.
    pub fn parse(bytes: &[u8; SIZE]) -> Option<Self> {
        let [magic @ .., _, _, _, _] = bytes.first_chunk::<8>()?;
        let [.., format, _, _, _] = bytes.first_chunk::<8>()?;
        (*magic == MAGIC && *format == FORMAT).then_some(Self(*bytes))
    }

    /// Its bytes.
    pub const fn bytes(&self) -> &[u8; SIZE] {
        &self.0
    }

    /// Puts the header with its commit into the body of a program, as it is in the flash after an update.
    pub fn commit(&self, body: &mut [u8]) {
        let place = body.get_mut(PLACE..).and_then(<[u8]>::first_chunk_mut);
        if let Some(place) = place {
            *place = self.0;
        }
        if let Some(commit) = body.get_mut(COMMIT..COMMIT + 2) {
            commit.fill(0);
        }
    }

    /// The layout of the memory for which the program is linked.
    pub fn layout(&self) -> u8 {
        (number(&self.0, 4) >> 8) as u8
    }

    /// The product, the number of its [`ImageId`](crate::store::ImageId).
    pub fn product(&self) -> u16 {
        Element::product(self.product_with_element())
    }

    /// The measuring element.
    pub fn element(&self) -> Element {
        Element::of(self.product_with_element())
    }

    fn product_with_element(&self) -> u16 {
        (number(&self.0, 4) >> 16) as u16
    }

    /// The number of the board.
    pub fn board(&self) -> u16 {
        number(&self.0, 8) as u16
    }

    /// What the program tells of itself over the bus.
    pub fn installed(&self) -> Installed {
        Installed {
            crc: self.body(),
            hardware: Hardware::new(self.board(), self.element()),
        }
    }

    /// The key of the signature; 0: none.
    pub fn key(&self) -> u16 {
        (number(&self.0, 8) >> 16) as u16
    }

    /// The length of the signature behind it in the file, in bytes.
    pub fn signature(&self) -> usize {
        match self.key() {
            0 => 0,
            _ => Signature::SIGNATURE,
        }
    }

    /// Whether its SHA-256 is that of this body.
    pub fn is_of(&self, body: &[u8]) -> bool {
        self.0.get(24..COVERED) == Some(&sha256(&body_parts(body)))
    }

    /// The version: 65536 * major + 256 * minor + patch.
    pub fn version(&self) -> u32 {
        number(&self.0, 12)
    }

    /// The length of the body in bytes.
    pub fn length(&self) -> usize {
        number(&self.0, 16) as usize
    }

    /// The CRC of the body.
    pub fn body(&self) -> u32 {
        number(&self.0, 20)
    }

    /// The CRC of the first page.
    pub fn first_page(&self) -> u32 {
        number(&self.0, COVERED)
    }

    /// Checks that the image with this first page, which has this CRC, is for a device with a slot of `size` bytes whose program has the
    /// version `present`; None: it has no program, or an older one is permitted.
    pub fn check(
        &self,
        first_page: u32,
        device: &Device,
        size: usize,
        present: Option<u32>,
    ) -> Result<(), Failure> {
        let length = self.length();
        if first_page != self.first_page() {
            Err(Failure::Damaged)
        } else if self.board() != device.board || self.layout() != device.layout {
            Err(Failure::Board)
        } else if device
            .product
            .is_some_and(|own| own != self.product_with_element())
        {
            Err(Failure::Product)
        } else if !(PAGE..=size).contains(&length) || !length.is_multiple_of(4) {
            Err(Failure::Size)
        } else if present.is_some_and(|present| self.version() < present) {
            Err(Failure::Older)
        } else {
            Ok(())
        }
    }
}

/// The number of a version.
///
/// # Panics
/// If minor or patch are above 255, or major is above 65535.
pub const fn version(major: u32, minor: u32, patch: u32) -> u32 {
    assert!(
        major <= 0xFFFF && minor <= 0xFF && patch <= 0xFF,
        "minor and patch are at most 255"
    );
    major << 16 | minor << 8 | patch
}

/// The number at this byte; 0 outside of the bytes.
pub(super) fn number(bytes: &[u8], at: usize) -> u32 {
    let bytes = bytes.get(at..).and_then(<[u8]>::first_chunk);
    bytes.map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// CRC-32/MPEG-2 of the words of all parts, as the CRC unit of an STM32 calculates it.
pub fn crc(parts: &[&[u8]]) -> u32 {
    const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_MPEG_2);
    let mut digest = CRC.digest();
    for &[a, b, c, d] in parts.iter().flat_map(|part| part.as_chunks().0) {
        digest.update(&[d, c, b, a]);
    }
    digest.finalize()
}

/// The parts of the first page of a slot that its CRC covers.
pub fn first_page_parts(page: &[u8]) -> [&[u8]; 3] {
    let page = page.get(..PAGE).unwrap_or_default();
    let covered = page.get(..PLACE + COVERED).unwrap_or_default();
    let after = page.get(PLACE + SIZE..).unwrap_or_default();
    [covered, &[0xFF; SIZE - COVERED], after]
}

/// The parts of a body that its CRC covers: the contents of the slot, whatever is in the place of the header.
pub fn body_parts(body: &[u8]) -> [&[u8]; 3] {
    let before = body.get(..PLACE).unwrap_or_default();
    let after = body.get(PLACE + SIZE..).unwrap_or_default();
    [before, &[0xFF; SIZE], after]
}

#[cfg(test)]
mod tests;
