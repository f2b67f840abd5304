//! How a CANopen node starts.

use super::product::Product;
use super::protocol::Canopen;
use crate::node::{Boot, CanNode};
use crate::store::ImageId;
use crate::time::Instant;

/// A node of product `P` that speaks CANopen.
pub type CanopenNode<P> = CanNode<<P as Product>::Application, Canopen<P>>;

impl<P: Product> CanNode<P::Application, Canopen<P>> {
    /// Marks the images of this product.
    pub const IMAGE: ImageId = P::IMAGE;

    /// A node after power-up or a restart. Stored parameters that cannot be used give factory values and the fault of the memory.
    pub fn new(now: Instant, boot: &Boot) -> Self {
        let mut node = Self::INITIAL;
        node.start(now, boot);
        node
    }

    /// Starts an [`INITIAL`](Self::INITIAL) node where it is.
    pub fn start(&mut self, now: Instant, boot: &Boot) {
        self.start_with(now, boot, |_, protocol, parameters, damaged| {
            protocol.restored(parameters, damaged);
        });
    }
}
