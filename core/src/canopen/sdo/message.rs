//! The bytes of SDO requests and replies (CiA 301, 7.2.4.3).
//!
//! ```text
//!  byte 0        1        3           4
//!       +--------+--------+-----------+-----------------+
//!       | command| index  | sub-index | data (4)        |   initiate and abort
//!       +--------+--------+-----------+-----------------+
//!       | command| data (7)                             |   segment
//!       +--------+--------------------------------------+
//! ```
//!
//! All numbers are little-endian.

use crate::canopen::Abort;

/// The address of an object in the object dictionary.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Address {
    /// The index in the object dictionary.
    pub index: u16,
    /// The sub-index; 0 for an object without sub-indices.
    pub sub: u8,
}

/// A request of the client to the SDO server.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// Initiate download: a write to an object, with its data or the announced size.
    Download(Address, Announced),
    /// A segment of the written data.
    DownloadSegment {
        /// The toggle bit, which alternates from segment to segment.
        toggle: bool,
        /// The number of valid data bytes, 0 to 7.
        length: u8,
        /// The segment is the last one.
        last: bool,
    },
    /// Initiate upload: a read of an object.
    Upload(Address),
    /// Send the next segment of the read data.
    UploadSegment {
        /// The toggle bit, which alternates from segment to segment.
        toggle: bool,
    },
    /// The client aborts the transfer of this object.
    Abort(Address),
    /// An unknown command, or a block transfer, which is parsed in [`block`](super::block).
    Unsupported(Address),
}

/// The data, or its announced size, in the initiate request of a download.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Announced {
    /// The data is in this frame, with its length in bytes; None: the length of the object.
    Expedited([u8; 4], Option<u8>),
    /// The data follows in segments. The size in bytes, if it is indicated.
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
            4 => Self::Abort(address),
            _ => Self::Unsupported(address),
        }
    }
}

/// Whether this is the initiate request of an expedited or segmented transfer.
pub fn is_initiate([command, ..]: [u8; 8]) -> bool {
    matches!(command >> 5, 1 | 2)
}

/// The reply to a read of a number of `size` bytes, 1 to 4.
pub fn number_reply(address: Address, number: u32, size: u8) -> [u8; 8] {
    let unused = 4_u8.saturating_sub(size);
    // A signed number can have more bits than its type.
    let number = number & u32::MAX.checked_shr(8 * u32::from(unused)).unwrap_or(0);
    addressed(0x43 | unused << 2, address, number.to_le_bytes())
}

/// Whether data of `length` bytes is sent in the reply to the initiate request. No data is sent in a segment.
pub const fn is_expedited(length: usize) -> bool {
    matches!(length, 1..=4)
}

/// The data in the reply to the initiate request of an upload; None if it is not expedited.
pub fn expedited_data([command, _, _, _, data @ ..]: &[u8; 8]) -> Option<&[u8]> {
    let length = 4 - (command >> 2 & 3);
    let expedited = command & 0x02 != 0;
    data.get(..length.into()).filter(|_| expedited)
}

/// The reply to the initiate request of an upload: expedited with 1 to 4 bytes of data, otherwise with the size of the data.
pub fn upload_reply(address: Address, data: &[u8]) -> [u8; 8] {
    let length = data.len() as u8;
    if is_expedited(data.len()) {
        let number = data.iter().rev();
        let number = number.fold(0, |number, &byte| number << 8 | u32::from(byte));
        return number_reply(address, number, length);
    }
    addressed(0x41, address, u32::from(length).to_le_bytes())
}

/// A segment of an upload with up to seven bytes of data.
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

/// The command byte of the reply to the initiate request of a download.
const DOWNLOAD_REPLY: u8 = 0x60;

/// The reply to the initiate request of a download.
pub fn download_reply(address: Address) -> [u8; 8] {
    addressed(DOWNLOAD_REPLY, address, [0; 4])
}

/// The confirmation of a segment with this toggle bit.
pub fn download_segment_reply(toggle: bool) -> [u8; 8] {
    [0x20 | u8::from(toggle) << 4, 0, 0, 0, 0, 0, 0, 0]
}

/// The reply to the last message of a download with this command byte: that to the initiate request contains the address.
pub fn confirmation(command: u8, address: Address) -> [u8; 8] {
    let address = match command {
        DOWNLOAD_REPLY => address,
        _ => Address::default(),
    };
    addressed(command, address, [0; 4])
}

/// The message that ends a transfer with this abort code.
pub fn abort(address: Address, abort: Abort) -> [u8; 8] {
    addressed(0x80, address, (abort as u32).to_le_bytes())
}

/// The reply to the initiate request of a block upload: the server has the CRC, and the size of the data in bytes.
pub fn block_upload_reply(address: Address, size: u32) -> [u8; 8] {
    addressed(0xC6, address, size.to_le_bytes())
}

/// The end of a block upload: the number of unused bytes in the last segment, 0 to 7, and the CRC.
pub fn block_end(unused: u8, crc: u16) -> [u8; 8] {
    let [low, high] = crc.to_le_bytes();
    [0xC1 | (unused & 7) << 2, low, high, 0, 0, 0, 0, 0]
}

/// The reply to the initiate request of a block download: the server has the CRC, and requests blocks of this size.
pub fn block_download_reply(address: Address, size: u8) -> [u8; 8] {
    addressed(0xA4, address, [size, 0, 0, 0])
}

/// The acknowledgement of the segments up to `number` of a block download, with the size of the next block.
pub fn block_acknowledgement(number: u8, size: u8) -> [u8; 8] {
    [0xA2, number, size, 0, 0, 0, 0, 0]
}

/// The confirmation that the data of a block download is complete and written.
pub fn block_download_end_reply() -> [u8; 8] {
    [0xA1, 0, 0, 0, 0, 0, 0, 0]
}

fn addressed(command: u8, address: Address, [d0, d1, d2, d3]: [u8; 4]) -> [u8; 8] {
    let [low, high] = address.index.to_le_bytes();
    [command, low, high, address.sub, d0, d1, d2, d3]
}
