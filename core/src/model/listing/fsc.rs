//! The catalogue entry of an FSC product.

use super::{Guide, Product, Protocol, Settings, Start};
use crate::application::Application;
use crate::fsc::table::{Access, Function, LedTable, Roles};
use crate::fsc::{self, Article, FscNode, StatusBit};
use crate::param::Table;
use core::marker::PhantomData;

/// The tables of a product with the FSC protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// Its articles.
    pub articles: &'static [Article],
    /// The parameters that the protocol uses.
    pub roles: Roles,
    /// The codes that read and write parameters.
    pub access: &'static [Access],
    /// The other functions.
    pub functions: &'static [Function],
    /// The status byte, from bit 0 on.
    pub status: [StatusBit; 8],
    /// The LED patterns.
    pub leds: LedTable,
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<super::Article> {
        self.articles.get(place).map(|article| super::Article {
            name: article.name,
            number: article.number.text(),
        })
    }
}

/// A catalogue entry: the tables of `P` with its articles.
pub struct Listing<P> {
    /// The short name.
    pub name: &'static str,
    maker: &'static str,
    articles: &'static [Article],
    guide: &'static Guide,
    product: PhantomData<P>,
}

impl<P: fsc::Product> Listing<P> {
    /// The catalogue entry of product `P` with at least one article.
    pub const fn new(
        name: &'static str,
        maker: &'static str,
        articles: &'static [Article],
    ) -> Self {
        Self {
            name,
            maker,
            articles,
            guide: &Guide::NONE,
            product: PhantomData,
        }
    }

    /// The same with a guide for tools.
    pub const fn guided(self, guide: &'static Guide) -> Self {
        Self { guide, ..self }
    }

    /// The product as data. Articles with different image ids are a compile error.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub const fn product(&self) -> Product {
        let image = self.articles[0].image;
        let mut row = 1;
        while row < self.articles.len() {
            assert!(self.articles[row].image.number() == image.number());
            row += 1;
        }
        Product {
            name: self.name,
            maker: self.maker,
            protocol: Protocol::Fsc(Tables {
                articles: self.articles,
                roles: P::ROLES,
                access: P::ACCESS,
                functions: P::FUNCTIONS,
                status: P::STATUS,
                leds: P::LEDS,
            }),
            parameters: <P::Application as Application>::Table::PARAMETERS,
            constraints: <P::Application as Application>::Table::CONSTRAINTS,
            quantities: <P::Application as Application>::QUANTITIES,
            heater: <P::Application as Application>::HEATER,
            has_gyroscope: <P::Application as Application>::HAS_GYROSCOPE,
            image,
            layout: <P::Application as Application>::Table::LAYOUT,
            store_buffer: FscNode::<P>::STORE_BUFFER,
            guide: self.guide,
        }
    }

    /// Starts a node; None if the article does not exist.
    pub fn start<S: Start>(&self, settings: &Settings, start: S) -> Option<S::Output> {
        let article = match settings.article {
            Some(wanted) => self
                .articles
                .iter()
                .find(|article| [article.name, article.number.text()].contains(&wanted)),
            None => self.articles.first(),
        };
        let node = FscNode::<P>::new(article?, settings.now, &settings.boot);
        Some(start.start(node))
    }
}
