//! A sensor for external clients: the library of the program `virtual-sensor`, and of the same program for a product of another
//! crate ([`run_with`]).
//!
//! - [`slcan`]: the protocol of its clients; [`server`]: the clients on a bus in real time
//! - [`program`]: the command line and its files

pub mod program;
pub mod server;
pub mod slcan;

pub use program::{Options, run_with};
