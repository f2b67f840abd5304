//! DeviceNet: a Group 2 Only slave with the predefined master/slave connection set.
//!
//! A master allocates connections of the slave: an explicit one for requests, and I/O connections that the master polls or on which
//! the slave sends its values after a change or cyclically. Requests read and write the attributes of CIP objects.
//!
//! - [`identifiers`]: the CAN identifiers.
//! - [`table`]: how a product describes its objects, assemblies and identity; [`projection`]: their compact form in the device.
//! - State machines: the duplicate MAC ID check, the connections and their allocation, fragments, the production of COS and cyclic
//!   messages, the LEDs, and the saves.
//! - The objects: identity, DeviceNet, assembly, connection, acknowledge handler, and those of the vendor.
//! - [`Devicenet`]: the protocol; [`DevicenetNode`]: a node with this protocol.

mod access;
mod allocation;
mod connection;
#[doc(hidden)]
pub mod consistency;
mod duplicate_check;
mod exchange;
mod explicit;
mod fragment;
pub mod identifiers;
mod leds;
mod objects;
mod production;
pub mod projection;
mod protocol;
mod requests;
mod saving;
pub mod table;

pub use allocation::choice;
pub use explicit::{general, service};
pub use objects::identity::BOOT;
pub use protocol::{Devicenet, DevicenetNode};
pub use table::{Assembly, Attribute, Identity, Object, Own, Product, Roles, Source};
