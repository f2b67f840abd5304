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
    Adjustment, Article, Guide, Offset, Product, Protocol, Resolution, Settings, Switch, Written,
};

/// All products of this crate, in the order in which tools list them.
pub const PRODUCTS: &[Product] = &[
    super::gemac::is1::LISTING,
    super::gemac::is2::LISTING,
    super::gemac::is1d::LISTING,
    super::gemac::is2d::LISTING,
    super::gemac::is1dm::LISTING,
    super::gemac::is2dm::LISTING,
    super::gemac::is1tk::LISTING,
    super::gemac::is2tk::LISTING,
    super::jn2101::LISTING,
    super::ims360::LISTING,
    super::tiltix::tiltix080::LISTING,
    super::tiltix::tiltix360::LISTING,
];

/// The product with this short name, for example `is2`.
pub fn find(name: &str) -> Option<&'static Product> {
    PRODUCTS.iter().find(|product| product.name == name)
}

/// The first product whose node has the same type. The others differ from it by constants only.
pub fn base(product: &Product) -> Option<&'static Product> {
    PRODUCTS.iter().find(|other| other.node == product.node)
}

/// The products that do not differ from an earlier one by constants only.
pub fn bases() -> impl Iterator<Item = &'static Product> {
    let is_base = |product: &&Product| base(product).is_some_and(|base| base.name == product.name);
    PRODUCTS.iter().filter(is_base)
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
    fn products_that_differ_by_constants_have_the_same_base() {
        for (name, expected) in [("is1d", "is1"), ("is2tk", "is2dm"), ("ims360", "ims360")] {
            let found = find(name).and_then(base).map(|base| base.name);
            assert_eq!(found, Some(expected));
        }
        let names = ["is1", "is2", "is1dm", "is2dm", "jn2101"];
        assert!(bases().map(|base| base.name).take(5).eq(names));
    }

    #[test]
    fn products_of_other_makers_are_replaced() {
        assert!(PRODUCTS.iter().all(Product::is_replacement));
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
