//! IS2D 90 P20 in the plastic housing: the older 2-axis type. Same as [IS2](super::is2), but the software version is coded as a number.

use crate::fsc::{Article, Version};
use crate::model::listing;
use crate::store::ImageId;

/// The node: that of the IS2.
pub type Is2d = super::is2::Is2;

/// The article with a plastic housing (PR-23054-30).
pub const PLASTIC: Article = Article {
    name: "IS2D 90 P20",
    version: Version::Number(103),
    image: ImageId::new(0x4712),
    ..super::is2::CLASSIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<super::is2::TwoAxes>("is2d", super::MAKER, &[PLASTIC])
        .guided(&super::functions::GUIDE_TWO_AXES);
