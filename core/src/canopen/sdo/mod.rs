//! The SDO server (CiA 301, 7.2.4): expedited, segmented and block transfers, one at a time.
//!
//! - [`message`]: the bytes of requests and replies;
//! - [`Server`]: the state machine, for each type that implements [`Objects`];
//! - [`mod@block`]: block transfer, for products that select it.

pub mod block;
pub mod message;
mod server;

pub use block::Block;
pub use server::{Buffer, Objects, Server, TIME_OUT, Written};
