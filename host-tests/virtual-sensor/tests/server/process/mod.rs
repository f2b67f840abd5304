//! Shared by tests of the virtual sensor: the program as a process, a raw slcan client, and one that controls the sensors.

pub mod client;
pub mod control;
pub mod sensor;
