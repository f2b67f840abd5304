//! Everything a PC does with Plumbline's core, on the test bench of the crate [`bench`](::bench):
//!
//! - [`trace`]: recorded traffic, replayed against a sensor on the bench;
//! - [`fuzz`]: whatever may come, fed to a sensor;
//! - [`virtual_sensor`]: a sensor for real clients: [`slcan`], its [`server`], and the [`scene`] that it is in;
//! - [`python`]: clients written in Python, for the tests of every crate here.

pub mod calibrate;
pub mod fuzz;
pub mod python;
pub mod scene;
pub mod server;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod trace;
pub mod virtual_sensor;
