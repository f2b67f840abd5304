//! The bytes of gs_usb, all little-endian.
//!
//! ```text
//!  frame     0..4 echo number, FFFFFFFFh: received   4..8 identifier   8 length   9 channel   10 flags   11 reserved   12..20 data
//!  identifier  bit 31 29-bit format   bit 30 remote frame   bit 29 error frame, then bits 0..28 are the classes of the error
//!  flags       bit 0 frames were lost before this one   bit 1 CAN FD
//!  limits    words: features, clock in Hz, segment 1 min and max, segment 2 min and max, jump width max, prescaler min, max, step
//!  features  bit 0 listen-only   bit 9 frames to the adapter have one more byte   bit 12 all errors of the bus   bit 13 GET_STATE
//! ```

use plumbline::can::{CanId, Frame};

/// Feature, and flag of MODE: it only listens.
pub const LISTEN_ONLY: u32 = 1 << 0;

/// Feature: frames to the adapter have one more byte, because its USB controller loses others.
pub const LONGER: u32 = 1 << 9;

/// Feature, and flag of MODE: it reports each error of the bus.
pub const BUS_ERRORS: u32 = 1 << 12;

/// Feature: it tells its error counters.
pub const GET_STATE: u32 = 1 << 13;

/// The echo number of a received frame.
const RECEIVED: u32 = 0xFFFF_FFFF;

/// Bits of the identifier in a transfer.
const REMOTE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;

/// Flags of a frame in a transfer.
const OVERRUN: u8 = 1 << 0;
const FLEXIBLE: u8 = 1 << 1;

/// Classes of errors: state of the controller, which is in data byte 1; bus-off; restarted after bus-off.
const CONTROLLER: u32 = 1 << 2;
const BUS_OFF: u32 = 1 << 6;
const RESTARTED: u32 = 1 << 8;

/// States of the controller that are no error: active again.
const ACTIVE: u8 = 1 << 6;

/// What an adapter is able to do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Constants {
    /// The features of the adapter, as bits.
    pub features: u32,
    /// The clock of the bit timing in Hz.
    pub clock: u32,
    /// The least and the greatest length of the propagation segment and phase segment 1 together, in quanta.
    pub segment_1: (u32, u32),
    /// The least and the greatest length of phase segment 2, in quanta.
    pub segment_2: (u32, u32),
    /// The greatest jump width, in quanta.
    pub jump: u32,
    /// The least and the greatest prescaler, and the step between two.
    pub prescaler: (u32, u32, u32),
}

impl Constants {
    /// The length of the answer to BT_CONST.
    pub const LENGTH: u16 = 40;

    /// From the answer to BT_CONST; None if it is too short or has no clock.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut words = bytes.chunks_exact(4).map_while(|word| word_at(word, 0));
        let mut next = || words.next();
        let constants = Self {
            features: next()?,
            clock: next()?,
            segment_1: (next()?, next()?),
            segment_2: (next()?, next()?),
            jump: next()?,
            prescaler: (next()?, next()?, next()?),
        };
        (constants.clock > 0).then_some(constants)
    }

    /// The transfer that sends a frame.
    pub fn write(&self, frame: &Frame, number: usize) -> Vec<u8> {
        let remote = if frame.is_remote() { REMOTE } else { 0 };
        let mut bytes = Vec::with_capacity(21);
        bytes.extend((number as u32).to_le_bytes());
        bytes.extend((frame.can_id().bits() | remote).to_le_bytes());
        bytes.extend([frame.dlc() as u8, 0, 0, 0]);
        bytes.extend(frame.bytes());
        let is_longer = self.features & LONGER != 0;
        bytes.resize(if is_longer { 21 } else { 20 }, 0);
        bytes
    }
}

/// What an adapter has sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Received {
    /// A frame on the bus. Overrun: frames before it were lost.
    Frame {
        /// Identifier and data of the frame.
        frame: Frame,
        /// Frames before it were lost.
        is_overrun: bool,
    },
    /// The frame with this echo number was sent.
    Echo(u32),
    /// An error of the bus.
    Error {
        /// The adapter has switched itself off the bus.
        is_off: bool,
    },
}

impl Received {
    /// From a transfer, which can be longer than its frame; None if it is nothing valid for this channel.
    pub fn read(bytes: &[u8], channel: u16) -> Option<Self> {
        let (number, id) = (word_at(bytes, 0)?, word_at(bytes, 4)?);
        let (head, data) = (bytes.get(8..12)?, bytes.get(12..20)?);
        let (length, flags) = (usize::from(head[0]), head[2]);
        if u16::from(head[1]) != channel {
            return None;
        }
        if number != RECEIVED {
            return Some(Self::Echo(number));
        }
        if id & ERROR != 0 {
            let class = id & (ERROR - 1);
            let is_good = class & !(RESTARTED | CONTROLLER) == 0 && data[1] & !ACTIVE == 0;
            let is_off = class & BUS_OFF != 0;
            return (!is_good).then_some(Self::Error { is_off });
        }
        let identifier = CanId::from_bits(id);
        if flags & FLEXIBLE != 0 || identifier.bits() != id & !REMOTE {
            return None;
        }
        let frame = match id & REMOTE {
            0 => Frame::data(identifier.into(), data.get(..length)?),
            _ => Frame::remote(identifier.into(), length),
        };
        let is_overrun = flags & OVERRUN != 0;
        frame.map(|frame| Self::Frame { frame, is_overrun })
    }
}

fn word_at(bytes: &[u8], place: usize) -> Option<u32> {
    let word = bytes.get(place..place + 4)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}
