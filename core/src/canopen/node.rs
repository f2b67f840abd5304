//! The start of a CANopen node.

use super::product::Product;
use super::protocol::Canopen;
use crate::node::{Boot, CanNode};
use crate::store::ImageId;
use crate::time::Instant;

/// A node of product `P` with the CANopen protocol.
pub type CanopenNode<P> = CanNode<<P as Product>::Application, Canopen<P>>;

impl<P: Product> CanNode<P::Application, Canopen<P>> {
    /// The identification of the stored images of this product.
    pub const IMAGE: ImageId = P::IMAGE;

    /// A node after power-up or a restart. If the stored parameters are not usable, it has the factory values and the memory
    /// fault is active.
    pub fn new(now: Instant, boot: &Boot) -> Self {
        let mut node = Self::INITIAL;
        node.start(now, boot);
        node
    }

    /// Starts an [`INITIAL`](Self::INITIAL) node in place.
    pub fn start(&mut self, now: Instant, boot: &Boot) {
        self.start_with(now, boot, |_, protocol, parameters: &mut _, damaged| {
            protocol.restored(parameters, damaged);
        });
    }
}
