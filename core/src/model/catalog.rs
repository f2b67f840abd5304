//! The list of all products: names, tables as data, and the start of a node.
//!
//! For programs on a PC that use all products: the virtual sensor, descriptors, tests. A firmware image uses the type of its
//! product and does not link this module.
//!
//! ```
//! use plumbline::model::catalog::{PRODUCTS, Settings};
//!
//! for product in PRODUCTS {
//!     let node = product.start(&Settings::default());
//!     assert!(node.is_some(), "{} was not started", product.name);
//! }
//! ```

pub use super::listing::{
    Adjustment, Article, Guide, Product, Protocol, Resolution, Settings, Written,
};
use super::{gemac, ims360, jn2101, tiltix};

/// All products.
pub const PRODUCTS: &[Product] = &[
    gemac::is1::LISTING,
    gemac::is2::LISTING,
    gemac::is1d::LISTING,
    gemac::is2d::LISTING,
    gemac::is1dm::LISTING,
    gemac::is2dm::LISTING,
    gemac::is1tk::LISTING,
    gemac::is2tk::LISTING,
    jn2101::LISTING,
    ims360::LISTING,
    tiltix::tiltix080::LISTING,
    tiltix::tiltix360::LISTING,
];

/// The product with this name.
pub fn find(name: &str) -> Option<&'static Product> {
    PRODUCTS.iter().find(|product| product.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_images_are_different() {
        for (place, one) in PRODUCTS.iter().enumerate() {
            for other in &PRODUCTS[..place] {
                assert_ne!(one.name, other.name);
                assert_ne!(one.image, other.image, "{} and {}", one.name, other.name);
            }
        }
    }

    #[test]
    fn article_is_started_by_name_and_by_number() {
        for product in PRODUCTS {
            for article in product.articles() {
                for wanted in [article.name, article.number] {
                    let settings = Settings {
                        article: Some(wanted),
                        ..Settings::default()
                    };
                    let started = product.start(&settings);
                    assert!(started.is_some(), "{} {wanted}", product.name);
                }
            }
        }
    }

    #[test]
    fn unknown_product_is_not_found_and_unknown_article_not_started() {
        assert!(find("is3").is_none());
        let settings = Settings {
            article: Some("PR-00000-00"),
            ..Settings::default()
        };
        for product in PRODUCTS {
            assert!(product.start(&settings).is_none(), "{}", product.name);
        }
    }
}
