//! The start of an FSC node.

use super::protocol::Fsc;
use super::table::{Article, Product};
use crate::node::{AcquisitionOf, Boot, CanNode, CommunicationOf, ProductNode, owner};
use crate::store::Owner;
use crate::time::Instant;

/// A node of product `P` with the FSC protocol.
pub type FscNode<P> = CanNode<<P as Product>::Application, Fsc<P>>;

impl<P: Product> CanNode<P::Application, Fsc<P>> {
    /// A node after power-up or a restart. If the stored parameters are not usable, it has the factory values and sets
    /// EEPROMError.
    pub fn new(article: &Article, now: Instant, boot: &Boot) -> Self {
        let mut node = Self::INITIAL;
        node.start(article, now, boot);
        node
    }

    /// Starts an [`INITIAL`](Self::INITIAL) node in place.
    pub fn start(&mut self, article: &Article, now: Instant, boot: &Boot) {
        self.start_with(now, boot, |application, protocol, parameters, damaged| {
            P::set_article(application, article);
            protocol.restored(article, parameters, damaged);
        });
    }
}

impl<P: Product> ProductNode for FscNode<P> {
    type Application = P::Application;
    type Protocol = Fsc<P>;
    type Article = Article;

    const INITIAL: Self = Self::INITIAL;

    fn owner(article: &Article, serial: u32) -> Owner {
        owner::<P::Application>(article.image, serial)
    }

    fn start(&mut self, article: &Article, now: Instant, boot: &Boot) {
        self.start(article, now, boot);
    }

    fn halves(&mut self) -> (&mut CommunicationOf<Self>, &mut AcquisitionOf<Self>) {
        self.split()
    }
}
