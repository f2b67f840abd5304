//! The parts of `plumbline calibrate`: the raw acceleration in the log of a board, when the sensor is at rest, and who leads the user.

pub mod demo;
pub mod host;
pub mod log;
pub mod rest;
