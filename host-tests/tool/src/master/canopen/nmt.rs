//! CANopen network management: commands to a node, and its state.
//!
//! ```text
//!  000h         command   node-ID      00h: all nodes
//!  700h + node  state                  heartbeat: 00h boot-up, 04h stopped, 05h operational, 7Fh pre-operational
//! ```

use super::sdo::{Answer, Server};
use crate::error::{Error, SensorError};
use crate::link::Link;
use plumbline::can::{CanId, Frame};
use plumbline::canopen::cob_id::{ERROR_CONTROL, NMT};
use plumbline::canopen::nmt;
pub use plumbline::canopen::nmt::Command;
use plumbline::param::number;
use plumbline::time::{Duration, millis};

/// The NMT command "start remote node".
pub const START: Command = Command::Enter(nmt::State::Operational);

/// The NMT command "enter pre-operational".
pub const ENTER_PRE_OPERATIONAL: Command = Command::Enter(nmt::State::PreOperational);

/// The state of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// The node sends PDOs.
    Operational,
    /// Any other state, or not known.
    Other,
}

/// The object of the heartbeat time, in ms; 0: the node sends no heartbeat.
const HEARTBEAT: u16 = 0x1017;

/// The heartbeat time of a node that is asked for its state and sends no heartbeat, in ms.
const OWN: u16 = 50;

/// The permitted delay of a heartbeat.
const LATE: Duration = millis(100);

/// Sends a command to one node. There is no answer.
///
/// # Errors
/// The adapter fails.
pub fn send(link: &mut Link, command: Command, node: u8) -> Result<(), Error> {
    let frame = Frame::of(
        CanId::standard(NMT),
        [command.specifier(), node, 0, 0, 0, 0, 0, 0],
        2,
    );
    link.send(&frame)
}

/// The state of a node, from its heartbeat; None: the state is unknown. A node that sends no heartbeat gets one for this question, and
/// loses it again. The tool does not use node guarding, because node guarding starts the supervision of the master in the node.
///
/// # Errors
/// The adapter fails.
pub fn state(link: &mut Link, node: u8) -> Result<Option<State>, Error> {
    let server = Server::of(node);
    let Answer::Done(present) = server.read(link, HEARTBEAT, 0)? else {
        return Ok(None);
    };
    let period = number(&present);
    if period != 0 {
        return heartbeat(link, node, millis(period) + LATE);
    }
    let state = match server.write(link, HEARTBEAT, 0, &OWN.to_le_bytes()) {
        Ok(Answer::Done(())) => heartbeat(link, node, millis(OWN.into()) + LATE),
        Ok(Answer::Aborted(_)) => return Ok(None),
        // The node can have it though its answer is lost.
        Ok(Answer::Silent) => Ok(None),
        Err(failure) => Err(failure),
    };
    // It must not stay: a command that follows can store it, and a node with a heartbeat does not answer node guarding.
    match server.put_back(link, (HEARTBEAT, 0), &present)? {
        Answer::Done(()) => state,
        Answer::Silent | Answer::Aborted(_) => {
            Err(SensorError::Heartbeat(node, OWN, period).into())
        }
    }
}

fn heartbeat(link: &mut Link, node: u8, time: Duration) -> Result<Option<State>, Error> {
    const OPERATIONAL: u8 = nmt::State::Operational as u8;
    let id = CanId::standard(ERROR_CONTROL + u16::from(node));
    link.wait_for(time, |frame| match frame.bytes() {
        [OPERATIONAL] if frame.can_id() == id => Some(State::Operational),
        [_] if frame.can_id() == id && !frame.is_remote() => Some(State::Other),
        _ => None,
    })
}
