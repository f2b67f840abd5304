//! The services of SAE J1939, the network of vehicles and machines. Each is a state machine of its own.
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
mod messages;
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
