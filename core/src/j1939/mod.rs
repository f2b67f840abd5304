//! The services of SAE J1939, the network of vehicles and machines. Each is a state machine of its own.
//!
//! - [`identifier`]: the 29-bit identifier; [`name`]: the NAME; [`claim`]: the address;
//! - [`request`]: request and acknowledgement; [`transport`]: messages of more than eight bytes;
//! - [`groups`]: the groups with process data, described by their [signals](signal); [`diagnostics`]: active trouble codes;
//! - [`Product`]: the description of a product; [`J1939`]: these services together, also for a node with another protocol besides;
//! - [`Standalone`]: the protocol of a node that has only J1939, a [`J1939Node`]. `core/examples/new_j1939_sensor.rs` is such a sensor.

pub mod claim;
mod consistency;
pub mod diagnostics;
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
mod standalone;
mod timers;
pub mod transport;

pub use consistency::Checked;
pub use product::{Conditions, Product, Sent};
pub use protocol::J1939;
pub use receive::Proprietary;
pub use standalone::{J1939Node, Standalone};
pub use timers::{Timer, Timers};
