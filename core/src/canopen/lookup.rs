//! The rows of a product by their address.

use super::Abort;
use super::emcy::History;
use super::product::Product;
use super::row::{Row, find};
use super::sdo::message::Address;

/// The row at an address; None if the dictionary has no such object.
pub(super) fn find_row<P: Product>(index: u16, sub: u8) -> Option<&'static Row> {
    lookup::<P>(Address { index, sub }).ok()
}

/// The row at an address, or the reason why there is none.
pub(super) fn lookup<P: Product>(address: Address) -> Result<&'static Row, Abort> {
    find(P::ROWS, P::History::CAPACITY, address)
}
