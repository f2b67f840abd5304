//! CANopen layer setting services, master (CiA 305): fastscan of nodes without node-ID, and the bit rate of a known node.

use super::Link;
use crate::failure::Failure;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::canopen::lss::BIT_RATES;
use plumbline::time::{Duration, millis};

const MASTER: CanId = CanId::standard(0x7E5);
const SLAVE: CanId = CanId::standard(0x7E4);

/// The wait after a question of fastscan: the slaves answer or keep silent.
const SCAN: Duration = millis(20);

/// The wait for the answer to other requests.
const ANSWER: Duration = millis(500);

/// The wait for the answer to store configuration, which comes when the memory is written.
const STORED: Duration = millis(3000);

/// The four numbers of the identity object.
pub type Identity = [u32; 4];

fn ask(link: &mut Link, bytes: [u8; 8], time: Duration) -> Result<Option<[u8; 8]>, Failure> {
    let request = Frame::of(MASTER, bytes, 8);
    link.ask(&request, time, |frame| {
        let bytes: Option<[u8; 8]> = frame.bytes().try_into().ok();
        bytes.filter(|_| frame.can_id() == SLAVE)
    })
}

fn fastscan(link: &mut Link, id: u32, bit: u8, sub: u8, next: u8) -> Result<bool, Failure> {
    let [a, b, c, d] = id.to_le_bytes();
    let answer = ask(link, [0x51, a, b, c, d, bit, sub, next], SCAN)?;
    Ok(answer.is_some_and(|answer| answer[0] == 0x4F))
}

/// Finds a node without node-ID; it is in configuration mode then. None: there is none.
///
/// # Errors
/// The adapter fails.
pub fn find(link: &mut Link) -> Result<Option<Identity>, Failure> {
    const RESET: u8 = 128;
    if !fastscan(link, 0, RESET, 0, 0)? {
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
pub fn store_rate(link: &mut Link, identity: Identity, index: u8) -> Result<(), Failure> {
    const SELECT: u8 = 0x40;
    const SELECTED: u8 = 0x44;
    const BIT_TIMING: u8 = 0x13;
    const STORE: u8 = 0x17;
    release(link)?;
    let mut selected = None;
    for (command, number) in (SELECT..).zip(identity) {
        let [a, b, c, d] = number.to_le_bytes();
        let request = [command, a, b, c, d, 0, 0, 0];
        // Only the last one is answered.
        let time = if command == SELECT + 3 {
            ANSWER
        } else {
            millis(0)
        };
        selected = ask(link, request, time)?;
    }
    if selected.is_none_or(|answer| answer[0] != SELECTED) {
        let message = "no node has answered to the selection by LSS: does another node have the same identity (1018h)?";
        return Err(Failure::silent("no-answer", message));
    }
    must(
        link,
        [BIT_TIMING, 0, index, 0, 0, 0, 0, 0],
        ANSWER,
        "the bit rate",
    )?;
    must(link, [STORE, 0, 0, 0, 0, 0, 0, 0], STORED, "to store it")
}

/// A request with an error code in its answer.
fn must(link: &mut Link, bytes: [u8; 8], time: Duration, what: &str) -> Result<(), Failure> {
    match ask(link, bytes, time)? {
        Some([command, 0, ..]) if command == bytes[0] => Ok(()),
        Some([_, error, ..]) => Err(Failure::refused(
            "refused",
            format!(
                "the sensor refused {what} (LSS error {error}): its bit rate has not changed. Choose another one, or repeat"
            ),
        )),
        None => Err(Failure::silent(
            "no-answer",
            "the sensor does not answer LSS requests: `plumbline scan` finds it",
        )),
    }
}

/// Switches all nodes to waiting.
///
/// # Errors
/// The adapter fails.
pub fn release(link: &mut Link) -> Result<(), Failure> {
    link.send(&Frame::of(MASTER, [4, 0, 0, 0, 0, 0, 0, 0], 8))
}
