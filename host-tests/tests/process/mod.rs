//! What tests of the virtual sensor share: the program as a process, a raw slcan client, and clients written in Python.
#![allow(
    dead_code,
    reason = "each test program uses a part of it and is compiled with all of it"
)]

pub mod client;
pub mod python;
pub mod sensor;
