//! Shared by tests of the virtual sensor: the program as a process, and a raw slcan client.

pub mod client;
pub mod sensor;
