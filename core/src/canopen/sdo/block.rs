//! SDO block transfer (CiA 301, 7.2.4.3.8 to 7.2.4.3.16): up to 127 segments, then one acknowledgement.
//!
//! ```text
//!             byte 0         1       2       3          4                      8
//!            +--------------+---------------+----------+----------------------+
//!  upload    | A0h, A4h CRC | index         | sub-index| block size, pst      |  client: initiate
//!            | C6h          | index         | sub-index| size in bytes (4)    |  server
//!            | A3h          |                                                 |  client: start
//!            | number, 80h  | data (7)                                        |  server: segment; bit 7: the last one
//!            | A2h          | number | block size                             |  client: acknowledgement
//!            | C1h, unused  | CRC (2)                                         |  server: end; bits 2..4: unused bytes
//!            | A1h          |                                                 |  client: end
//!  download  | C0h to C6h   | index         | sub-index| size in bytes (4)    |  client: initiate; bit 1: size, bit 2: CRC
//!            | A4h          | index         | sub-index| block size           |  server
//!            | number, 80h  | data (7)                                        |  client: segment
//!            | A2h          | number | block size                             |  server: acknowledgement
//!            | C1h, unused  | CRC (2)                                         |  client: end
//!            | A1h          |                                                 |  server: end
//!            +--------------+-------------------------------------------------+
//! ```
//!
//! Segments have the numbers 1, 2, ... in each block. The acknowledgement has the number of the last segment that was received in
//! sequence; the sender repeats those after it in the next block. The CRC is CRC-16/XMODEM of all data bytes, and is 0 if the
//! client does not check it. The protocol switch threshold (pst) is not used: the server never answers with a segmented transfer.
//!
//! In a download, the server requests blocks of [`DOWNLOAD_BLOCK`] segments. So byte 0 of a segment is different from byte 0 of
//! each initiate request, and a client that begins another transfer in the middle of a block gets its reply.

use super::message::{self, Address};
use super::server::{Buffer, Objects, Server, check_length};
use crate::canopen::Abort;
use crate::canopen::feature::{Feature, Initial};
use crate::time::Instant;
use crc::{CRC_16_XMODEM, Crc, NoTable};

/// The number of segments in a block of a download.
pub const DOWNLOAD_BLOCK: u8 = 31;

/// Data bytes in a segment.
const SEGMENT: usize = 7;
/// Bit of byte 0 of a segment: the last one.
const LAST: u8 = 0x80;
/// The largest number of segments in a block.
const LARGEST: u8 = 127;

/// The commands of the client.
mod command {
    pub const UPLOAD: u8 = 0xA0;
    pub const UPLOAD_WITH_CRC: u8 = 0xA4;
    pub const UPLOAD_END: u8 = 0xA1;
    pub const UPLOAD_ACKNOWLEDGE: u8 = 0xA2;
    pub const UPLOAD_START: u8 = 0xA3;
    pub const ABORT: u8 = 0x80;
    /// Bits 0 and 5 to 7: download.
    pub const DOWNLOAD_MASK: u8 = 0xE1;
    pub const DOWNLOAD: u8 = 0xC0;
    pub const DOWNLOAD_END: u8 = 0xC1;
    /// The commands are from here...
    pub const FIRST: u8 = 0xA0;
    /// ...to here, both included.
    pub const LAST: u8 = 0xDF;
    /// Bit of an initiate request: the client checks the CRC.
    pub const CRC: u8 = 0x04;
    /// Bit of an initiate request of a download: the size is indicated.
    pub const SIZED: u8 = 0x02;
}

/// The state of the transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Idle,
    /// Upload: the client must start it.
    Initiated,
    /// Upload: segments of the block are not sent yet.
    Sending,
    /// Upload: the block is sent, the client must acknowledge it.
    Sent,
    /// Upload: all data is acknowledged, the client must confirm the end.
    Ending,
    /// Download: the client sends segments.
    Receiving,
    /// Download: the last segment is acknowledged, the client must send the end.
    Received,
}

