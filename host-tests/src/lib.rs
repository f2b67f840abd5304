//! Tests and tools for Plumbline's core on a PC.
//!
//! - [`trace`]: recorded traffic, replayed against a sensor on the [`mod@bench`]
//! - [`fuzz`]: random input for a sensor
//! - [`bit_rate`]: a sensor that detects the bit rate
//! - [`calibrate`]: computes the calibration of a unit from a measurement and writes it into the store file of the unit
//! - [`delay`]: the delay of the angle
//! - [`documents`]: the Markdown files beside the models
//! - [`error_budget`]: the errors of the measuring elements as angles
//! - [`effort`]: the length of long tests
//! - [`plots`]: the plots of the low-pass and of the Kalman filter
//! - [`vibration`]: a sensor on a shaker
//! - [`python`]: runs the clients written in Python, for the tests of all crates in this folder
//!
//! The crates in this folder are `can-wire` (the CAN protocol), `bench` (a sensor and its bus in virtual time), `stm32-sim` (the
//! simulated microcontroller), `virtual-sensor` (a sensor for real clients), `adapter` (CAN adapters), `texts` (messages in English and
//! German), `descriptors` (EDS and DBC files of the products) and `cost` (flash, RAM and time of the image).

pub mod bit_rate;
pub mod calibrate;
pub mod delay;
pub mod documents;
pub mod effort;
pub mod error_budget;
pub mod fuzz;
pub mod plots;
pub mod python;
pub mod rise_time;
pub mod store_file;
#[cfg(target_os = "linux")]
pub mod trace;
pub mod vibration;
