//! What a PC does with Plumbline's core, beside the crates in the folders of this one.
//!
//! - [`trace`]: recorded traffic, replayed against a sensor on the [`mod@bench`]
//! - [`fuzz`]: whatever may come, fed to a sensor
//! - [`calibrate`]: from a measurement to the calibration in a unit's memory
//! - [`documents`]: the Markdown files beside the models
//! - [`python`]: runs the clients written in Python, for the tests of every crate here
//!
//! Those crates are `can-wire` (the CAN protocol), `bench` (a sensor and its bus in virtual time), `stm32-sim` (the simulated
//! microcontroller), `virtual-sensor` (a sensor for real clients), `descriptors` (the models for other tools) and `cost` (what the
//! flashed image costs).

pub mod calibrate;
pub mod documents;
pub mod fuzz;
pub mod python;
#[cfg(target_os = "linux")]
pub mod trace;
