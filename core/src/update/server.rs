//! The SDO server of the bootloader (CiA 301, 7.2.4.3): reads of numbers, expedited, segmented and block downloads.
//!
//! It is smaller than [that of a node](crate::canopen::sdo), because it sends no text and keeps no data: it passes each segment or block on
//! before its confirmation, so that nothing is sent to the sensor while the flash is busy. It does not check the CRC of a block download,
//! and says so, because the file has a CRC of its own. Blocks have [`DOWNLOAD_BLOCK`] segments, as those of a node.

use super::objects::Update;
use super::slot::Slot;
use crate::canopen::Abort;
use crate::canopen::sdo::TIME_OUT;
use crate::canopen::sdo::block::DOWNLOAD_BLOCK;
use crate::canopen::sdo::message::{self, Address, Announced, Request};
use crate::time::{Deadline, Instant};

/// Data bytes in a segment.
const SEGMENT: usize = 7;
/// Bit of byte 0 of a segment of a block: the last one.
const LAST: u8 = 0x80;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Idle,
    /// Segments, with the toggle bit expected next.
    Segments {
        toggle: bool,
    },
    /// A block, with the number of segments received in sequence.
    Block {
        segments: u8,
    },
    /// The last block is confirmed. The end follows.
    End,
}

/// The transfer of a file.
#[derive(Clone, Debug)]
pub struct UpdateServer {
    stage: Stage,
    /// The object of the transfer.
    address: Address,
    expires: Deadline,
    /// The segments of a block.
    block: [[u8; SEGMENT]; DOWNLOAD_BLOCK as usize],
    /// The last segment of the block before.
    tail: Option<[u8; SEGMENT]>,
}

impl Default for UpdateServer {
    fn default() -> Self {
        Self::new()
    }
}

impl UpdateServer {
    /// Before the first request.
    pub const fn new() -> Self {
        Self {
            stage: Stage::Idle,
            address: Address { index: 0, sub: 0 },
            expires: Deadline::NEVER,
            block: [[0; SEGMENT]; DOWNLOAD_BLOCK as usize],
            tail: None,
        }
    }

    /// Handles a request. Returns the reply, if there is one.
    pub fn serve<S: Slot>(
        &mut self,
        update: &mut Update<S>,
        now: Instant,
        bytes: [u8; 8],
    ) -> Option<[u8; 8]> {
        match self.reply(update, bytes) {
            Ok(reply) => {
                self.expires = match self.stage {
                    Stage::Idle => Deadline::NEVER,
                    _ => Deadline::after(now, TIME_OUT),
                };
                reply
            }
            Err(abort) => Some(self.abort(abort)),
        }
    }

    /// Aborts a transfer that has timed out. Returns the abort message.
    pub fn poll(&mut self, now: Instant) -> Option<[u8; 8]> {
        let is_late = self.expires.is_reached(now);
        is_late.then(|| self.abort(Abort::TimeOut))
    }

    fn abort(&mut self, abort: Abort) -> [u8; 8] {
        self.stage = Stage::Idle;
        self.expires = Deadline::NEVER;
        message::abort(self.address, abort)
    }

