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
//! Numbers are little-endian. The bit rate is its place in [`BitRate::ALL`]. Bit 31 of an identifier means 29 bits. The CRC is
//! [that of a header](super::header::crc), of the bytes before it.

use crate::can::{BitRate, CanId};
use crate::store::ImageId;

/// The length of an entry in bytes.
pub const SIZE: usize = 32;

const MARK: u8 = 0xA5;
/// Bytes before the CRC.
const CHECKED: usize = SIZE - 4;

/// Calculates the CRC of some parts.
pub type Crc = fn(&[&[u8]]) -> u32;

/// What the bootloader knows of its sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Record {
    /// The product.
    pub product: ImageId,
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

impl Record {
    /// The entry. `crc` is [that of a header](super::header::crc), or the unit of the board.
    pub fn bytes(&self, crc: Crc) -> [u8; SIZE] {
        let rate = BitRate::ALL.iter().position(|rate| *rate == self.rate);
        let [a, b] = self.product.number().to_le_bytes();
        let numbers = [
            self.request.bits(),
            self.reply.bits(),
            self.boot_up.bits(),
            self.vendor,
            self.product_code,
            self.serial,
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
        bytes
    }

    /// The record in an entry; None if it is not valid.
    pub fn parse(bytes: &[u8; SIZE], crc: Crc) -> Option<Self> {
        let (content, check) = bytes.split_at(CHECKED);
        (crc(&[content]).to_le_bytes() == check).then_some(())?;
        let (&[mark, rate, a, b], numbers) = content.split_first_chunk()?;
        let product = u16::from_le_bytes([a, b]);
        (mark == MARK && (1..0x8000).contains(&product)).then_some(())?;
        let mut numbers = numbers
            .as_chunks()
            .0
            .iter()
            .map(|bytes| u32::from_le_bytes(*bytes));
        let mut identifier = || numbers.next().map(CanId::from_bits);
        Some(Self {
            product: ImageId::new(product),
            rate: *BitRate::ALL.get(usize::from(rate))?,
            request: identifier()?,
            reply: identifier()?,
            boot_up: identifier()?,
            vendor: numbers.next()?,
            product_code: numbers.next()?,
            serial: numbers.next()?,
        })
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

    const RECORD: Record = Record {
        product: ImageId::new(7),
        rate: BitRate::K250,
        request: CanId::standard(0x60A),
        reply: CanId::extended(0x0C0A_0B00),
        boot_up: CanId::standard(0x70A),
        vendor: 0x1122_3344,
        product_code: 5,
        serial: 0xFFFF_FFFF,
    };

    #[test]
    fn record_is_read_as_it_was_written() {
        assert_eq!(Record::parse(&RECORD.bytes(crc), crc), Some(RECORD));
    }

    #[test]
    fn each_wrong_bit_makes_an_entry_invalid() {
        for bit in 0..SIZE * 8 {
            let mut bytes = RECORD.bytes(crc);
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Record::parse(&bytes, crc), None, "bit {bit}");
        }
    }

    #[test]
    fn newest_valid_entry_counts_and_an_interrupted_one_is_not_written_again() {
        let mut page = [0xFF; 4 * SIZE];
        assert_eq!((newest(&page, crc), next_place(&page)), (None, Some(0)));
        page[..SIZE].copy_from_slice(&RECORD.bytes(crc));
        let second = Record {
            serial: 2,
            ..RECORD
        };
        page[SIZE..2 * SIZE].copy_from_slice(&second.bytes(crc));
        // The power was cut after 6 bytes.
        page[2 * SIZE..2 * SIZE + 6].copy_from_slice(&RECORD.bytes(crc)[..6]);
        assert_eq!(newest(&page, crc), Some(second));
        assert_eq!(next_place(&page), Some(3 * SIZE));
        page[3 * SIZE..].copy_from_slice(&RECORD.bytes(crc));
        assert_eq!(
            (newest(&page, crc), next_place(&page)),
            (Some(RECORD), None)
        );
    }
}
