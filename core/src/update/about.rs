//! What the ELF file of a program says of it: the section `.plumbline.program`, which is not loaded.
//!
//! ```text
//!  byte 0         2       3       4       6
//!       +---------+-------+-------+-------+
//!       | product | patch | minor | major |
//!       | u16     | u8    | u8    | u16   |
//!       +---------+-------+-------+-------+
//! ```
//!
//! The product has its [measuring element](Element) in bit 15. Numbers are little-endian, so bytes 2 to 6 are the version of a
//! [`Header`](super::Header).

use super::element::Element;
use super::header::version;
use crate::store::ImageId;

/// The length of the section in bytes.
pub const SIZE: usize = 6;

/// The product and the version of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(transparent)]
pub struct About([u8; SIZE]);

impl About {
    /// The contents of the section. `version` has the numbers of the package: major, minor, patch.
    ///
    /// # Panics
    /// If one of them is no number, or too large, or if the number of the product is above 7FFFh. In a constant this is a compile error.
    pub const fn new(product: ImageId, element: Element, numbers: [&str; 3]) -> Self {
        assert!(Element::fits(product), "an image id is at most 7FFFh");
        let [major, minor, patch] = numbers;
        let version = version(decimal(major), decimal(minor), decimal(patch));
        let [a, b] = element.with(product.number()).to_le_bytes();
        let [c, d, e, f] = version.to_le_bytes();
        Self([a, b, c, d, e, f])
    }

    /// The contents of the section; None if it is not of this length.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        Some(Self(bytes.try_into().ok()?))
    }

    /// The product, the number of its [`ImageId`].
    pub const fn product(&self) -> u16 {
        Element::product(self.number())
    }

    /// The measuring element.
    pub const fn element(&self) -> Element {
        Element::of(self.number())
    }

    const fn number(&self) -> u16 {
        let [a, b, ..] = self.0;
        u16::from_le_bytes([a, b])
    }

    /// The version.
    pub const fn version(&self) -> u32 {
        let [_, _, rest @ ..] = self.0;
        u32::from_le_bytes(rest)
    }
}

const fn decimal(text: &str) -> u32 {
    let number = u32::from_str_radix(text, 10);
    assert!(number.is_ok(), "a version has three numbers");
    match number {
        Ok(number) => number,
        Err(_) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn section_has_product_element_and_version() {
        let about = About::new(ImageId::new(0x0102), Element::Adxl355, ["3", "4", "5"]);
        assert_eq!(about.0, [2, 0x81, 5, 4, 3, 0]);
        assert_eq!(About::parse(&about.0), Some(about));
        assert_eq!((about.product(), about.version()), (0x0102, 0x0003_0405));
        assert_eq!(about.element(), Element::Adxl355);
        assert_eq!(About::parse(&[0; 5]), None);
    }
}
