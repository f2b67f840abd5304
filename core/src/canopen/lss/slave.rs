//! The state machine of the layer setting services, without times and without I/O.

use super::UNCONFIGURED;
use crate::can::BitRate;
use crate::time::{Duration, millis};

/// Commands of the master. Most answers have the command of their request.
pub mod command {
    /// Switch state global: waiting or configuration.
    pub const SWITCH_GLOBAL: u8 = 0x04;
    /// Configure node-ID: it is in force after the next reset.
    pub const NODE_ID: u8 = 0x11;
    /// Configure bit timing, by its place in the table of CiA 305.
    pub const BIT_TIMING: u8 = 0x13;
    /// Activate bit timing, with a delay before and after the change.
    pub const ACTIVATE: u8 = 0x15;
    /// Store configuration: node-ID and bit rate.
    pub const STORE: u8 = 0x17;
    /// Switch state selective: the first number of the identity.
    pub const SELECT: u8 = 0x40;
    /// Switch state selective: the last number of the identity.
    pub const SELECT_LAST: u8 = 0x43;
    /// Identify remote slave: the first number or limit of the identity.
    pub const IDENTIFY: u8 = 0x46;
    /// Identify remote slave: the last limit of the identity.
    pub const IDENTIFY_LAST: u8 = 0x4B;
    /// Identify non-configured remote slave: a node without node-ID answers.
    pub const IDENTIFY_UNCONFIGURED: u8 = 0x4C;
    /// Fastscan: finds a node without node-ID bit by bit of its identity.
    pub const FASTSCAN: u8 = 0x51;
    /// Inquire the first number of the identity.
    pub const INQUIRE: u8 = 0x5A;
    /// Inquire the last number of the identity.
    pub const INQUIRE_LAST: u8 = 0x5D;
    /// Inquire the node-ID.
    pub const INQUIRE_NODE_ID: u8 = 0x5E;
}

/// Answers with a command of their own.
pub mod answer {
    /// The identity of "switch state selective" is that of the node.
    pub const SELECTED: u8 = 0x44;
    /// The identity is within the limits of "identify remote slave".
    pub const IDENTIFIED: u8 = 0x4F;
    /// The node has no node-ID.
    pub const UNCONFIGURED: u8 = 0x50;
}

/// Error of configure node-ID and configure bit timing: the value is out of range.
const OUT_OF_RANGE: u8 = 1;
/// Error of store configuration: the memory failed.
const MEDIUM_FAILED: u8 = 2;

/// The bit of a fastscan request with which the master begins a scan. All unconfigured nodes answer.
pub const BEGIN_SCAN: u8 = 0x80;

/// The standard table of bit rates (CiA 305, table selector 0). Index 5 is reserved.
pub const BIT_RATES: [Option<BitRate>; 9] = [
    Some(BitRate::M1),
    Some(BitRate::K800),
    Some(BitRate::K500),
    Some(BitRate::K250),
    Some(BitRate::K125),
    None,
    Some(BitRate::K50),
    Some(BitRate::K20),
    Some(BitRate::K10),
];

/// The device whose settings the services read and change.
pub trait Device {
    /// A number of the identity object (1018h) by its place: 0 vendor-ID, 1 product code, 2 revision number, 3 serial number.
    fn identity(&self, place: u8) -> u32;

    /// The node-ID in force; 255 is none.
    fn node_id(&self) -> u8;

    /// The node-ID after the next reset communication.
    fn pending_node_id(&self) -> u8;

    /// Sets the pending node-ID. Returns false without a change if it is not permitted.
    fn set_node_id(&mut self, node_id: u8) -> bool;

    /// The bit rate at an index of a table. Each device has table 0, the [standard one](BIT_RATES).
    fn bit_rate(&self, table: u8, index: u8) -> Option<BitRate> {
        standard_bit_rate(table, index)
    }

    /// Sets the pending bit rate. Returns false without a change if the device does not have it.
    fn set_bit_rate(&mut self, rate: BitRate) -> bool;
}

/// What a request demands from the node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The node has nothing to do.
    None,
    /// This answer must be sent.
    Reply([u8; 8]),
    /// Store node-ID and bit rate, then send [`Slave::stored`].
    Store,
    /// Activate the pending bit rate with this delay before and after the change.
    Activate(Duration),
}

/// The state of the services.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Slave {
    /// In the configuration state; otherwise in the waiting state.
    configuring: bool,
    /// The number of requests of switch state selective that matched, one after the other.
    selected: u8,
    /// The same for identify remote slave.
    identified: u8,
    /// The place of the number that fastscan compares.
    scanned: u8,
}

impl Slave {
    /// The state after a start: waiting, without a part of an identity.
    pub const WAITING: Self = Self {
        configuring: false,
        selected: 0,
        identified: 0,
        scanned: 0,
    };

    /// Whether it is in the configuration state.
    pub fn is_configuring(&self) -> bool {
        self.configuring
    }

