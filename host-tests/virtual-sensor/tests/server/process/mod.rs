//! Shared by tests of the virtual sensor: the program as a process, and a raw slcan client.
#![allow(
    dead_code,
    reason = "each test program uses a part of it and is compiled with all of it"
)]

pub mod client;
pub mod sensor;
