//! The unit record: the identity of one unit, in place of the identity that its product has as printed.
//!
//! The master of an existing plant compares the identity of a sensor with its own file, and refuses another one. The record makes a
//! replacement answer as the sensor did that the file was written for. Everything in it is optional: what is not given stays as the
//! product has it.
//!
//! # Byte map
//!
//! ```text
//!  byte 0     1          3
//!       +-----+----------+---------+---------+-----     each field:  +-----+--------+-----------+
//!       | 'U' | product, | field   | field   | ...                   | tag | length | n bytes   |
//!       | 55h | u16      |         |         |                       | u8  | u8 n   |           |
//!       +-----+----------+---------+---------+-----                  +-----+--------+-----------+
//!
//!  tag  contents                     CANopen     DeviceNet class 1   GEMAC
//!  01h  vendor, u32                  1018h:01    attribute 1
//!  02h  device type, u16                         attribute 2
//!  03h  product code, u32            1018h:02    attribute 3
//!  04h  revision, u32                1018h:03    attribute 4         code 03h
//!  05h  serial number, u32           1018h:04    attribute 6         code 04h
//!  06h  article number, u32                                          code 03h
//!  07h  name, text                   1008h       attribute 7
//!  08h  hardware version, text       1009h
//!  09h  software version, text       100Ah
//! ```
//!
//! Numbers are little-endian. The product is the number of its [`ImageId`]: another product on the same chip ignores the record. A
//! field that is not given is not there. A reader ignores a tag that it does not know, and a field of another length. The revision
//! is a number as CANopen and GEMAC send it; for DeviceNet it is 256 * major + minor. A text has 1 to [`NAME`] characters of ASCII
//! from space to `~`.

use super::ImageId;
use crate::walk::{copy, each, put};

/// The length of the longest text.
pub const NAME: usize = 32;

/// The first byte of the record.
pub(super) const MARK: u8 = b'U';
/// The size of mark and product.
pub(super) const OWNER: usize = 3;

/// The length of the longest encoded [`Unit`] in bytes: six numbers and three texts, each with tag and length.
pub const SIZE: usize = OWNER + 5 * (2 + 4) + (2 + 2) + 3 * (2 + NAME);

/// A text of an identity.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name {
    length: u8,
    bytes: [u8; NAME],
}

impl Name {
    /// A text of 1 to [`NAME`] characters of ASCII from space to `~`; None if it is another one.
    pub fn new(text: &str) -> Option<Self> {
        Self::of(text.as_bytes())
    }

    /// A constant text.
    ///
    /// # Panics
    /// The text is none of those of [`new`](Self::new); in a constant this does not compile.
    pub const fn constant(text: &'static str) -> Self {
        let text = text.as_bytes();
        assert!(
            !text.is_empty() && text.len() <= NAME,
            "a name has 1 to 32 characters"
        );
        let mut bytes = [0; NAME];
        each!(place, letter in text => {
            assert!(
                *letter >= b' ' && *letter <= b'~',
                "a name has characters of ASCII"
            );
            put(&mut bytes, place, *letter);
        });
        Self {
            length: text.len() as u8,
            bytes,
        }
    }

    fn of(text: &[u8]) -> Option<Self> {
        let mut bytes = [0; NAME];
        copy(bytes.get_mut(..text.len())?, text);
        let is_printable = text.iter().all(|byte| matches!(byte, b' '..=b'~'));
        (!text.is_empty() && is_printable).then_some(Self {
            length: text.len() as u8,
            bytes,
        })
    }

    /// The characters without padding, all of them printable ASCII.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length.into()).unwrap_or_default()
    }

    /// The characters as text.
    pub fn text(&self) -> &str {
        core::str::from_utf8(self.bytes()).unwrap_or_default()
    }
}

impl core::fmt::Debug for Name {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.text().fmt(f)
    }
}