    /// Handles a request. A request that is unknown, or not possible in the present state, has no answer and no effect.
    pub fn serve(&mut self, device: &mut impl Device, bytes: [u8; 8]) -> Outcome {
        let [command, b1, b2, b3, b4, b5, b6, b7] = bytes;
        let number = u32::from_le_bytes([b1, b2, b3, b4]);
        match command {
            command::SWITCH_GLOBAL => self.switch(b1),
            command::IDENTIFY..=command::IDENTIFY_LAST => {
                self.identify(device, command - command::IDENTIFY, number)
            }
            command::IDENTIFY_UNCONFIGURED if is_unconfigured(device) => {
                reply(answer::UNCONFIGURED)
            }
            _ if self.configuring => configure(device, command, [b1, b2], number),
            command::SELECT..=command::SELECT_LAST => {
                self.select(device, command - command::SELECT, number)
            }
            command::FASTSCAN if is_unconfigured(device) => self.scan(device, number, b5, (b6, b7)),
            _ => Outcome::None,
        }
    }

    /// The answer to store configuration.
    pub fn stored(succeeded: bool) -> [u8; 8] {
        let error = if succeeded { 0 } else { MEDIUM_FAILED };
        [command::STORE, error, 0, 0, 0, 0, 0, 0]
    }

    fn switch(&mut self, mode: u8) -> Outcome {
        if mode <= 1 {
            *self = Self::WAITING;
            self.configuring = mode == 1;
        }
        Outcome::None
    }

    fn select(&mut self, device: &impl Device, place: u8, number: u32) -> Outcome {
        let matches = device.identity(place) == number;
        if advance(&mut self.selected, place, matches) <= command::SELECT_LAST - command::SELECT {
            return Outcome::None;
        }
        *self = Self::WAITING;
        self.configuring = true;
        reply(answer::SELECTED)
    }

    fn identify(&mut self, device: &impl Device, step: u8, number: u32) -> Outcome {
        let matches = match step {
            0 | 1 => device.identity(step) == number,
            2 => device.identity(2) >= number,
            3 => device.identity(2) <= number,
            4 => device.identity(3) >= number,
            _ => device.identity(3) <= number,
        };
        let last = command::IDENTIFY_LAST - command::IDENTIFY;
        if advance(&mut self.identified, step, matches) <= last {
            return Outcome::None;
        }
        self.identified = 0;
        reply(answer::IDENTIFIED)
    }

    /// Fastscan. Compares the bits from `bit` on of the number at a place. After a match of all bits, the next place follows. If it
    /// is before the present place, the scan is complete.
    fn scan(
        &mut self,
        device: &impl Device,
        number: u32,
        bit: u8,
        (place, next): (u8, u8),
    ) -> Outcome {
        if bit == BEGIN_SCAN {
            self.scanned = 0;
            return reply(answer::IDENTIFIED);
        }
        let difference = (device.identity(place) ^ number).checked_shr(bit.into());
        if place != self.scanned || place > 3 || next > 3 || difference != Some(0) {
            return Outcome::None;
        }
        if bit == 0 {
            self.scanned = next;
        }
        if bit == 0 && next < place {
            *self = Self::WAITING;
            self.configuring = true;
        }
        reply(answer::IDENTIFIED)
    }
}

/// The bit rate at an index of table 0; None for another table.
pub(super) fn standard_bit_rate(table: u8, index: u8) -> Option<BitRate> {
    let rate = BIT_RATES.get(usize::from(index)).copied().flatten();
    rate.filter(|_| table == 0)
}

/// Whether the node-ID in force and the pending one are not valid.
fn is_unconfigured(device: &impl Device) -> bool {
    device.node_id() == UNCONFIGURED && device.pending_node_id() == UNCONFIGURED
}

/// Counts the requests of a sequence that matched. A repeated request counts once, a missing one begins the sequence again.
fn advance(matched: &mut u8, step: u8, matches: bool) -> u8 {
    *matched = if matches && *matched >= step {
        step.saturating_add(1)
    } else {
        0
    };
    *matched
}

/// The services of the configuration state.
fn configure(
    device: &mut impl Device,
    command: u8,
    [first, second]: [u8; 2],
    number: u32,
) -> Outcome {
    match command {
        command::NODE_ID => acknowledge(command, device.set_node_id(first)),
        command::BIT_TIMING => {
            let rate = device.bit_rate(first, second);
            acknowledge(command, rate.is_some_and(|rate| device.set_bit_rate(rate)))
        }
        command::ACTIVATE => Outcome::Activate(millis(number & 0xFFFF)),
        command::STORE => Outcome::Store,
        command::INQUIRE..=command::INQUIRE_LAST => {
            inquired(command, device.identity(command - command::INQUIRE))
        }
        command::INQUIRE_NODE_ID => inquired(command, device.node_id().into()),
        _ => Outcome::None,
    }
}

fn acknowledge(command: u8, accepted: bool) -> Outcome {
    let error = if accepted { 0 } else { OUT_OF_RANGE };
    inquired(command, error.into())
}

fn reply(command: u8) -> Outcome {
    inquired(command, 0)
}

/// An answer with a number.
fn inquired(command: u8, number: u32) -> Outcome {
    let [b1, b2, b3, b4] = number.to_le_bytes();
    Outcome::Reply([command, b1, b2, b3, b4, 0, 0, 0])
}

#[cfg(test)]
mod tests;
