//! The catalogue entry of a DeviceNet product.

use super::{Article, Guide, Product, Protocol, Settings, Start};
use crate::application::Application;
use crate::devicenet::{self, Assembly, DevicenetNode, Identity, Object, Roles};
use crate::param::Table;
use core::marker::PhantomData;

/// The tables of a product with the DeviceNet protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// Its only article.
    pub article: Article,
    /// The identity.
    pub identity: Identity,
    /// The parameters that the protocol uses.
    pub roles: Roles,
    /// The objects of the vendor.
    pub objects: &'static [Object],
    /// The input assemblies.
    pub assemblies: &'static [Assembly],
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

/// A catalogue entry: the tables of `P` with a single article.
pub struct Listing<P> {
    /// The short name.
    pub name: &'static str,
    article: Article,
    guide: &'static Guide,
    product: PhantomData<P>,
}

impl<P: devicenet::Product> Listing<P> {
    /// The catalogue entry of product `P`. The order number of its article is the catalogue number of the identity.
    pub const fn new(name: &'static str, article: &'static str) -> Self {
        Self {
            name,
            article: Article {
                name: article,
                number: P::IDENTITY.catalog,
            },
            guide: &Guide::NONE,
            product: PhantomData,
        }
    }

    /// The same with a guide for tools.
    pub const fn guided(self, guide: &'static Guide) -> Self {
        Self { guide, ..self }
    }

    /// The product as data.
    pub const fn product(&self) -> Product {
        Product {
            name: self.name,
            maker: P::IDENTITY.vendor_name,
            protocol: Protocol::Devicenet(Tables {
                article: self.article,
                identity: P::IDENTITY,
                roles: P::ROLES,
                objects: P::OBJECTS,
                assemblies: P::ASSEMBLIES,
            }),
            parameters: <P::Application as Application>::Table::PARAMETERS,
            constraints: <P::Application as Application>::Table::CONSTRAINTS,
            quantities: <P::Application as Application>::QUANTITIES,
            heater: <P::Application as Application>::HEATER,
            has_gyroscope: <P::Application as Application>::HAS_GYROSCOPE,
            image: P::IMAGE,
            layout: <P::Application as Application>::Table::LAYOUT,
            store_buffer: DevicenetNode::<P>::STORE_BUFFER,
            guide: self.guide,
        }
    }

    /// Starts a node; None if the settings select another article.
    pub fn start<S: Start>(&self, settings: &Settings, start: S) -> Option<S::Output> {
        if settings
            .article
            .is_some_and(|wanted| !self.article.is(wanted))
        {
            return None;
        }
        let node = DevicenetNode::<P>::new(settings.now, &settings.boot);
        Some(start.start(node))
    }
}
