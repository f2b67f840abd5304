//! The start of a node of a product, for programs on a PC: the node is on the heap, which an image for a board does not have.

extern crate alloc;

use super::{Product, Protocol, Settings};
use crate::canopen::{self, CanopenNode};
use crate::devicenet::{self, DevicenetNode};
use crate::fsc::{self, FscNode};
use crate::model::dual::{Both, DualNode};
use crate::node::Node;
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

pub(super) fn fsc<P: fsc::Product>(
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
    let node = FscNode::<P>::new(article?, settings.now, &settings.boot);
    Some(Box::new(node))
}

pub(super) fn canopen<P: canopen::Product>(
    product: &Product,
    settings: &Settings,
) -> Option<Box<dyn Node>> {
    let node = || CanopenNode::<P>::new(settings.now, &settings.boot);
    product
        .has_article(settings)
        .then(|| Box::new(node()) as Box<dyn Node>)
}

pub(super) fn with_j1939<P: Both>(product: &Product, settings: &Settings) -> Option<Box<dyn Node>> {
    let node = || DualNode::<P>::new(settings.now, &settings.boot);
    product
        .has_article(settings)
        .then(|| Box::new(node()) as Box<dyn Node>)
}

pub(super) fn devicenet<P: devicenet::Product>(
    product: &Product,
    settings: &Settings,
) -> Option<Box<dyn Node>> {
    let node = || DevicenetNode::<P>::new(settings.now, &settings.boot);
    product
        .has_article(settings)
        .then(|| Box::new(node()) as Box<dyn Node>)
}