/// The block transfer of a server.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    stage: Stage,
    /// The client checks the CRC.
    has_crc: bool,
    /// Upload: the number of segments in the block.
    size: u8,
    /// The number of segments of the block that are sent, or received in sequence.
    segments: u8,
    /// Upload: the last acknowledgement: number and block size.
    before: [u8; 2],
    /// Download: the number of the segment that ended a block, until the next segment; otherwise 0.
    ended_by: u8,
    /// Upload: the data before the block, in bytes.
    acknowledged: usize,
    /// Download: the announced size in bytes, if it is indicated.
    announced: Option<u32>,
    /// Download: the last received segment. The number of its unused bytes follows with the end of the transfer.
    tail: Option<[u8; SEGMENT]>,
}

impl Initial for Block {
    const INITIAL: Self = Self {
        stage: Stage::Idle,
        has_crc: false,
        size: 0,
        segments: 0,
        before: [0; 2],
        ended_by: 0,
        acknowledged: 0,
        announced: None,
        tail: None,
    };
}

impl Block {
    pub(super) fn end(&mut self) {
        self.stage = Stage::Idle;
    }

    fn begin(&mut self, stage: Stage, has_crc: bool) {
        *self = Self::INITIAL;
        self.stage = stage;
        self.has_crc = has_crc;
    }

    /// The CRC of the data; 0 if the client does not check it.
    fn crc(&self, data: &[u8]) -> u16 {
        const CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_XMODEM);
        if self.has_crc { CRC.checksum(data) } else { 0 }
    }

    /// The next segment of an upload.
    fn next(&mut self, data: &[u8]) -> [u8; 8] {
        let from = self.acknowledged + SEGMENT * usize::from(self.segments);
        let rest = data.get(from..).unwrap_or(&[]);
        self.segments = self.segments.saturating_add(1);
        let is_last = rest.len() <= SEGMENT;
        if is_last || self.segments >= self.size {
            self.stage = Stage::Sent;
        }
        let mut bytes = [0; 8];
        let [number, content @ ..] = &mut bytes;
        *number = self.segments | if is_last { LAST } else { 0 };
        for (to, from) in content.iter_mut().zip(rest) {
            *to = *from;
        }
        bytes
    }

    /// Handles the acknowledgement of a block of an upload. Returns the message for the end of the transfer.
    fn acknowledge(
        &mut self,
        data: &[u8],
        acknowledgement: [u8; 2],
    ) -> Result<Option<[u8; 8]>, Abort> {
        let [number, size] = acknowledgement;
        let is_possible = self.stage == Stage::Sent && number <= self.segments;
        // A repeated frame: the block that follows it is being sent.
        if acknowledgement == self.before && !is_possible {
            return Ok(None);
        }
        if number > self.segments {
            return Err(Abort::SequenceNumber);
        }
        let acknowledged = self.acknowledged + SEGMENT * usize::from(number);
        if number > 0 && acknowledged >= data.len() {
            self.stage = Stage::Ending;
            let unused = (acknowledged - data.len()) as u8;
            return Ok(Some(message::block_end(unused, self.crc(data))));
        }
        check_size(size)?;
        self.acknowledged = acknowledged;
        self.before = acknowledgement;
        self.size = size;
        self.segments = 0;
        self.stage = Stage::Sending;
        Ok(None)
    }

    /// Handles a segment of a download. Appends the segment before it to `data`. Returns the acknowledgement at the end of a
    /// block.
    fn receive(
        &mut self,
        data: &mut impl Buffer,
        bytes: [u8; 8],
    ) -> Result<Option<[u8; 8]>, Abort> {
        let [command, content @ ..] = bytes;
        let (number, is_last) = (command & !LAST, command & LAST != 0);
        let expected = self.segments + 1;
        if number == expected {
            if let Some(tail) = self.tail.replace(content)
                && !data.append(&tail)
            {
                return Err(Abort::TooLong);
            }
            self.segments = number;
            if is_last {
                self.stage = Stage::Received;
            }
        }
        // The end of the block before, repeated at once.
        let is_repeated = core::mem::take(&mut self.ended_by) == number && number != expected;
        let ends = is_last || number == DOWNLOAD_BLOCK;
        if !ends || is_repeated {
            return Ok(None);
        }
        let acknowledgement = message::block_acknowledgement(self.segments, DOWNLOAD_BLOCK);
        self.ended_by = number;
        self.segments = 0;
        Ok(Some(acknowledgement))
    }
}

