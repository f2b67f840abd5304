//! IS2D 90 P20 in the metal housing: as in the [plastic housing](super::is2d), with the heated measuring cell of
//! [IS2TK](super::is2tk) (section 5.3 of the German manual).

use super::is2tk::{Is2tk, TwoAxesHeated};
use crate::fsc::Article;
use crate::model::listing;
use crate::store::ImageId;

/// The node: that of the IS2TK.
pub type Is2dm = Is2tk;

/// The article with a metal housing (PR-23024-30).
pub const METAL: Article = Article {
    number: super::is2tk::METAL.number,
    image: ImageId::new(0x4732),
    ..super::is2d::PLASTIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<TwoAxesHeated>("is2dm", super::MAKER, &[METAL])
        .guided(&super::functions::GUIDE_TWO_AXES);
