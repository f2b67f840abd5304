//! The CAN protocol bit by bit, without a bus and without a device.
//!
//! - [`protocol`]: the function of every CAN controller, without its registers
//! - [`frame_length`]: the number of bits of a frame, and which of two frames wins arbitration
//! - [`text`]: a frame as text; [`slcan`]: as a line of slcan

pub mod frame_length;
pub mod protocol;
pub mod slcan;
pub mod text;
