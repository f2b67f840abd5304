//! IS2D 90 P20: the older 2-axis type. It speaks as [IS2](super::is2) does and writes its software version as a number.

use crate::fsc::{Product, Version};
use crate::store::ImageId;

/// The sensor.
pub type Is2d = super::is2::Is2;

/// Plastic housing (PR-23054-30).
pub static PLASTIC: Product = Product {
    name: "IS2D 90 P20",
    version: Version::Number(103),
    image: ImageId(0x4712),
    ..super::is2::CLASSIC
};
