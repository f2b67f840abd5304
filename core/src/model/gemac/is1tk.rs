//! IS1TK360-C-RL: the 1-axis type of the reference line. Same protocol and measuring range as [IS1](super::is1), with a heated
//! measuring cell.

use crate::fsc::{Article, ArticleNumber, FscNode};
use crate::model::listing;
use crate::store::ImageId;

/// The product: tables and measurement of one axis, and the heater.
pub type OneAxisHeated = super::heated::Heated<super::is1::OneAxis>;

/// The node: what a driver or a test starts.
pub type Is1tk = FscNode<OneAxisHeated>;

/// The article with a metal housing (PR-23020-30).
pub const METAL: Article = Article {
    name: "IS1TK360-C-RL",
    number: ArticleNumber::new("PR-23020-30"),
    image: ImageId::new(0x4721),
    ..super::is1::CLASSIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<OneAxisHeated>("is1tk", super::MAKER, &[METAL])
        .guided(&super::functions::GUIDE_ONE_AXIS);
