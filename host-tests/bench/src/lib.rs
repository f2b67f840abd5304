//! The test bench: the hardware around a [`Node`](plumbline::node::Node), in virtual time.
//!
//! - [`Flash`]: the microcontroller's flash, with a power-cut fuse and faults
//! - [`Device`]: one sensor: node, store, motion and CAN controller, driven as the firmware's main loop drives them
//! - [`Updatable`]: a device behind the bootloader of the core
//! - [`Sensor`]: the interface between the bus and a sensor, for a [`Device`] or a simulated microcontroller
//! - [`Bus`]: the wire with its devices and adapters, accurate to the bit
//! - [`NodeType`]: the type of a sensor: its node and the owner of the records in its memory
//! - [`motion`] and [`thermal`]: the source of readings, and the heated cell around the accelerometer
//! - [`scene`]: the motion of a virtual sensor
//! - [`fault`]: faults of the accelerometer
//! - [`stage`]: motion, surroundings and faults that change while a sensor runs
//! - [`bit_rate`]: the bit rate as an option of a program
//! - [`script`]: a node for tests of the bench itself
//!
//! The tests and the virtual sensor use the same bench. The tests run virtual time as fast as possible, the virtual sensor runs
//! it in real time.

mod accelerometer;
mod adapter;
mod bit_rate;
mod bus;
mod controller;
mod device;
pub mod fault;
pub mod file;
mod flash;
mod hardware;
mod mailboxes;
pub mod motion;
mod node_type;
mod receive_pin;
pub mod scene;
pub mod script;
mod sensor;
pub mod stage;
pub mod thermal;
mod updatable;

pub use bit_rate::{bit_rate, in_bits};
pub use bus::{AdapterId, Bus, BusRate, DeviceId, Logged, Source};
pub use device::Device;
pub use flash::{Flash, FlashError, Geometry, PAGE_SIZE};
pub use node_type::{NodeType, STORE_BUFFER, Starts};
pub use receive_pin::ReceivePin;
pub use sensor::Sensor;
pub use updatable::Updatable;
