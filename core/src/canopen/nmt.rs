//! The NMT slave: states and commands (CiA 301, 7.3.2).

use crate::can::Frame;

/// The state of a node, as boot-up, heartbeat and guarding carry it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Before the boot-up message.
    Initialising = 0,
    /// Only NMT and error control.
    Stopped = 4,
    /// Everything.
    Operational = 5,
    /// Everything but PDOs.
    PreOperational = 127,
}

impl State {
    /// Whether SDO, SYNC and EMCY are in use.
    pub const fn communicates(self) -> bool {
        !matches!(self, Self::Stopped | Self::Initialising)
    }
}

/// What the NMT master can ask for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// Enter this state.
    Enter(State),
    /// Start anew with the stored parameters.
    ResetNode,
    /// Start the communication anew with its stored parameters.
    ResetCommunication,
}

impl Command {
    /// The command in a frame, if it is one and meant for `node` or for all.
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
