//! CANopen network management: commands to a node.

use super::Link;
use crate::failure::Failure;
use plumbline::can::{Frame, standard};

/// A command of the NMT master.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Command {
    /// Start remote node: operational.
    Start = 1,
    /// Stop remote node.
    Stop = 2,
    /// Enter pre-operational.
    PreOperational = 128,
    /// Reset node.
    ResetNode = 129,
    /// Reset communication.
    ResetCommunication = 130,
}

/// Sends a command to one node. There is no answer.
///
/// # Errors
/// Those of the adapter.
pub fn send(link: &mut Link, command: Command, node: u8) -> Result<(), Failure> {
    let frame = Frame::of(standard(0x000), [command as u8, node, 0, 0, 0, 0, 0, 0], 2);
    link.send(&frame)
}
