//! The catalogue entry of an FSC product.

use super::{Product, Protocol};
use crate::fsc::table::{Access, Function, LedTable, Roles};
use crate::fsc::{self, Article, FscNode, StatusBit};
use crate::walk::{at, each};

/// The tables of a product with the FSC protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The articles of the product, the default first.
    pub articles: &'static [Article],
    /// The parameters that the protocol uses.
    pub roles: Roles,
    /// The codes that read and write parameters.
    pub access: &'static [Access],
    /// The functions that do not access parameters.
    pub functions: &'static [Function],
    /// The status byte, from bit 0 on.
    pub status: [StatusBit; 8],
    /// The LED patterns while the bit rate is being detected and in operation.
    pub leds: LedTable,
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<super::Article> {
        self.articles.get(place).map(article)
    }
}

pub(super) fn article(article: &Article) -> super::Article {
    super::Article {
        name: article.name,
        number: article.number.text(),
    }
}

impl Product {
    /// The product `P` with at least one article, compatible with sensors of this maker. Articles with different image ids are a
    /// compile error.
    #[track_caller]
    pub const fn fsc<P: fsc::Product>(
        name: &'static str,
        maker: &'static str,
        articles: &'static [Article],
    ) -> Self {
        let image = at(articles, 0).image;
        each!(article in articles => {
            assert!(
                article.image.number() == image.number(),
                "the articles of a product have the same image id"
            );
        });
        let protocol = Protocol::Fsc(Tables {
            articles,
            roles: P::ROLES,
            access: P::ACCESS,
            functions: P::FUNCTIONS,
            status: P::STATUS,
            leds: P::LEDS,
        });
        Self {
            #[cfg(not(target_os = "none"))]
            power_up: super::start::fsc::<FscNode<P>>,
            ..Self::of::<FscNode<P>>(name, maker, protocol, image)
        }
    }
}
