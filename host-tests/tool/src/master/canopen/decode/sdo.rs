//! SDO transfers: expedited, segmented, and in blocks. A sensor in J1939 has the same bytes in group EF00h.

mod block;

use super::{is_understood, object};
use crate::decode::{Device, Named};
use crate::master::canopen::sdo::reason;
use block::Block;
use plumbline::param::number;

/// The longest transfer that is put together, in bytes.
const LONGEST: usize = 4096;

/// The transfer between a client and a server.
#[derive(Clone, Debug, Default)]
pub(crate) struct Transfer {
    object: Option<(u16, u8)>,
    writes: bool,
    data: Vec<u8>,
    /// The state of a block transfer, if it is one.
    block: Option<Block>,
}

/// What a message of a transfer is.
#[derive(Debug)]
pub(crate) struct Message {
    pub text: String,
    pub values: Vec<Named>,
    /// The object and the bytes, if the message completes them.
    pub done: Option<(u16, u8, Vec<u8>)>,
}

impl Message {
    fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            values: Vec::new(),
            done: None,
        }
    }
}

/// The object of an initiating message.
fn multiplexor(bytes: [u8; 8]) -> (u16, u8) {
    let [_, low, high, sub, ..] = bytes;
    (u16::from_le_bytes([low, high]), sub)
}

/// The bytes of an expedited transfer, and None if it is not expedited.
fn expedited(bytes: &[u8; 8]) -> Option<&[u8]> {
    let [command, _, _, _, data @ ..] = bytes;
    let unused = match command & 1 {
        0 => 0,
        _ => command >> 2 & 3,
    };
    (command & 2 != 0).then(|| &data[..4 - usize::from(unused)])
}

/// The bytes of a segment.
fn segment(bytes: &[u8; 8]) -> &[u8] {
    let [command, data @ ..] = bytes;
    &data[..7 - usize::from(command >> 1 & 7)]
}

impl Transfer {
    /// A message of the client; None: it is no message of SDO.
    pub fn request(&mut self, device: &mut Device, bytes: [u8; 8]) -> Option<Message> {
        if let Some(message) = self.block_request(device, bytes) {
            return Some(message);
        }
        let (index, sub) = multiplexor(bytes);
        match bytes[0] >> 5 {
            1 if bytes[0] & 0x10 == 0 => {
                let data = expedited(&bytes).map(<[u8]>::to_vec);
                Some(self.begin(device, (index, sub), true, data, "write"))
            }
            2 if bytes[0] == 0x40 => {
                let empty = Self {
                    object: Some((index, sub)),
                    ..Self::default()
                };
                *self = empty;
                Some(Message::new(format!(
                    "SDO read {}",
                    object(device, index, sub)
                )))
            }
            0 if self.writes && self.object.is_some() => {
                Some(self.segment(device, &bytes, "write"))
            }
            3 if self.object.is_some() => Some(Message::new("SDO read, next segment")),
            4 if bytes[0] == 0x80 => Some(self.abort(device, bytes)),
            _ => None,
        }
    }

    /// A message of the server.
    pub fn answer(&mut self, device: &mut Device, bytes: [u8; 8]) -> Option<Message> {
        if let Some(message) = self.block_answer(device, bytes) {
            return Some(message);
        }
        let (index, sub) = multiplexor(bytes);
        match bytes[0] >> 5 {
            2 if bytes[0] & 0x10 == 0 => {
                let data = expedited(&bytes).map(<[u8]>::to_vec);
                Some(self.begin(device, (index, sub), false, data, "answer"))
            }
            0 if !self.writes && self.object.is_some() => {
                Some(self.segment(device, &bytes, "answer"))
            }
            3 if bytes[0] == 0x60 => Some(Message::new(format!(
                "SDO write accepted {}",
                object(device, index, sub)
            ))),
            1 if self.writes && self.object.is_some() => {
                Some(Message::new("SDO write, segment accepted"))
            }
            4 if bytes[0] == 0x80 => Some(self.abort(device, bytes)),
            _ => None,
        }
    }

    fn begin(
        &mut self,
        device: &mut Device,
        (index, sub): (u16, u8),
        writes: bool,
        data: Option<Vec<u8>>,
        verb: &str,
    ) -> Message {
        *self = Self {
            object: Some((index, sub)),
            writes,
            ..Self::default()
        };
        let text = format!("SDO {verb} {}", object(device, index, sub));
        match data {
            Some(data) => done(device, text, (index, sub), data),
            None => Message::new(format!("{text}, in segments")),
        }
    }

    fn segment(&mut self, device: &mut Device, bytes: &[u8; 8], verb: &str) -> Message {
        let (index, sub) = self.object.unwrap_or_default();
        self.data.extend_from_slice(segment(bytes));
        let text = format!("SDO {verb} {}", object(device, index, sub));
        if self.data.len() > LONGEST {
            self.object = None;
        }
        if bytes[0] & 1 == 0 {
            return Message::new(format!("{text}, segment"));
        }
        self.object = None;
        done(device, text, (index, sub), std::mem::take(&mut self.data))
    }

    fn abort(&mut self, device: &Device, bytes: [u8; 8]) -> Message {
        self.object = None;
        self.block = None;
        let (index, sub) = multiplexor(bytes);
        let code = number(&bytes[4..]);
        let mut message = Message::new(format!("SDO abort {}", object(device, index, sub)));
        message.values = vec![Named::text(
            "reason",
            format!("{} ({code:08X}h)", reason(code)),
        )];
        message
    }
}

/// A message that completes the bytes of an object.
fn done(device: &mut Device, text: String, (index, sub): (u16, u8), data: Vec<u8>) -> Message {
    let entry = device.entry(crate::sheet::Address::Object { index, sub });
    let entry = entry.filter(|_| is_understood(device, index));
    let value = match entry {
        Some(entry) => device.value(&entry, &data),
        None if (1..=4).contains(&data.len()) => Named::text(
            "value",
            format!("{:0digits$X}h", number(&data), digits = 2 * data.len()),
        ),
        None => Named::bytes(&data),
    };
    Message {
        text,
        values: vec![value],
        done: Some((index, sub, data)),
    }
}
