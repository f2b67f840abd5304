//! GEMAC's function select codes: a raw CAN protocol in which the first data byte selects the function.
//!
//! A request comes on the Set-Parameter-ID, its reply goes out on the Reply-Parameter-ID and echoes the function select code
//! (FSC). A frame without data on the Sync-ID asks every sensor for its inclination, and in cyclic mode the sensor sends it by
//! itself. Section and table numbers refer to the English manual of 2021 (IS1xx360-C-xL, IS2xx090-C-xL).
//!
//! - [`table`]: how a product describes its codes, replies and status byte; [`projection`]: what the device keeps of that;
//! - [`wire`]: the bytes of requests and replies;
//! - [`Condition`], [`StatusBit`]: the status byte in every reply;
//! - [`Fsc`]: the protocol; it answers requests and sync frames, and sends cyclically;
//! - [`FscNode`]: a node of a product that speaks it.

mod cyclic;
mod node;
pub mod projection;
mod protocol;
mod request;
mod status;
pub mod table;
pub mod wire;

pub use node::FscNode;
pub use protocol::Fsc;
pub use status::{Condition, StatusBit};
pub use table::{Article, ArticleNumber, Product, Version};
