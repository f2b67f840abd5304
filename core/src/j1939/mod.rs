//! The services of SAE J1939, the network of vehicles and machines. Each is a state machine of its own. No product uses them yet.
//!
//! - [`identifier`]: the 29-bit identifier; [`name`]: the NAME; [`claim`]: the address;
//! - [`request`]: request and acknowledgement; [`transport`]: messages of more than eight bytes;
//! - [`groups`]: the groups with process data, described by their [signals](signal); [`diagnostics`]: active trouble codes.

pub mod claim;
pub mod diagnostics;
pub mod groups;
pub mod identifier;
pub mod name;
pub mod request;
pub mod signal;
pub mod transport;