    #[inline(never)] // inlined, it makes the bootloader 390 bytes larger than its 6 KiB
    fn reply<S: Slot>(
        &mut self,
        update: &mut Update<S>,
        bytes: [u8; 8],
    ) -> Result<Option<[u8; 8]>, Abort> {
        let [command, low, high, sub, d0, d1, d2, d3] = bytes;
        let address = Address {
            index: u16::from_le_bytes([low, high]),
            sub,
        };
        match (self.stage, command) {
            (Stage::Block { segments }, 0x01..=0x1F | 0x81..=0x9F) => {
                return self.take_segment(update, bytes, segments);
            }
            // The last segment, repeated.
            (Stage::End, 0x81..=0x9F) => return Ok(None),
            (Stage::End, 0xC1..) if command & 0xE3 == 0xC1 => {
                return self.take_end(update, command >> 2 & 7);
            }
            // Block download: bit 1: with the size, bit 2: with a CRC.
            (_, 0xC0 | 0xC2 | 0xC4 | 0xC6) => {
                self.begin(address);
                let size = u32::from_le_bytes([d0, d1, d2, d3]);
                update.begin(address, (command & 0x02 != 0).then_some(size))?;
                self.stage = Stage::Block { segments: 0 };
                let mut reply = message::block_download_reply(address, DOWNLOAD_BLOCK);
                // Without the CRC.
                let [command, ..] = &mut reply;
                *command = 0xA0;
                return Ok(Some(reply));
            }
            _ => {}
        }
        let reply = match Request::parse(bytes) {
            Request::Upload(address) => {
                self.begin(address);
                let (value, size) = update.read(address)?;
                message::number_reply(address, value, size)
            }
            Request::Download(address, Announced::Expedited(data, length)) => {
                self.begin(address);
                update.write(address, data, length)?;
                message::download_reply(address)
            }
            Request::Download(address, Announced::Segmented(size)) => {
                self.begin(address);
                update.begin(address, size)?;
                self.stage = Stage::Segments { toggle: false };
                message::download_reply(address)
            }
            Request::DownloadSegment {
                toggle,
                length,
                last,
            } => {
                let Stage::Segments { toggle: expected } = self.stage else {
                    return Err(Abort::Command);
                };
                if toggle != expected {
                    return Err(Abort::Toggle);
                }
                let [_, data @ ..] = &bytes;
                update.take(data.get(..length.into()).unwrap_or(data))?;
                if last {
                    update.finish()?;
                    self.stage = Stage::Idle;
                } else {
                    self.stage = Stage::Segments { toggle: !toggle };
                }
                message::download_segment_reply(toggle)
            }
            Request::Abort(_) => {
                self.stage = Stage::Idle;
                return Ok(None);
            }
            Request::UploadSegment { .. } => return Err(Abort::Command),
            Request::Unsupported(address) => {
                self.begin(address);
                return Err(Abort::Command);
            }
        };
        Ok(Some(reply))
    }

    /// Begins a transfer of this object and forgets the one before.
    fn begin(&mut self, address: Address) {
        self.stage = Stage::Idle;
        self.address = address;
        self.tail = None;
    }

    /// Takes a segment of a block. An error waits for the end of the block, because a client listens there only.
    fn take_segment<S: Slot>(
        &mut self,
        update: &mut Update<S>,
        [command, content @ ..]: [u8; 8],
        segments: u8,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let (number, is_last) = (command & !LAST, command & LAST != 0);
        let is_next = number == segments + 1;
        if is_next && let Some(place) = self.block.get_mut(usize::from(segments)) {
            *place = content;
        }
        let segments = segments + u8::from(is_next);
        if number < DOWNLOAD_BLOCK && !is_last {
            self.stage = Stage::Block { segments };
            return Ok(None);
        }
        // How many bytes of the last segment count follows with the end of the transfer.
        if let Some(([tail], others)) = self.block.get(..segments.into()).and_then(|block| {
            block
                .split_last_chunk()
                .map(|(others, tail)| (tail, others))
        }) {
            if let Some(before) = self.tail.replace(*tail) {
                update.take(&before)?;
            }
            update.take(others.as_flattened())?;
        }
        let is_end = is_last && is_next;
        self.stage = if is_end {
            Stage::End
        } else {
            Stage::Block { segments: 0 }
        };
        Ok(Some(message::block_acknowledgement(
            segments,
            DOWNLOAD_BLOCK,
        )))
    }

    fn take_end<S: Slot>(
        &mut self,
        update: &mut Update<S>,
        unused: u8,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let tail = self.tail.take().unwrap_or_default();
        let used = SEGMENT.saturating_sub(unused.into());
        update.take(tail.get(..used).unwrap_or(&tail))?;
        update.finish()?;
        self.stage = Stage::Idle;
        Ok(Some(message::block_download_end_reply()))
    }
}
