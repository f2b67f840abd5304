//! CANopen layer setting services, master (CiA 305): fastscan of nodes without node-ID, and the bit rate of a known node.

use crate::error::{Error, Next, Refusal, Silence, What};
use crate::link::Link;
use crate::master::canopen::{PROTOCOL, nmt};
use crate::scan::listen::Frames;
use crate::scan::row::{By, Heard, UNCONFIGURED};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::canopen::cob_id::{LSS_REPLY, LSS_REQUEST};
use plumbline::canopen::lss::{self, BEGIN_SCAN, BIT_RATES, answer, command};
use plumbline::time::{Duration, millis};

const MASTER: CanId = CanId::standard(LSS_REQUEST);
const SLAVE: CanId = CanId::standard(LSS_REPLY);

/// The wait after a question of fastscan: the slaves answer or keep silent.
const SCAN: Duration = millis(20);

/// The wait for the answer to other requests.
const ANSWER: Duration = millis(500);

/// The wait for the answer to store configuration, which comes when the memory is written.
const STORED: Duration = millis(3000);

/// The time in which a node has reset its communication.
const RESET: Duration = millis(500);

/// The four numbers of the identity object.
pub type Identity = [u32; 4];

fn ask(link: &mut Link, bytes: [u8; 8], time: Duration) -> Result<Option<[u8; 8]>, Error> {
    let request = Frame::of(MASTER, bytes, 8);
    link.ask(&request, time, |frame| {
        let bytes: Option<[u8; 8]> = frame.bytes().try_into().ok();
        bytes.filter(|_| frame.can_id() == SLAVE)
    })
}

/// A node without node-ID, unless another master of layer setting services is on the bus.
pub(super) fn unaddressed(link: &mut Link, frames: &Frames) -> Result<Option<Heard>, Error> {
    if frames.iter().any(|(_, frame)| is_used(frame)) {
        return Ok(None);
    }
    let found = find(link);
    // A node that fastscan has begun to select must not stay in configuration mode.
    release(link)?;
    Ok(found?.map(|[vendor, code, _, serial]| Heard {
        protocol: PROTOCOL.name,
        address: Some(UNCONFIGURED.to_owned()),
        serial: Some(serial),
        text: Some(format!("vendor {vendor:X}h, product code {code:X}h")),
        by: By::Message,
    }))
}

/// Whether a message is one of layer setting services.
fn is_used(frame: &Frame) -> bool {
    [MASTER, SLAVE].contains(&frame.can_id())
}

fn fastscan(link: &mut Link, id: u32, bit: u8, sub: u8, next: u8) -> Result<bool, Error> {
    let [a, b, c, d] = id.to_le_bytes();
    let request = [command::FASTSCAN, a, b, c, d, bit, sub, next];
    Ok(ask(link, request, SCAN)?.is_some_and(|bytes| bytes[0] == answer::IDENTIFIED))
}

/// Finds a node without node-ID; it is in configuration mode then. None: there is none.
///
/// # Errors
/// The adapter fails.
pub fn find(link: &mut Link) -> Result<Option<Identity>, Error> {
    if !fastscan(link, 0, BEGIN_SCAN, 0, 0)? {
        return Ok(None);
    }
    let mut identity = [0; 4];
    for sub in 0..4 {
        let mut number = 0;
        for bit in (0..32).rev() {
            if !fastscan(link, number, bit, sub, sub)? {
                number |= 1 << bit;
            }
        }
        let next = (sub + 1) % 4;
        if !fastscan(link, number, 0, sub, next)? {
            return Ok(None);
        }
        identity[usize::from(sub)] = number;
    }
    Ok(Some(identity))
}

/// Takes the node-ID from all nodes with layer setting services until their next restart; then [`find`] finds them one by one.
///
/// # Errors
/// The adapter fails.
pub fn unaddress(link: &mut Link) -> Result<(), Error> {
    link.send(&Frame::of(
        MASTER,
        [command::SWITCH_GLOBAL, 1, 0, 0, 0, 0, 0, 0],
        8,
    ))?;
    // Each of them answers.
    let request = [command::NODE_ID, lss::UNCONFIGURED, 0, 0, 0, 0, 0, 0];
    ask(link, request, ANSWER)?;
    release(link)?;
    const ALL: u8 = 0;
    nmt::send(link, nmt::Command::ResetCommunication, ALL)?;
    link.wait_for(RESET, |_| None::<()>)?;
    Ok(())
}

