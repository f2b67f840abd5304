//! IS1D 00 P20 in the plastic housing: the older 1-axis type. Same as [IS1](super::is1), but the software version is coded as a number.

use crate::fsc::{Article, Version};
use crate::model::listing;
use crate::store::ImageId;

/// The node: that of the IS1.
pub type Is1d = super::is1::Is1;

/// The article with a plastic housing (PR-23050-30).
pub const PLASTIC: Article = Article {
    name: "IS1D 00 P20",
    version: Version::Number(103),
    image: ImageId::new(0x4711),
    ..super::is1::CLASSIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<super::is1::OneAxis>("is1d", super::MAKER, &[PLASTIC])
        .guided(&super::functions::GUIDE_ONE_AXIS);
