//! The NMT slave: states and commands (CiA 301, 7.3.2).

use crate::can::Frame;

/// The NMT state of a node. The discriminant is the value in heartbeat and guarding messages.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Before the boot-up message: at the start, and between the reply to a request for a reset and the reset.
    Initialising = 0,
    /// Only NMT and error control are active.
    Stopped = 4,
    /// All services are active.
    Operational = 5,
    /// All services except PDOs are active.
    PreOperational = 127,
}

impl State {
    /// Whether SDO, SYNC and EMCY are active.
    pub const fn communicates(self) -> bool {
        !matches!(self, Self::Stopped | Self::Initialising)
    }
}

/// An NMT command.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// Enter this state.
    Enter(State),
    /// Reset node: restart with the stored parameters.
    ResetNode,
    /// Reset communication: restart the communication with its stored parameters.
    ResetCommunication,
}

impl Command {
    /// The command in a frame, if it is valid and addressed to `node` or to all nodes.
    pub fn parse(frame: &Frame, node: u8) -> Option<Self> {
        let &[command, addressee] = frame.bytes() else {
            return None;
        };
        if addressee != 0 && addressee != node {
            return None;
        }
        match command {
            1 => Some(Self::Enter(State::Operational)),
            2 => Some(Self::Enter(State::Stopped)),
            128 => Some(Self::Enter(State::PreOperational)),
            129 => Some(Self::ResetNode),
            130 => Some(Self::ResetCommunication),
            _ => None,
        }
    }
}
