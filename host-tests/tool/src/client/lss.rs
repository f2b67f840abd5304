//! CANopen layer setting services, master (CiA 305): fastscan of nodes without node-ID, node-ID and bit rate.

use super::Link;
use crate::failure::Failure;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Duration, millis};

const MASTER: CanId = CanId::standard(0x7E5);
const SLAVE: CanId = CanId::standard(0x7E4);

/// The wait for an answer.
const ANSWER: Duration = millis(100);

/// The wait after a question of fastscan: the slaves answer or keep silent.
const SCAN: Duration = millis(20);

/// The wait for the answer to "store configuration".
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
/// Those of the adapter.
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

/// Switches all nodes to waiting.
///
/// # Errors
/// Those of the adapter.
pub fn release(link: &mut Link) -> Result<(), Failure> {
    link.send(&Frame::of(MASTER, [4, 0, 0, 0, 0, 0, 0, 0], 8))
}

/// Switches the node with this identity to configuration mode.
///
/// # Errors
/// Nobody answers, or those of the adapter.
pub fn select(link: &mut Link, identity: Identity) -> Result<(), Failure> {
    release(link)?;
    let mut answer = None;
    for (place, number) in identity.into_iter().enumerate() {
        let [a, b, c, d] = number.to_le_bytes();
        answer = ask(
            link,
            [0x40 + place as u8, a, b, c, d, 0, 0, 0],
            if place == 3 { ANSWER } else { millis(2) },
        )?;
    }
    match answer {
        Some([0x44, ..]) => Ok(()),
        _ => Err(Failure::silent(
            "no-answer",
            "no node answers its LSS address: switch the sensor off and on, then repeat",
        )),
    }
}

/// A request of the configuration mode, which the node answers with an error code.
fn configure(link: &mut Link, bytes: [u8; 8], time: Duration, what: &str) -> Result<(), Failure> {
    match ask(link, bytes, time)? {
        Some([command, 0, ..]) if command == bytes[0] => Ok(()),
        Some([_, error, ..]) => Err(Failure::refused(
            "refused",
            format!("the sensor refused {what} (LSS error {error})"),
        )),
        None => Err(Failure::silent(
            "no-answer",
            format!("nobody answers to {what}"),
        )),
    }
}

/// Sets the node-ID, 1 to 127, of the node in configuration mode.
///
/// # Errors
/// The node refuses it, nobody answers, or those of the adapter.
pub fn set_node_id(link: &mut Link, node: u8) -> Result<(), Failure> {
    configure(link, [0x11, node, 0, 0, 0, 0, 0, 0], ANSWER, "the node-ID")
}

/// Sets the bit rate of the node in configuration mode; it acts after a restart.
///
/// # Errors
/// The table of CiA 305 has no such rate, the node refuses it, nobody answers, or those of the adapter.
pub fn set_rate(link: &mut Link, rate: BitRate) -> Result<(), Failure> {
    let index = match rate {
        BitRate::M1 => 0,
        BitRate::K800 => 1,
        BitRate::K500 => 2,
        BitRate::K250 => 3,
        BitRate::K125 => 4,
        BitRate::K50 => 6,
        BitRate::K20 => 7,
        BitRate::K10 => 8,
        BitRate::K100 | BitRate::K62_5 => {
            let message = format!("LSS has no {}", rate.name());
            return Err(Failure::usage("out-of-range", message));
        }
    };
    configure(
        link,
        [0x13, 0, index, 0, 0, 0, 0, 0],
        ANSWER,
        "the bit rate",
    )
}

/// Stores the configuration.
///
/// # Errors
/// The node refuses it, nobody answers, or those of the adapter.
pub fn store(link: &mut Link) -> Result<(), Failure> {
    configure(link, [0x17, 0, 0, 0, 0, 0, 0, 0], STORED, "the storage")
}
