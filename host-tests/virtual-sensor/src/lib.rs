//! A sensor for real clients, as the program `virtual-sensor` runs it.
//!
//! - [`scene`]: what it is mounted on
//! - [`slcan`]: the language of its clients; [`server`]: the clients on a bus in real time
//! - [`program`]: the command line, and the files it names

pub mod program;
pub mod scene;
pub mod server;
pub mod slcan;
