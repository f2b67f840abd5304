//! The start of a node of a product, for programs on a PC: the node is on the heap, which an image for a board does not have.

extern crate alloc;

use super::{Product, Protocol, Settings};
use crate::fsc::Article;
use crate::node::{Node, ProductNode};
use alloc::boxed::Box;

/// Starts a node of a product; None if the settings select an article that the product does not have.
pub type PowerUp = fn(&Product, &Settings) -> Option<Box<dyn Node>>;

impl Product {
    /// Starts a node as after power-up; None if the settings select an article that the product does not have.
    pub fn start(&self, settings: &Settings) -> Option<Box<dyn Node>> {
        (self.power_up)(self, settings)
    }

    /// Whether the settings select its only article.
    fn has_article(&self, settings: &Settings) -> bool {
        let mut articles = self.articles();
        settings
            .article
            .is_none_or(|wanted| articles.any(|article| article.is(wanted)))
    }
}

/// The start of a product with articles.
pub(super) fn fsc<N: ProductNode<Article = Article>>(
    product: &Product,
    settings: &Settings,
) -> Option<Box<dyn Node>> {
    let Protocol::Fsc(tables) = &product.protocol else {
        return None;
    };
    let mut articles = tables.articles.iter();
    let article = match settings.article {
        Some(wanted) => articles.find(|article| super::fsc::article(article).is(wanted)),
        None => articles.next(),
    };
    Some(start::<N>(article?, settings))
}

/// The start of a product with one article.
pub(super) fn sole<N: ProductNode<Article = ()>>(
    product: &Product,
    settings: &Settings,
) -> Option<Box<dyn Node>> {
    product
        .has_article(settings)
        .then(|| start::<N>(&(), settings))
}

fn start<N: ProductNode>(article: &N::Article, settings: &Settings) -> Box<dyn Node> {
    let mut node = Box::new(N::INITIAL);
    node.start(article, settings.now, &settings.boot);
    node
}
