//! The test bench: everything around a [`Node`](plumbline::node::Node) that is hardware on a board, in virtual time.
//!
//! - [`Flash`]: the microcontroller's flash, with a power-cut fuse and faults
//! - [`Device`]: one sensor: node, store, motion and CAN controller, driven as the firmware's main loop drives them
//! - [`Sensor`]: what the bus asks of a sensor, so that one on a simulated microcontroller can take a device's place
//! - [`Bus`]: the wire with its devices and adapters, accurate to the bit
//! - [`NodeType`]: what a sensor is: which node runs on it, and whose records its memory holds
//! - [`motion`] and [`thermal`]: where readings come from, and the heated cell around the accelerometer
//! - [`script`]: a node for tests of the bench itself
//!
//! The same bench serves the tests, which let virtual time run as fast as it can, and the virtual sensor, which lets it run
//! with the clock on the wall.

mod adapter;
mod bus;
mod controller;
mod device;
mod flash;
mod flash_file;
pub mod motion;
mod node_type;
pub mod script;
mod sensor;
pub mod thermal;

pub use bus::{AdapterId, Bus, BusRate, DeviceId, Logged, Source};
pub use device::Device;
pub use flash::{Flash, FlashError, PAGE_SIZE};
pub use node_type::{NodeType, STORE_BUFFER};
pub use sensor::Sensor;
