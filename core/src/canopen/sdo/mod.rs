//! The SDO server (CiA 301, 7.2.4): expedited and segmented transfers, one at a time.
//!
//! - [`message`]: the bytes of requests and replies;
//! - [`Server`]: the state machine, for each type that implements [`Objects`].

pub mod message;
mod server;

pub use server::{Buffer, Objects, Server, TIME_OUT, Written};