/// Whether this is the initiate request of a block transfer.
pub fn is_initiate([command, ..]: [u8; 8]) -> bool {
    matches!(command, command::UPLOAD | command::UPLOAD_WITH_CRC) || is_download(command)
}

fn is_download(command: u8) -> bool {
    command & command::DOWNLOAD_MASK == command::DOWNLOAD
}

/// Whether this is a command of a block transfer, other than a segment or an abort.
pub fn is_command([command, ..]: [u8; 8]) -> bool {
    matches!(command, command::FIRST..=command::LAST)
}

fn check_size(size: u8) -> Result<(), Abort> {
    match size {
        1..=LARGEST => Ok(()),
        _ => Err(Abort::BlockSize),
    }
}

impl<O: Copy, B: Buffer, K: Feature<Block>> Server<O, B, K> {
    /// Handles a request of a block transfer, which is not the [initiate request](message::is_initiate) of another transfer. Returns
    /// None if it is none.
    pub(super) fn serve_block<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        bytes: [u8; 8],
    ) -> Option<Result<Option<[u8; 8]>, Abort>> {
        let stage = self.block.get()?.stage;
        let [command, low, high, sub, ..] = bytes;
        let index = u16::from_le_bytes([low, high]);
        let address = Address { index, sub };
        match (stage, command) {
            (_, command::UPLOAD | command::UPLOAD_WITH_CRC) => {
                self.begin(address);
                Some(self.block_upload(objects, now, address, bytes))
            }
            (_, _) if is_download(command) => {
                self.begin(address);
                Some(self.block_download(objects, now, address, bytes))
            }
            (Stage::Receiving | Stage::Received, command::ABORT) => None,
            (Stage::Receiving, _) => Some(self.block_segment(now, bytes)),
            // The last segment, repeated.
            (Stage::Received, 0x81..=0x9F) => Some(Ok(None)),
            (Stage::Received, _) if command & command::DOWNLOAD_MASK == command::DOWNLOAD_END => {
                Some(self.block_download_end(objects, now, bytes))
            }
            (Stage::Initiated, command::UPLOAD_START) => Some(self.block_start(now)),
            // The start, repeated.
            (Stage::Sending | Stage::Sent, command::UPLOAD_START) => Some(Ok(None)),
            (Stage::Sending | Stage::Sent, command::UPLOAD_ACKNOWLEDGE) => {
                Some(self.block_acknowledge(now, [low, high]))
            }
            // The last acknowledgement, repeated.
            (Stage::Ending, command::UPLOAD_ACKNOWLEDGE) => Some(Ok(None)),
            (Stage::Ending, command::UPLOAD_END) => {
                self.finish();
                Some(Ok(None))
            }
            // Not valid in this stage: keeps the address of the transfer for the abort.
            (_, command::FIRST..=command::LAST) => Some(Err(Abort::Command)),
            _ => None,
        }
    }

    /// Whether an upload has segments to send: call [`next_segment`](Self::next_segment) while the transmit queue is empty.
    pub fn is_streaming(&self) -> bool {
        let block = self.block.get();
        block.is_some_and(|block| block.stage == Stage::Sending)
    }

    /// The next segment of an upload; None if there is none.
    pub fn next_segment(&mut self, now: Instant) -> Option<[u8; 8]> {
        if !self.is_streaming() {
            return None;
        }
        self.extend(now);
        let data = self.data.bytes();
        self.block.get_mut().map(|block| block.next(data))
    }

    fn block_upload<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        address: Address,
        [command, _, _, _, size, ..]: [u8; 8],
    ) -> Result<Option<[u8; 8]>, Abort> {
        check_size(size)?;
        let reply = self.upload(objects, now, address)?;
        self.begin(address);
        if let Some(data) = message::expedited_data(&reply) {
            self.data = B::EMPTY;
            // There is room: checked at compile time.
            self.data.append(data);
        }
        if let Some(block) = self.block.get_mut() {
            block.begin(Stage::Initiated, command & command::CRC != 0);
            block.size = size;
        }
        self.extend(now);
        let length = self.data.bytes().len() as u32;
        Ok(Some(message::block_upload_reply(address, length)))
    }

    fn block_start(&mut self, now: Instant) -> Result<Option<[u8; 8]>, Abort> {
        if let Some(block) = self.block.get_mut() {
            block.stage = Stage::Sending;
        }
        self.extend(now);
        Ok(None)
    }

    fn block_acknowledge(
        &mut self,
        now: Instant,
        acknowledgement: [u8; 2],
    ) -> Result<Option<[u8; 8]>, Abort> {
        self.extend(now);
        let data = self.data.bytes();
        match self.block.get_mut() {
            Some(block) => block.acknowledge(data, acknowledgement),
            None => Ok(None),
        }
    }

    fn block_download<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        address: Address,
        [command, _, _, _, d0, d1, d2, d3]: [u8; 8],
    ) -> Result<Option<[u8; 8]>, Abort> {
        let object = objects.find(address)?;
        if !T::is_writable(object) {
            return Err(Abort::ReadOnly);
        }
        let size = u32::from_le_bytes([d0, d1, d2, d3]);
        let announced = (command & command::SIZED != 0).then_some(size);
        if let Some(size) = announced {
            check_length(objects, now, object, size)?;
        }
        self.data = B::EMPTY;
        if let Some(block) = self.block.get_mut() {
            block.begin(Stage::Receiving, command & command::CRC != 0);
            block.announced = announced;
        }
        self.extend(now);
        Ok(Some(message::block_download_reply(address, DOWNLOAD_BLOCK)))
    }

    fn block_segment(&mut self, now: Instant, bytes: [u8; 8]) -> Result<Option<[u8; 8]>, Abort> {
        let [command, ..] = bytes;
        if !(1..=DOWNLOAD_BLOCK).contains(&(command & !LAST)) {
            return Err(Abort::SequenceNumber);
        }
        let Some(block) = self.block.get_mut() else {
            return Ok(None);
        };
        let before = (block.stage, block.segments);
        let reply = block.receive(&mut self.data, bytes)?;
        // A client that only sends segments out of sequence times out.
        if reply.is_some() || before != (block.stage, block.segments) {
            self.extend(now);
        }
        Ok(reply)
    }

    fn block_download_end<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        [command, low, high, ..]: [u8; 8],
    ) -> Result<Option<[u8; 8]>, Abort> {
        let Some(block) = self.block.get_mut() else {
            return Ok(None);
        };
        let tail = block.tail.take().unwrap_or_default();
        let used = SEGMENT.saturating_sub(usize::from(command >> 2 & 7));
        if !self.data.append(tail.get(..used).unwrap_or(&tail)) {
            return Err(Abort::TooLong);
        }
        let length = self.data.bytes().len() as u32;
        if block.announced.is_some_and(|size| size != length) {
            return Err(Abort::Length);
        }
        if block.has_crc && block.crc(self.data.bytes()) != u16::from_le_bytes([low, high]) {
            return Err(Abort::Crc);
        }
        let object = objects.find(self.address)?;
        check_length(objects, now, object, length)?;
        let data = core::mem::replace(&mut self.data, B::EMPTY);
        let written = objects.write(now, object, data.bytes())?;
        Ok(self.answer(written, message::block_download_end_reply()))
    }
}
