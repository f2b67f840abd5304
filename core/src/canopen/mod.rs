//! CANopen (CiA 301): what every sensor that speaks it has in common.
//!
//! A master reads and writes the objects of a dictionary with SDOs, moves the sensor between NMT states, and gets the inclination
//! in PDOs, by itself or with the SYNC. Section numbers are those of CiA 301, version 4.2.
//!
//! - [`mod@cob_id`], the identifiers.
//! - [`dictionary`], how a product describes its objects, and what the device keeps of that; [`profile`], the objects of CiA 301.
//! - [`nmt`], states and commands; [`sdo`], the server; [`pdo`], transmit PDOs; [`emcy`], errors; guarding and the heartbeat.
//! - [`Product`], what a product says of itself.
//! - [`Canopen`], the protocol that puts these together; [`CanopenNode`], a node that speaks it.

mod abort;
pub mod cob_id;
pub mod dictionary;
pub mod emcy;
mod guarding;
pub mod nmt;
mod node;
mod objects;
pub mod pdo;
mod product;
pub mod profile;
mod protocol;
mod reset;
mod saving;
pub mod sdo;
pub mod setting;
mod timer;

pub use abort::Abort;
pub use dictionary::Object;
pub use node::CanopenNode;
pub use pdo::{Tpdo, TpdoArray, Tpdos};
pub use product::{ErrorHistory, LedTable, Product, Text};
pub use protocol::Canopen;