/// Gives the node that [`find`] has found a node-ID and stores it. The node starts with it.
///
/// # Errors
/// The node refuses, nobody answers, or the adapter fails.
pub fn address(link: &mut Link, node: u8) -> Result<(), Error> {
    let request = [command::NODE_ID, node, 0, 0, 0, 0, 0, 0];
    let store = [command::STORE, 0, 0, 0, 0, 0, 0, 0];
    let given = must(link, request, ANSWER, What::NodeId);
    let given = given.and_then(|()| must(link, store, STORED, What::Store));
    // A node in configuration mode would take the node-ID of the next one.
    release(link)?;
    given
}

/// The index of a bit rate in the standard table; None: the table does not have it.
pub fn index(rate: BitRate) -> Option<u8> {
    let place = BIT_RATES.iter().position(|own| *own == Some(rate));
    place.map(|place| place as u8)
}

/// Switches one node to configuration mode, and lets it store a bit rate, which acts after its restart. The node is in configuration
/// mode afterwards, also after a failure: [`release`] ends it.
///
/// # Errors
/// The node refuses, nobody answers, or the adapter fails.
pub fn store_rate(link: &mut Link, identity: Identity, index: u8) -> Result<(), Error> {
    release(link)?;
    let mut selected = None;
    for (part, number) in (command::SELECT..).zip(identity) {
        let [a, b, c, d] = number.to_le_bytes();
        let request = [part, a, b, c, d, 0, 0, 0];
        // Only the last one is answered.
        let time = if part == command::SELECT_LAST {
            ANSWER
        } else {
            millis(0)
        };
        selected = ask(link, request, time)?;
    }
    if selected.is_none_or(|bytes| bytes[0] != answer::SELECTED) {
        return Err(Silence::Selection.into());
    }
    must(
        link,
        [command::BIT_TIMING, 0, index, 0, 0, 0, 0, 0],
        ANSWER,
        What::BitRate,
    )?;
    must(
        link,
        [command::STORE, 0, 0, 0, 0, 0, 0, 0],
        STORED,
        What::Store,
    )
}

/// A request with an error code in its answer.
fn must(link: &mut Link, bytes: [u8; 8], time: Duration, what: What) -> Result<(), Error> {
    match ask(link, bytes, time)? {
        Some([own, 0, ..]) if own == bytes[0] => Ok(()),
        Some([_, error, ..]) => Err(refused(bytes[0], error, what)),
        None => Err(Silence::Lss.into()),
    }
}

/// The sensor has answered a request with an error code. Error 1 says that it does not have the bit rate, or cannot store by LSS.
fn refused(request: u8, error: u8, what: What) -> Error {
    let next = match (request, error) {
        (command::BIT_TIMING, 1) => Next::OtherRate,
        (command::NODE_ID, 1) => Next::List,
        (command::STORE, 1) => Next::SetRate,
        _ => Next::Repeat,
    };
    Refusal::Lss(what, error, next).into()
}

/// Switches all nodes to waiting.
///
/// # Errors
/// The adapter fails.
pub fn release(link: &mut Link) -> Result<(), Error> {
    link.send(&Frame::of(
        MASTER,
        [command::SWITCH_GLOBAL, 0, 0, 0, 0, 0, 0, 0],
        8,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_master_of_layer_setting_services_is_recognised() {
        let frame = |id| Frame::of(CanId::standard(id), [4, 0, 0, 0, 0, 0, 0, 0], 8);
        assert_eq!(
            [0x7E4, 0x7E5, 0x70A].map(|id| is_used(&frame(id))),
            [true, true, false]
        );
    }

    #[test]
    fn refusal_of_a_bit_rate_does_not_advise_to_repeat() {
        let message = |request, error| refused(request, error, What::BitRate).to_string();
        let unknown = message(command::BIT_TIMING, 1);
        assert!(unknown.contains("choose another one"), "{unknown}");
        assert!(!unknown.to_lowercase().contains("repeat"), "{unknown}");
        assert!(message(command::STORE, 1).contains("`plumbline set`"));
        for (request, error) in [(command::BIT_TIMING, 255), (command::STORE, 2)] {
            assert!(message(request, error).contains("Repeat"), "{error}");
        }
    }
}
