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
    /// All services are active, also PDOs.
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

// The command specifiers.
const START: u8 = 1;
const STOP: u8 = 2;
const ENTER_PRE_OPERATIONAL: u8 = 128;
const RESET_NODE: u8 = 129;
const RESET_COMMUNICATION: u8 = 130;

/// A command of the NMT master.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// Enter this state: stopped, operational or pre-operational.
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
            START => Some(Self::Enter(State::Operational)),
            STOP => Some(Self::Enter(State::Stopped)),
            ENTER_PRE_OPERATIONAL => Some(Self::Enter(State::PreOperational)),
            RESET_NODE => Some(Self::ResetNode),
            RESET_COMMUNICATION => Some(Self::ResetCommunication),
            _ => None,
        }
    }

    /// The command specifier, which is the first byte of the frame.
    pub const fn specifier(self) -> u8 {
        match self {
            Self::Enter(State::Operational) => START,
            Self::Enter(State::Stopped) => STOP,
            Self::Enter(State::PreOperational) => ENTER_PRE_OPERATIONAL,
            // A node enters initialising by a reset.
            Self::Enter(State::Initialising) | Self::ResetNode => RESET_NODE,
            Self::ResetCommunication => RESET_COMMUNICATION,
        }
    }
}
