//! IS1D 00 P20 in the metal housing: as in the [plastic housing](super::is1d), with the heated measuring cell of
//! [IS1TK](super::is1tk) (section 5.3 of the German manual).

use super::is1tk::{Is1tk, OneAxisHeated};
use crate::fsc::Article;
use crate::model::listing;
use crate::store::ImageId;

/// The node: that of the IS1TK.
pub type Is1dm = Is1tk;

/// The article with a metal housing (PR-23020-30).
pub const METAL: Article = Article {
    number: super::is1tk::METAL.number,
    image: ImageId::new(0x4731),
    ..super::is1d::PLASTIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<OneAxisHeated>("is1dm", super::MAKER, &[METAL])
        .guided(&super::functions::GUIDE_ONE_AXIS);
