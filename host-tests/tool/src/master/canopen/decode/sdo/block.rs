//! Block transfers (CiA 301, 7.2.4.3.8 to 7.2.4.3.16). A segment has no command: it is recognised by the state of the transfer.

use super::{LONGEST, Message, Transfer, done, multiplexor, object};
use crate::decode::{Device, Named};
use plumbline::param::number;

/// Data bytes in a segment.
const SEGMENT: usize = 7;

/// The block size of a client that does not tell it.
const LARGEST: u8 = 127;

/// The state of a block transfer.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Segments can follow.
    flows: bool,
    /// The number of segments in a block.
    size: u8,
    /// The bytes before the present block.
    acknowledged: usize,
    /// The number of the last segment, if it was heard.
    last: Option<u8>,
}

impl Block {
    fn new(size: u8) -> Self {
        Self {
            flows: false,
            size,
            acknowledged: 0,
            last: None,
        }
    }

    /// The segments up to this one are received; the others of the block come again.
    fn acknowledge(&mut self, segments: u8, size: u8, data: &mut Vec<u8>) {
        self.acknowledged += SEGMENT * usize::from(segments);
        data.truncate(self.acknowledged);
        self.size = size;
        self.flows = self.last != Some(segments);
        if self.flows {
            self.last = None;
        }
    }
}

impl Transfer {
    /// A message of the client in a block transfer.
    pub(super) fn block_request(&mut self, device: &mut Device, bytes: [u8; 8]) -> Option<Message> {
        if self.writes && self.is_segment(bytes[0]) {
            return self.block_segment(device, bytes, "write");
        }
        match bytes[0] {
            0xA0 | 0xA4 => {
                self.begin_block(multiplexor(bytes), false, bytes[4]);
                let values = vec![Named::number("block-size", bytes[4])];
                Some(self.block_message(device, "read", "", values))
            }
            command if command & 0xE1 == 0xC0 => {
                self.begin_block(multiplexor(bytes), true, LARGEST);
                Some(self.block_message(device, "write", "", size(command, bytes)))
            }
            command if command & 0xE3 == 0xC1 && self.writes => {
                self.block_end(device, bytes, "write")
            }
            0xA3 if !self.writes => {
                self.block.as_mut()?.flows = true;
                Some(self.block_message(device, "read", ", start", Vec::new()))
            }
            0xA2 if !self.writes => self.block_acknowledge(device, bytes, "read"),
            0xA1 if !self.writes => {
                self.block.as_ref()?;
                let message = self.block_message(device, "read", ", end", Vec::new());
                self.object = None;
                self.block = None;
                Some(message)
            }
            _ => None,
        }
    }

    /// A message of the server in a block transfer.
    pub(super) fn block_answer(&mut self, device: &mut Device, bytes: [u8; 8]) -> Option<Message> {
        if !self.writes && self.is_segment(bytes[0]) {
            return self.block_segment(device, bytes, "answer");
        }
        match bytes[0] {
            command if command & 0xE1 == 0xC0 && !self.writes => {
                self.block.as_ref()?;
                let values = size(command, bytes);
                Some(self.block_message(device, "answer", ", in segments", values))
            }
            command if command & 0xE3 == 0xC1 && !self.writes => {
                self.block_end(device, bytes, "answer")
            }
            0xA0 | 0xA4 if self.writes => {
                let block = self.block.as_mut()?;
                (block.flows, block.size) = (true, bytes[4]);
                let values = vec![Named::number("block-size", bytes[4])];
                Some(self.block_message(device, "write accepted", "", values))
            }
            0xA2 if self.writes => self.block_acknowledge(device, bytes, "write"),
            0xA1 if self.writes => {
                self.block.as_ref()?;
                let message = self.block_message(device, "write", ", done", Vec::new());
                self.object = None;
                self.block = None;
                Some(message)
            }
            _ => None,
        }
    }

    fn begin_block(&mut self, object: (u16, u8), writes: bool, size: u8) {
        *self = Self {
            object: Some(object),
            writes,
            data: Vec::new(),
            block: Some(Block::new(size)),
        };
    }

    fn block_message(
        &self,
        device: &Device,
        verb: &str,
        behind: &str,
        values: Vec<Named>,
    ) -> Message {
        let (index, sub) = self.object.unwrap_or_default();
        let name = object(device, index, sub);
        Message {
            text: format!("SDO block {verb} {name}{behind}"),
            values,
            done: None,
        }
    }

    /// Whether a byte is that of a segment, not a command or an abort.
    fn is_segment(&self, command: u8) -> bool {
        let block = self.block.as_ref();
        block.is_some_and(|block| block.flows && (1..=block.size).contains(&(command & 0x7F)))
    }

    fn block_segment(&mut self, device: &Device, bytes: [u8; 8], verb: &str) -> Option<Message> {
        let [command, data @ ..] = bytes;
        let place = command & 0x7F;
        let block = self.block.as_mut()?;
        let start = block.acknowledged + SEGMENT * (usize::from(place) - 1);
        // A segment behind a gap is sent again after the acknowledgement.
        if start == self.data.len() {
            self.data.extend_from_slice(&data);
        }
        if command & 0x80 != 0 {
            block.flows = false;
            block.last = Some(place);
        }
        if self.data.len() > LONGEST {
            self.block = None;
        }
        let values = vec![Named::bytes(&data)];
        Some(self.block_message(device, verb, &format!(", segment {place}"), values))
    }

    fn block_acknowledge(
        &mut self,
        device: &Device,
        bytes: [u8; 8],
        verb: &str,
    ) -> Option<Message> {
        let [_, segments, size, ..] = bytes;
        let block = self.block.as_mut()?;
        block.acknowledge(segments, size, &mut self.data);
        let values = vec![
            Named::number("segments", segments),
            Named::number("block-size", size),
        ];
        Some(self.block_message(device, verb, ", segments accepted", values))
    }

    /// The end of the data, with the number of bytes that the last segment does not use, and the CRC.
    fn block_end(&mut self, device: &mut Device, bytes: [u8; 8], verb: &str) -> Option<Message> {
        self.block.as_mut()?.flows = false;
        let unused = usize::from(bytes[0] >> 2 & 7);
        let mut data = std::mem::take(&mut self.data);
        data.truncate(data.len().saturating_sub(unused));
        let text = self.block_message(device, verb, ", end of data", Vec::new());
        let object = self.object?;
        let mut message = done(device, text.text, object, data);
        let crc = format!("{:04X}h", number(&bytes[1..3]));
        message.values.push(Named::text("crc", crc));
        Some(message)
    }
}

/// The size of the data, if it is told.
fn size(command: u8, bytes: [u8; 8]) -> Vec<Named> {
    let is_told = command & 2 != 0;
    let size = is_told.then(|| Named::number("size", number(&bytes[4..])));
    size.into_iter().collect()
}
