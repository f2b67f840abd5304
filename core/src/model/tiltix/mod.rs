//! POSITAL TILTIX with DeviceNet, 080 and 360.
//!
//! Section numbers refer to the user manual "TILTIX MEMS inclinometer with DeviceNet interface" of 28 September 2011.
//!
#![doc = include_str!("README.md")]

mod application;
mod objects;
mod parameters;
pub mod tiltix080;
pub mod tiltix360;

pub use application::{Axes, Inclination, Tiltix, value};
pub use parameters::{Range, id};

/// The manufacturer of the original sensors.
const MAKER: &str = "FRABA Posital GmbH";

#[cfg(test)]
mod tests;
