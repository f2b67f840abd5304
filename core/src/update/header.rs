//! The image file of an update, and the header of a program.
//!
//! # The file
//!
//! ```text
//!  byte 0        64                     64 + length
//!       +--------+----------------------+
//!       | header | body                 |
//!       +--------+----------------------+
//! ```
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
//! Numbers are little-endian. The product is the number of its [`ImageId`]. The version is 65536 * major + 256 * minor + patch; a higher
//! number is a newer program. The key id is 0 for an image without a signature. The commit is programmed to 0000h at the end of an update.
//!
//! Both CRCs are CRC-32/MPEG-2 of words in the order of the CRC unit of an STM32: the most significant byte of each little-endian word
//! first. That of the body counts FFh in place of the header. That of the first page is of bytes 0 to [`PAGE`] of the slot with the header in
//! its place, and FFh from its CRC on. So it covers product and board before anything is erased.

use crate::store::ImageId;
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

/// What a program says of itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Header {
    /// The product, the number of its [`ImageId`].
    pub product: u16,
    /// The number of the board.
    pub board: u16,
    /// The layout of the memory for which the program is linked.
    pub layout: u8,
    /// The key of the signature; 0: none.
    pub key: u16,
    /// The version: 65536 * major + 256 * minor + patch.
    pub version: u32,
    /// The length of the body in bytes.
    pub length: u32,
    /// The CRC of the body.
    pub body: u32,
    /// The SHA-256 of the body; 0 without a signature.
    pub hash: [u8; 32],
    /// The CRC of the first page.
    pub first_page: u32,
}

/// The sensor for which an image must be made.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Device {
    /// The product; None: any, for a bootloader that does not know its product yet.
    pub product: Option<ImageId>,
    /// The number of the board.
    pub board: u16,
    /// The layout of its memory.
    pub layout: u8,
}

/// The reason why an image is refused. Nothing was erased.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unfit {
    /// The file does not begin with a header of this format.
    Format,
    /// The first page has another CRC.
    Damaged,
    /// The image is for another product.
    Product,
    /// The image is for another board, or for another layout of its memory.
    Board,
    /// The body does not fit into the slot, ends in the first page, or is not a whole number of words.
    Length,
    /// The version is lower than that of the present program.
    Older,
}

impl Header {
    /// The header in these bytes; None if they are not one.
    pub fn parse(bytes: &[u8; SIZE]) -> Option<Self> {
        let mut fields = Fields(bytes);
        let magic = fields.take()?;
        let [format, layout] = fields.take()?;
        (magic == MAGIC && format == FORMAT).then_some(())?;
        Some(Self {
            layout,
            product: u16::from_le_bytes(fields.take()?),
            board: u16::from_le_bytes(fields.take()?),
            key: u16::from_le_bytes(fields.take()?),
            version: u32::from_le_bytes(fields.take()?),
            length: u32::from_le_bytes(fields.take()?),
            body: u32::from_le_bytes(fields.take()?),
            hash: fields.take()?,
            first_page: u32::from_le_bytes(fields.take()?),
        })
    }

    /// The header as it is in a file, without the commit.
    pub fn bytes(&self) -> [u8; SIZE] {
        let mut bytes = [0xFF; SIZE];
        let [product, board, key] = [self.product, self.board, self.key].map(u16::to_le_bytes);
        let [version, length] = [self.version, self.length].map(u32::to_le_bytes);
        let [body, first_page] = [self.body, self.first_page].map(u32::to_le_bytes);
        let fields: [&[u8]; 10] = [
            &MAGIC,
            &[FORMAT, self.layout],
            &product,
            &board,
            &key,
            &version,
            &length,
            &body,
            &self.hash,
            &first_page,
        ];
        for (to, from) in bytes.iter_mut().zip(fields.into_iter().flatten()) {
            *to = *from;
        }
        bytes
    }

    /// Checks that the image with this first page, which has this CRC, is for a device with a slot of `size` bytes whose program has the version `present`; None:
    /// it has no program, or an older one is permitted.
    pub fn check(
        &self,
        first_page: u32,
        device: &Device,
        size: usize,
        present: Option<u32>,
    ) -> Result<(), Unfit> {
        let is_other = |product: ImageId| product.number() != self.product;
        let is_length = (PAGE..=size).contains(&(self.length as usize));
        if first_page != self.first_page {
            Err(Unfit::Damaged)
        } else if self.board != device.board || self.layout != device.layout {
            Err(Unfit::Board)
        } else if device.product.is_some_and(is_other) {
            Err(Unfit::Product)
        } else if !is_length || !self.length.is_multiple_of(4) {
            Err(Unfit::Length)
        } else if present.is_some_and(|present| self.version < present) {
            Err(Unfit::Older)
        } else {
            Ok(())
        }
    }
}

/// The fields of a header in their order.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*field)
    }
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
