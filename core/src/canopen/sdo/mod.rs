//! The SDO server (CiA 301, 7.2.4): expedited and segmented transfers, one at a time.
//!
//! - [`message`]: the bytes of requests and replies;
//! - [`Server`]: the state machine, over anything that has [`Objects`].

pub mod message;
mod server;

pub use server::{Buffer, Objects, Server, TIME_OUT, Written};
