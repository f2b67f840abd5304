//! SAE J1939: the network of vehicles and machines.
//!
//! The node claims an address, sends its measurements to all nodes, answers requests, and reports its active faults. Its parameters are
//! the objects of its CANopen object dictionary: the bytes of an SDO in frames of Proprietary A.
//!
//! - [`identifier`]: the 29-bit identifier; [`name`]: the NAME; [`claim`]: the address;
//! - [`request`]: request and acknowledgement; [`transport`]: messages of more than eight bytes;
//! - [`groups`]: the groups with process data, described by their [signals](signal); [`diagnostics`]: active trouble codes;
//! - [`Product`]: the description of a product; [`J1939`]: the protocol, which consists of these services;
//! - [`CanopenOrJ1939`]: both protocols in one node, a [`DualNode`].

pub mod claim;
pub mod diagnostics;
mod dual;
pub mod groups;
mod identification;
pub mod identifier;
pub mod name;
mod product;
mod protocol;
mod receive;
pub mod request;
mod sending;
pub mod signal;
pub mod transport;

pub use dual::{CanopenOrJ1939, DualNode};
pub use product::{Conditions, Product};
pub use protocol::J1939;
