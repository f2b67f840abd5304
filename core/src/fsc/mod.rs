//! GEMAC's function select codes: a raw CAN protocol in which the first data byte says what is meant.
//!
//! A request comes on the Set-Parameter-ID, its reply goes out on the Reply-Parameter-ID and echoes the function select code
//! (FSC). A frame without data on the Sync-ID asks every sensor for its inclination, and in cyclic mode the sensor sends it by
//! itself. Section and table numbers refer to the English manual of 2021 (IS1xx360-C-xL, IS2xx090-C-xL).
//!
//! - [`wire`]: the bytes of requests and replies;
//! - [`code`]: the function select codes;
//! - [`table`]: how a model's parameters and functions are described, and the lean rules that the device keeps of that;
//! - [`Values`]: the parameters' values, their range checks and their place in the EEPROM image;
//! - [`Status`]: the status byte in every reply;
//! - [`Sensor`]: the node that puts these together: it answers requests, synchronously and cyclically, and keeps its measuring cell
//!   warm where the model has a heater.

pub mod code;
mod cyclic;
mod heating;
mod key;
mod measured;
mod node;
mod request;
mod sensor;
mod status;
pub mod table;
mod values;
pub mod wire;

pub use key::Key;
pub use measured::Measured;
pub use sensor::Sensor;
pub use status::Status;
pub use table::{Model, Product, Version};
pub use values::Values;
