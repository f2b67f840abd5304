//! IS2TK090-C-RL: the 2-axis type of the reference line. Same protocol and measuring range as [IS2](super::is2), with a heated
//! measuring cell.

use crate::fsc::{Article, ArticleNumber, FscNode};
use crate::model::listing;
use crate::store::ImageId;

/// The product: tables and measurement of two axes, and the heater.
pub type TwoAxesHeated = super::heated::Heated<super::is2::TwoAxes>;

/// The node: what a driver or a test starts.
pub type Is2tk = FscNode<TwoAxesHeated>;

/// The article with a metal housing (PR-23024-30).
pub const METAL: Article = Article {
    name: "IS2TK090-C-RL",
    number: ArticleNumber::new("PR-23024-30"),
    image: ImageId::new(0x4722),
    ..super::is2::CLASSIC
};

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::fsc::<TwoAxesHeated>("is2tk", super::MAKER, &[METAL])
        .guided(&super::functions::GUIDE_TWO_AXES);
