//! The start of a DeviceNet node.

use super::protocol::Devicenet;
use super::table::Product;
use crate::node::{Boot, CanNode};
use crate::store::ImageId;
use crate::time::Instant;

/// A node of product `P` with the DeviceNet protocol.
pub type DevicenetNode<P> = CanNode<<P as Product>::Application, Devicenet<P>>;

impl<P: Product> CanNode<P::Application, Devicenet<P>> {
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
