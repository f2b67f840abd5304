//! GEMAC function select codes: a raw CAN protocol in which the first data byte selects the function.
//!
//! A request has the Set-Parameter-ID. Its reply has the Reply-Parameter-ID and echoes the function select code (FSC). After a
//! frame without data on the Sync-ID, each sensor replies with its inclination. In cyclic mode, the sensor sends its inclination
//! periodically. Section and table numbers refer to the English manual of 2021 (IS1xx360-C-xL, IS2xx090-C-xL).
//!
//! - [`table`]: how a product describes its codes, replies and status byte; [`projection`]: its compact form in the device;
//! - [`wire`]: the bytes of requests and replies;
//! - [`Condition`], [`StatusBit`]: the status byte of each reply;
//! - [`Fsc`]: the protocol: requests, sync frames and cyclic mode;
//! - [`FscNode`]: a node with this protocol.

mod consistency;
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
pub use request::{FLASH, UPDATE};
pub use status::{Condition, StatusBit};
pub use table::{Article, ArticleNumber, Own, Product, Version};
