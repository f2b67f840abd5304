//! The measuring element of a program, in the number of its product.
//!
//! Bit 15 of a product in an image file, an ELF file or a boot record is the element: 0 for an ISM330DHCX, 1 for an ADXL355. So a bootloader
//! that compares products also compares elements. Bits 0 to 14 are the number of the [`ImageId`].

use crate::store::ImageId;

const ADXL355: u16 = 1 << 15;

/// The measuring element for which a program is built.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Element {
    /// Accelerometer and gyroscope.
    Ism330dhcx,
    /// Accelerometer.
    Adxl355,
}

impl Element {
    /// The name of the part.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ism330dhcx => "ISM330DHCX",
            Self::Adxl355 => "ADXL355",
        }
    }

    /// The element in the number of a product.
    pub const fn of(number: u16) -> Self {
        match number & ADXL355 {
            0 => Self::Ism330dhcx,
            _ => Self::Adxl355,
        }
    }

    /// The number of a product with this element.
    pub const fn with(self, product: u16) -> u16 {
        match self {
            Self::Ism330dhcx => product & !ADXL355,
            Self::Adxl355 => product | ADXL355,
        }
    }

    /// The number of the [`ImageId`] in the number of a product.
    pub const fn product(number: u16) -> u16 {
        number & !ADXL355
    }

    /// Whether this product can have an element in its number.
    pub(super) const fn fits(product: ImageId) -> bool {
        product.number() & ADXL355 == 0
    }
}
