//! The boot record: with which identifiers and bit rate the bootloader answers, and which sensor it is.
//!
//! The program tells its bootloader before it restarts. The bootloader stores that before it changes the flash of the program, because
//! afterwards nobody else knows it.
//!
//! # The memory
//!
//! A page of entries of [`SIZE`] bytes. A new entry is appended; the newest valid one counts. When the page is full, it is erased, and the
//! program can still tell it again after a power cut, because its flash is unchanged then.
//!
//! ```text
//!  byte 0      1          2         4         8        12        16        20          24       28       32
//!       +------+----------+---------+---------+--------+---------+---------+-----------+--------+--------+
//!       | mark | bit rate | product | request | reply  | boot-up | vendor  | product   | serial | CRC-32 |
//!       | A5h  | u8       | u16     | u32     | u32    | u32     | u32     | code, u32 | number |        |
//!       +------+----------+---------+---------+--------+---------+---------+-----------+--------+--------+
//! ```
//!
//! Numbers are little-endian. The product has its [measuring element](Element) in bit 15. The bit rate is its place in [`BitRate::ALL`].
//! Bit 31 of an identifier means 29 bits. The CRC is [that of a header](super::header::crc), of the bytes before it.

use super::element::Element;
use super::header::number;
use crate::can::{BitRate, CanId};
use crate::store::ImageId;

/// The length of an entry in bytes.
pub const SIZE: usize = 32;

const MARK: u8 = 0xA5;
/// Bytes before the CRC.
const CHECKED: usize = SIZE - 4;

/// Calculates the CRC of some parts.
pub type Crc = fn(&[&[u8]]) -> u32;

/// What the program tells its bootloader of itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Contact {
    /// The bit rate.
    pub rate: BitRate,
    /// The identifier of requests to the bootloader.
    pub request: CanId,
    /// The identifier of its replies.
    pub reply: CanId,
    /// The identifier of its message at start.
    pub boot_up: CanId,
    /// 1018h:01, the number of the vendor.
    pub vendor: u32,
    /// 1018h:02.
    pub product_code: u32,
    /// 1018h:04.
    pub serial: u32,
}

/// A valid entry.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Record([u8; SIZE]);

impl Record {
    /// The entry of this product with this element. `crc` is [that of a header](super::header::crc), or the unit of the board.
    pub fn new(product: ImageId, element: Element, contact: &Contact, crc: Crc) -> Self {
        let rate = BitRate::ALL.iter().position(|rate| *rate == contact.rate);
        let [a, b] = element.with(product.number()).to_le_bytes();
        let numbers = [
            contact.request.bits(),
            contact.reply.bits(),
            contact.boot_up.bits(),
            contact.vendor,
            contact.product_code,
            contact.serial,
        ];
        let numbers = numbers.iter().flat_map(|number| number.to_le_bytes());
        let content = [MARK, rate.unwrap_or(0) as u8, a, b]
            .into_iter()
            .chain(numbers);
        let mut bytes = [0xFF; SIZE];
        for (to, from) in bytes.iter_mut().zip(content) {
            *to = from;
        }
        if let Some((content, check)) = bytes.split_last_chunk_mut() {
            *check = crc(&[content]).to_le_bytes();
        }
        Self(bytes)
    }

    /// The record in an entry; None if it is not valid.
    pub fn parse(bytes: &[u8; SIZE], crc: Crc) -> Option<Self> {
        let record = Self(*bytes);
        let is_valid = bytes.starts_with(&[MARK])
            && crc(&[bytes.get(..CHECKED)?]) == record.number::<CHECKED>();
        is_valid.then_some(record)
    }

    /// Its bytes.
    pub const fn bytes(&self) -> &[u8; SIZE] {
        &self.0
    }

    /// The number of the product's [`ImageId`], with the [element](Element).
    pub fn product(&self) -> u16 {
        (self.number::<0>() >> 16) as u16
    }

    /// The bit rate.
    pub fn rate(&self) -> BitRate {
        let [_, place, ..] = self.0;
        *BitRate::ALL
            .get(usize::from(place))
            .unwrap_or(&BitRate::K250)
    }

