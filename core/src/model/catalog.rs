//! The list of all products: names, tables as data, and the start of a node.
//!
//! For programs on a PC that use all products: the virtual sensor, descriptors, tests. A firmware image uses the type of its
//! product and does not link this module.
//!
//! ```
//! use plumbline::model::catalog::{PRODUCTS, Settings, with};
//!
//! for product in PRODUCTS {
//!     let settings = Settings::default();
//!     let deadline = with(product.name, &settings, |node| node.deadline());
//!     assert!(deadline.is_some(), "{} was not started", product.name);
//! }
//! ```

pub use super::listing::{
    Adjustment, Article, Guide, Product, Protocol, Resolution, Settings, Start, Written,
};
use super::{gemac, ims360, jn2101, tiltix};
use crate::node::Node;

macro_rules! products {
    ($($product:path),* $(,)?) => {
        /// All products.
        pub const PRODUCTS: &[Product] = &[$($product.product()),*];

        /// Starts a node of the product with this name as after power-up. None if the product or article does not exist.
        pub fn start<S: Start>(name: &str, settings: &Settings, start: S) -> Option<S::Output> {
            $(
                if name == $product.name {
                    return $product.start(settings, start);
                }
            )*
            None
        }
    };
}

products![
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

/// Starts a node of the product with this name and passes it to `run`. None if the product or article does not exist.
pub fn with<T>(name: &str, settings: &Settings, run: impl FnOnce(&mut dyn Node) -> T) -> Option<T> {
    struct With<F>(F);

    impl<T, F: FnOnce(&mut dyn Node) -> T> Start for With<F> {
        type Output = T;

        fn start<N: Node + 'static>(self, mut node: N) -> T {
            self.0(&mut node)
        }
    }

    start(name, settings, With(run))
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
                    let started = with(product.name, &settings, |node| node.deadline());
                    assert!(started.is_some(), "{} {wanted}", product.name);
                }
            }
        }
    }

    #[test]
    fn unknown_product_or_article_is_not_started() {
        assert!(find("is3").is_none());
        assert_eq!(with("is3", &Settings::default(), |_| ()), None);
        let settings = Settings {
            article: Some("PR-00000-00"),
            ..Settings::default()
        };
        assert_eq!(with("is2", &settings, |_| ()), None);
    }
}