/// The identity of one unit. None: as the product has it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Unit {
    /// The number of the vendor.
    pub vendor: Option<u32>,
    /// The device type (DeviceNet, attribute 2 of the identity object).
    pub device_type: Option<u16>,
    /// The product code (1018h:02, or attribute 3 of the identity object).
    pub product_code: Option<u32>,
    /// The revision; DeviceNet: 256 * major + minor.
    pub revision: Option<u32>,
    /// The serial number; without it, the one of the chip.
    pub serial: Option<u32>,
    /// The digits of the article number (GEMAC).
    pub article: Option<u32>,
    /// The device name (CANopen), or the product name (DeviceNet).
    pub name: Option<Name>,
    /// The hardware version (1009h of CANopen).
    pub hardware: Option<Name>,
    /// The software version (100Ah of CANopen, the software identification of J1939).
    pub software: Option<Name>,
}

mod tag {
    pub const VENDOR: u8 = 1;
    pub const DEVICE_TYPE: u8 = 2;
    pub const PRODUCT_CODE: u8 = 3;
    pub const REVISION: u8 = 4;
    pub const SERIAL: u8 = 5;
    pub const ARTICLE: u8 = 6;
    pub const NAME: u8 = 7;
    pub const HARDWARE: u8 = 8;
    pub const SOFTWARE: u8 = 9;
}

impl Unit {
    /// The record of a unit without its own identity: all numbers are those of the product.
    pub const NONE: Self = Self {
        vendor: None,
        device_type: None,
        product_code: None,
        revision: None,
        serial: None,
        article: None,
        name: None,
        hardware: None,
        software: None,
    };

    /// Encodes the identity of a unit of a product, see the byte map, and returns the length; None if `into` is shorter than
    /// [`SIZE`] and too short.
    pub fn encode(&self, product: ImageId, into: &mut [u8]) -> Option<usize> {
        let mut fields = Fields { into, length: 0 };
        fields.append(&owner_of(product))?;
        let numbers = [
            (tag::VENDOR, self.vendor),
            (tag::PRODUCT_CODE, self.product_code),
            (tag::REVISION, self.revision),
            (tag::SERIAL, self.serial),
            (tag::ARTICLE, self.article),
        ];
        for (tag, number) in numbers {
            if let Some(number) = number {
                fields.field(tag, &number.to_le_bytes())?;
            }
        }
        if let Some(device_type) = self.device_type {
            fields.field(tag::DEVICE_TYPE, &device_type.to_le_bytes())?;
        }
        let texts = [
            (tag::NAME, &self.name),
            (tag::HARDWARE, &self.hardware),
            (tag::SOFTWARE, &self.software),
        ];
        for (tag, text) in texts {
            if let Some(text) = text {
                fields.field(tag, text.bytes())?;
            }
        }
        Some(fields.length)
    }

    /// Decodes the result of [`encode`](Self::encode) for this product. [`NONE`](Self::NONE) if it belongs to another one.
    pub fn decode(product: ImageId, bytes: &[u8]) -> Self {
        let mut unit = Self::NONE;
        let Some((owner, mut rest)) = bytes.split_first_chunk::<OWNER>() else {
            return unit;
        };
        if *owner != owner_of(product) {
            return unit;
        }
        while let [tag, length, fields @ ..] = rest
            && let Some((field, next)) = fields.split_at_checked(usize::from(*length))
        {
            unit.take(*tag, field);
            rest = next;
        }
        unit
    }

    fn take(&mut self, tag: u8, field: &[u8]) {
        let number = || field.try_into().ok().map(u32::from_le_bytes);
        match tag {
            tag::VENDOR => self.vendor = number(),
            tag::DEVICE_TYPE => self.device_type = field.try_into().ok().map(u16::from_le_bytes),
            tag::PRODUCT_CODE => self.product_code = number(),
            tag::REVISION => self.revision = number(),
            tag::SERIAL => self.serial = number(),
            tag::ARTICLE => self.article = number(),
            tag::NAME => self.name = Name::of(field),
            tag::HARDWARE => self.hardware = Name::of(field),
            tag::SOFTWARE => self.software = Name::of(field),
            _ => {}
        }
    }
}

/// The bytes before the fields of a unit of this product.
pub(super) const fn owner_of(product: ImageId) -> [u8; OWNER] {
    let [low, high] = product.number().to_le_bytes();
    [MARK, low, high]
}

/// Writes the fields that are given, each with its tag, one after the other.
struct Fields<'a> {
    into: &'a mut [u8],
    length: usize,
}