    /// The identifier of requests to the bootloader.
    pub fn request(&self) -> CanId {
        CanId::from_bits(self.number::<4>())
    }

    /// The identifier of its replies.
    pub fn reply(&self) -> CanId {
        CanId::from_bits(self.number::<8>())
    }

    /// The identifier of its message at start.
    pub fn boot_up(&self) -> CanId {
        CanId::from_bits(self.number::<12>())
    }

    /// 1018h:01, the number of the vendor.
    pub fn vendor(&self) -> u32 {
        self.number::<16>()
    }

    /// 1018h:02.
    pub fn product_code(&self) -> u32 {
        self.number::<20>()
    }

    /// 1018h:04.
    pub fn serial(&self) -> u32 {
        self.number::<24>()
    }

    /// The number at this byte.
    fn number<const AT: usize>(&self) -> u32 {
        number(&self.0, AT)
    }
}

/// The newest record in a page; None if there is none.
pub fn newest(page: &[u8], crc: Crc) -> Option<Record> {
    let entries = page.as_chunks().0.iter();
    let mut records = entries.filter_map(|entry| Record::parse(entry, crc));
    records.next_back()
}

/// The place of the next entry in a page; None if the page is full.
pub fn next_place(page: &[u8]) -> Option<usize> {
    let is_blank = |entry: &[u8; SIZE]| entry.iter().all(|byte| *byte == 0xFF);
    let used = page
        .as_chunks()
        .0
        .iter()
        .rposition(|entry| !is_blank(entry));
    let next = used.map_or(0, |used| used + 1) * SIZE;
    (next + SIZE <= page.len()).then_some(next)
}

#[cfg(test)]
mod tests {
    use super::super::header::crc;
    use super::*;

    const PRODUCT: ImageId = ImageId::new(7);
    const ELEMENT: Element = Element::Adxl355;
    const CONTACT: Contact = Contact {
        rate: BitRate::K250,
        request: CanId::standard(0x60A),
        reply: CanId::extended(0x0C0A_0B00),
        boot_up: CanId::standard(0x70A),
        vendor: 0x1122_3344,
        product_code: 5,
        serial: 0xFFFF_FFFF,
    };

    #[test]
    fn record_tells_what_it_was_made_of() {
        let record = Record::new(PRODUCT, ELEMENT, &CONTACT, crc);
        assert_eq!(Record::parse(record.bytes(), crc), Some(record));
        let told = Contact {
            rate: record.rate(),
            request: record.request(),
            reply: record.reply(),
            boot_up: record.boot_up(),
            vendor: record.vendor(),
            product_code: record.product_code(),
            serial: record.serial(),
        };
        assert_eq!(
            (told, record.product()),
            (CONTACT, ELEMENT.with(PRODUCT.number()))
        );
    }

    #[test]
    fn each_wrong_bit_makes_an_entry_invalid() {
        for bit in 0..SIZE * 8 {
            let mut bytes = *Record::new(PRODUCT, ELEMENT, &CONTACT, crc).bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Record::parse(&bytes, crc), None, "bit {bit}");
        }
    }

    #[test]
    fn newest_valid_entry_counts_and_an_interrupted_one_is_not_written_again() {
        let first = Record::new(PRODUCT, ELEMENT, &CONTACT, crc);
        let other = Contact {
            serial: 2,
            ..CONTACT
        };
        let second = Record::new(PRODUCT, ELEMENT, &other, crc);
        let mut page = [0xFF; 4 * SIZE];
        assert_eq!((newest(&page, crc), next_place(&page)), (None, Some(0)));
        page[..SIZE].copy_from_slice(first.bytes());
        page[SIZE..2 * SIZE].copy_from_slice(second.bytes());
        // The power was cut after 6 bytes.
        page[2 * SIZE..2 * SIZE + 6].copy_from_slice(&first.bytes()[..6]);
        assert_eq!(newest(&page, crc), Some(second));
        assert_eq!(next_place(&page), Some(3 * SIZE));
        page[3 * SIZE..].copy_from_slice(first.bytes());
        assert_eq!((newest(&page, crc), next_place(&page)), (Some(first), None));
    }
}
