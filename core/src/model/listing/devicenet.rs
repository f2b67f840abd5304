//! The catalogue entry of a DeviceNet product.

use super::{Article, Product, Protocol, check_article};
use crate::devicenet::{self, Assembly, DevicenetNode, Identity, Object, Roles};

/// The tables of a product with the DeviceNet protocol.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The only article of the product.
    pub article: Article,
    /// The identity object (class 1).
    pub identity: Identity,
    /// The parameters that the protocol uses.
    pub roles: Roles,
    /// The objects of the vendor.
    pub objects: &'static [Object],
    /// The assemblies that I/O messages can contain.
    pub assemblies: &'static [Assembly],
}

impl Tables {
    pub(super) fn article(&self, place: usize) -> Option<Article> {
        (place == 0).then_some(self.article)
    }
}

impl Product {
    /// The product `P` with an article of this name, whose order number is the catalogue number of the identity.
    #[track_caller]
    pub const fn devicenet<P: devicenet::Product>(
        name: &'static str,
        article: &'static str,
    ) -> Self {
        let article = Article {
            name: article,
            number: P::IDENTITY.catalog,
        };
        check_article(&article);
        let protocol = Protocol::Devicenet(Tables {
            article,
            identity: P::IDENTITY,
            roles: P::ROLES,
            objects: P::OBJECTS,
            assemblies: P::ASSEMBLIES,
        });
        let maker = P::IDENTITY.vendor_name;
        Self {
            #[cfg(not(target_os = "none"))]
            power_up: super::start::sole::<DevicenetNode<P>>,
            ..Self::of::<DevicenetNode<P>>(name, maker, protocol, P::IMAGE)
        }
    }
}
