//! The identifiers and bytes of CANopen's services (CiA 301, chapters 7.2 and 7.3).
//!
//! ```text
//!  NMT        000h        command, node
//!  SYNC       080h        (counter)
//!  EMCY       080h + id   error code (2), error register, manufacturer's field (5)
//!  TPDO       180h + id   mapped objects, one behind the other
//!  SDO        580h + id   from the device;  600h + id to the device:
//!                         command, index (2), sub-index, data (4)       initiate and abort
//!                         command, data (7)                             segment
//!  guarding   700h + id   state (remote frame: request); boot-up is state 0
//! ```
//!
//! All numbers are little-endian.

use super::abort::Abort;
use embedded_can::Id;

/// The identifier of NMT commands.
pub const NMT: u16 = 0x000;
/// The identifier of emergency messages, for node 0.
pub const EMCY: u16 = 0x080;
/// The identifier of SDO replies, for node 0.
pub const SDO_REPLY: u16 = 0x580;
/// The identifier of SDO requests, for node 0.
pub const SDO_REQUEST: u16 = 0x600;
/// The identifier of boot-up, heartbeat and guarding, for node 0.
pub const ERROR_CONTROL: u16 = 0x700;

/// Bit 31 of a PDO's or EMCY's COB-ID: it is not used.
pub const DISABLED: u32 = 1 << 31;
/// Bit 30 of a TPDO's COB-ID: it is not sent on a remote frame; of the SYNC's: the device is its producer.
pub const BIT_30: u32 = 1 << 30;

/// The 11-bit identifier of a frame; None for one of 29 bits.
pub fn standard_id(id: Id) -> Option<u16> {
    match id {
        Id::Standard(id) => Some(id.as_raw()),
        Id::Extended(_) => None,
    }
}

/// True when `id` may be given to a SYNC or PDO: an 11-bit identifier that no fixed service needs (CiA 301, table 81).
pub const fn is_free(id: u32) -> bool {
    !matches!(
        id,
        0..=0x07F
            | 0x101..=0x180
            | 0x581..=0x5FF
            | 0x601..=0x67F
            | 0x6E0..=0x6FF
            | 0x701..
    )
}

/// Where an object stands in the dictionary.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Address {
    /// The index.
    pub index: u16,
    /// The sub-index.
    pub sub: u8,
}

/// What a client asks of the SDO server.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// Write to an object.
    Download(Address, Announced),
    /// A part of the data that are written.
    DownloadSegment {
        /// The toggle bit.
        toggle: bool,
        /// How many of the seven bytes count.
        length: u8,
        /// No more segments follow.
        last: bool,
    },
    /// Read an object.
    Upload(Address),
    /// Send the next part of the data that are read.
    UploadSegment {
        /// The toggle bit.
        toggle: bool,
    },
    /// The client gives the transfer up.
    Abort,
    /// Block transfer, or an unknown command.
    Unsupported(Address),
}

/// What the first frame of a download says of the data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Announced {
    /// The data are in this frame; None: as many bytes as the object has.
    Expedited([u8; 4], Option<u8>),
    /// The data follow in segments; so many bytes, if said.
    Segmented(Option<u32>),
}

impl Request {
    /// The request in the eight bytes of a frame.
    pub fn parse(bytes: [u8; 8]) -> Self {
        let [command, low, high, sub, d0, d1, d2, d3] = bytes;
        let index = u16::from_le_bytes([low, high]);
        let address = Address { index, sub };
        let toggle = command & 0x10 != 0;
        let data = [d0, d1, d2, d3];
        let sized = command & 0x01 != 0;
        match command >> 5 {
            0 => Self::DownloadSegment {
                toggle,
                length: 7 - (command >> 1 & 7),
                last: sized,
            },
            1 if command & 0x02 != 0 => {
                let length = 4 - (command >> 2 & 3);
                Self::Download(address, Announced::Expedited(data, sized.then_some(length)))
            }
            1 => {
                let size = sized.then_some(u32::from_le_bytes(data));
                Self::Download(address, Announced::Segmented(size))
            }
            2 => Self::Upload(address),
            3 => Self::UploadSegment { toggle },
            4 => Self::Abort,
            _ => Self::Unsupported(address),
        }
    }
}

/// The reply to the reading of a number of `size` bytes, 1 to 4.
pub fn number_reply(address: Address, number: u32, size: u8) -> [u8; 8] {
    let unused = 4_u8.saturating_sub(size);
    // A signed number comes with more bits than it has.
    let number = number & u32::MAX.checked_shr(8 * u32::from(unused)).unwrap_or(0);
    addressed(0x43 | unused << 2, address, number.to_le_bytes())
}

/// The reply to the initiation of an upload of `data`: with the data in it, or with their number.
pub fn upload_reply(address: Address, data: &[u8]) -> [u8; 8] {
    let length = data.len() as u8;
    if let 1..=4 = length {
        let number = data.iter().rev();
        let number = number.fold(0, |number, &byte| number << 8 | u32::from(byte));
        return number_reply(address, number, length);
    }
    addressed(0x41, address, u32::from(length).to_le_bytes())
}

/// A segment of an upload: up to seven bytes of data.
pub fn upload_segment(toggle: bool, data: &[u8], last: bool) -> [u8; 8] {
    let mut bytes = [0; 8];
    let unused = 7_u8.saturating_sub(data.len() as u8);
    if let Some((command, content)) = bytes.split_first_mut() {
        *command = u8::from(toggle) << 4 | unused << 1 | u8::from(last);
        for (to, from) in content.iter_mut().zip(data) {
            *to = *from;
        }
    }
    bytes
}

/// The reply to the initiation of a download.
pub fn download_reply(address: Address) -> [u8; 8] {
    addressed(0x60, address, [0; 4])
}

/// The reply to a segment of a download.
pub fn download_segment_reply(toggle: bool) -> [u8; 8] {
    [0x20 | u8::from(toggle) << 4, 0, 0, 0, 0, 0, 0, 0]
}

/// The end of a transfer that went wrong.
pub fn abort(address: Address, abort: Abort) -> [u8; 8] {
    addressed(0x80, address, (abort as u32).to_le_bytes())
}

fn addressed(command: u8, address: Address, [d0, d1, d2, d3]: [u8; 4]) -> [u8; 8] {
    let [low, high] = address.index.to_le_bytes();
    [command, low, high, address.sub, d0, d1, d2, d3]
}
