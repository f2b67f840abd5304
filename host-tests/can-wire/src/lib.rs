//! The CAN protocol bit by bit, without a bus and without a device.
//!
//! - [`protocol`]: what every CAN controller does, below its registers
//! - [`frame_length`]: how many bits a frame takes, and which of two wins arbitration

pub mod frame_length;
pub mod protocol;