impl Fields<'_> {
    fn append(&mut self, bytes: &[u8]) -> Option<()> {
        let end = self.length + bytes.len();
        copy(self.into.get_mut(self.length..end)?, bytes);
        self.length = end;
        Some(())
    }

    fn field(&mut self, tag: u8, bytes: &[u8]) -> Option<()> {
        self.append(&[tag, bytes.len() as u8])?;
        self.append(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PRODUCT: ImageId = ImageId::new(0x1234);

    fn encoded(unit: &Unit) -> std::vec::Vec<u8> {
        let mut bytes = [0; SIZE];
        let length = unit.encode(PRODUCT, &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    #[test]
    fn record_matches_byte_map() {
        let unit = Unit {
            vendor: Some(0x0403_0201),
            device_type: Some(0x1211),
            product_code: Some(0x0807_0605),
            revision: Some(0x0C0B_0A09),
            serial: Some(0x100F_0E0D),
            article: Some(2_305_430),
            name: Name::new("A name"),
            hardware: Name::new("B"),
            software: Name::new("C~"),
        };
        let expected = [
            &b"U\x34\x12"[..],
            &[1, 4, 1, 2, 3, 4],
            &[3, 4, 5, 6, 7, 8],
            &[4, 4, 9, 10, 11, 12],
            &[5, 4, 13, 14, 15, 16],
            &[6, 4, 0x96, 0x2D, 0x23, 0],
            &[2, 2, 0x11, 0x12],
            b"\x07\x06A name",
            b"\x08\x01B",
            b"\x09\x02C~",
        ]
        .concat();
        assert_eq!(encoded(&unit), expected);
        assert_eq!(Unit::decode(PRODUCT, &expected), unit);
        assert_eq!(encoded(&Unit::NONE), b"U\x34\x12");
    }

    #[test]
    fn record_of_another_product_gives_nothing() {
        let bytes = encoded(&Unit {
            vendor: Some(1),
            ..Unit::NONE
        });
        assert_eq!(Unit::decode(ImageId::new(0x1235), &bytes), Unit::NONE);
        assert_eq!(Unit::decode(PRODUCT, &bytes[..2]), Unit::NONE);
    }

    #[test]
    fn unknown_tag_and_field_of_another_length_are_ignored() {
        let bytes = [
            &b"U\x34\x12"[..],
            &[0x77, 3, 1, 2, 3],
            &[1, 2, 9, 9],
            &[2, 4, 9, 9, 9, 9],
            &[7, 0],
            &[8, 1, 0x1F],
            &[3, 4, 5, 0, 0, 0],
            // The end is missing.
            &[4, 4, 1, 2],
        ]
        .concat();
        let expected = Unit {
            product_code: Some(5),
            ..Unit::NONE
        };
        assert_eq!(Unit::decode(PRODUCT, &bytes), expected);
    }

    #[test]
    fn name_has_1_to_32_printable_characters() {
        let longest = "x".repeat(NAME);
        for text in ["x", " ~", &longest] {
            let name = Name::new(text).unwrap();
            assert_eq!(name.text(), text);
            assert_eq!(std::format!("{name:?}"), std::format!("{text:?}"));
        }
        for text in ["", "\u{7f}", "a\nb", "\u{e4}", &(longest.clone() + "x")] {
            assert_eq!(Name::new(text), None, "{text:?}");
        }
    }

    #[test]
    fn longest_record_has_its_size() {
        let name = Name::new(&"x".repeat(NAME));
        let longest = Unit {
            vendor: Some(u32::MAX),
            device_type: Some(u16::MAX),
            product_code: Some(u32::MAX),
            revision: Some(u32::MAX),
            serial: Some(u32::MAX),
            article: Some(u32::MAX),
            name,
            hardware: name,
            software: name,
        };
        assert_eq!(encoded(&longest).len(), SIZE);
        assert_eq!(longest.encode(PRODUCT, &mut [0; SIZE - 1]), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_decoded_without_a_panic(bytes: std::vec::Vec<u8>) {
            let bytes = [&owner_of(PRODUCT)[..], &bytes].concat();
            let unit = Unit::decode(PRODUCT, &bytes);
            prop_assert_eq!(Unit::decode(PRODUCT, &encoded(&unit)), unit);
        }
    }
}
