//! CANopen (CiA 301): what every sensor that speaks it has in common.
//!
//! A master reads and writes the objects of a dictionary with SDOs, moves the sensor between NMT states, and gets the inclination
//! in PDOs, by itself or with the SYNC. Section numbers are those of CiA 301, version 4.2.
//!
//! - [`wire`]: identifiers, and the bytes of SDO requests and replies;
//! - [`nmt`]: states and commands;
//! - [`dictionary`]: how a model's objects are described, and the lean rules that the device keeps of that;
//! - [`Values`]: the parameters' values, their range checks and their place in the image in nonvolatile memory;
//! - [`sdo`]: the server; [`pdo`]: transmit PDOs; [`emcy`]: errors; [`sync`], [`guarding`] and the heartbeat;
//! - [`Model`]: what a product adds;
//! - [`Device`]: the node that puts these together.

mod abort;
mod device;
pub mod dictionary;
pub mod emcy;
pub mod guarding;
pub mod key;
mod model;
pub mod nmt;
mod node;
mod objects;
pub mod pdo;
mod saving;
pub mod sdo;
pub mod sync;
mod timer;
pub mod values;
pub mod wire;

pub use abort::Abort;
pub use device::Device;
pub use key::{Key, OWN};
pub use model::{Effect, LedTable, Model, TEXT_MAX, Text};
pub use timer::Periodic;
pub use values::Values;
