//! DeviceNet: a Group 2 Only slave with the predefined master/slave connection set.
//!
//! A master allocates connections of the slave: an explicit one for requests, and I/O connections that the master polls or on which
//! the slave sends its values after a change or cyclically. Requests read and write the attributes of CIP objects.
//!
//! - [`table`]: how a product describes its objects, assemblies and identity; [`projection`]: their compact form in the device.

pub mod projection;
pub mod table;

pub use table::{Assembly, Attribute, Identity, Object, Product, Roles, Source};
