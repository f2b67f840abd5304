//! The state machine of the SDO server.
//!
//! A request to begin a transfer is served at any time and ends the one before. The client has [`TIME_OUT`] for each segment.
//! Block transfers are refused, as CiA 301 allows, with "command unknown".

use super::message::{self, Address, Announced, Request};
use crate::canopen::Abort;
use crate::time::{Duration, Instant, after, is_due, millis};
use heapless::Vec;

/// How long the server waits for the next segment.
pub const TIME_OUT: Duration = millis(1000);

/// Data bytes in a segment.
const SEGMENT: usize = 7;

/// When a write is done.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Written {
    /// Now.
    Done,
    /// When the memory holds it; [`Server::stored`] follows.
    Storing,
}

/// The objects that a server gives access to.
pub trait Objects {
    /// An object that was found.
    type Object: Copy;
    /// Room for the longest text.
    type Text: Buffer;

    /// Looks an object up: there is none, or not this sub-index of it.
    fn find(&self, address: Address) -> Result<Self::Object, Abort>;

    /// Whether it can be read.
    fn is_readable(object: Self::Object) -> bool;

    /// Whether it can be written.
    fn is_writable(object: Self::Object) -> bool;

    /// The size of a number in bytes; 0 for a text.
    fn size(object: Self::Object) -> u8;

    /// The number in an object; a signed one may have more bits than its type.
    fn number(&self, object: Self::Object, sub: u8) -> u32;

    /// The text in an object.
    fn text(&self, object: Self::Object) -> Self::Text;

    /// Writes to an object that can be written: as many bytes as a number has, or a text. On an error nothing has changed.
    fn write(&mut self, now: Instant, object: Self::Object, data: &[u8]) -> Result<Written, Abort>;
}

/// The bytes of a text on its way.
pub trait Buffer {
    /// No text.
    const EMPTY: Self;
    /// The longest text.
    const CAPACITY: usize;

    /// The bytes.
    fn bytes(&self) -> &[u8];

    /// Appends bytes; false, and nothing has changed, when there is no room for all of them.
    fn append(&mut self, bytes: &[u8]) -> bool;
}

impl<const N: usize> Buffer for Vec<u8, N> {
    const EMPTY: Self = Self::new();
    const CAPACITY: usize = N;

    fn bytes(&self) -> &[u8] {
        self
    }

    fn append(&mut self, bytes: &[u8]) -> bool {
        self.extend_from_slice(bytes).is_ok()
    }
}

/// How far the transfer is.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // idle is 0, as static memory wants it
enum Stage<O> {
    /// There is none.
    Idle,
    /// The client reads segments.
    Upload {
        /// The toggle bit expected next.
        toggle: bool,
        /// Bytes sent.
        sent: u8,
    },
    /// The client writes segments.
    Download {
        /// What is written to.
        object: O,
        /// The toggle bit expected next.
        toggle: bool,
        /// The announced number of bytes.
        size: Option<u32>,
    },
    /// What was written is being stored; the reply comes when the memory holds it.
    Storing,
}

/// An SDO server for objects `O` with a buffer `B` for texts.
#[derive(Clone, Debug)]
pub struct Server<O, B> {
    stage: Stage<O>,
    address: Address,
    expires: Option<Instant>,
    /// The reply to be sent when what was written is stored.
    reply: [u8; 8],
    data: B,
}

impl<O: Copy, B: Buffer> Server<O, B> {
    /// No transfer.
    pub const IDLE: Self = Self {
        stage: Stage::Idle,
        address: Address { index: 0, sub: 0 },
        expires: None,
        reply: [0; 8],
        data: B::EMPTY,
    };

    /// Serves a request; returns the reply, if there is one now.
    pub fn serve(
        &mut self,
        objects: &mut impl Objects<Object = O, Text = B>,
        now: Instant,
        bytes: [u8; 8],
    ) -> Option<[u8; 8]> {
        let reply = match Request::parse(bytes) {
            Request::Upload(address) => {
                self.begin(address);
                self.upload(objects, now, address).map(Some)
            }
            Request::Download(address, announced) => {
                self.begin(address);
                self.download(objects, now, address, announced)
            }
            Request::UploadSegment { toggle } => self.upload_segment(now, toggle).map(Some),
            Request::DownloadSegment {
                toggle,
                length,
                last,
            } => {
                let [_, data @ ..] = &bytes;
                let data = data.get(..length.into()).unwrap_or(data);
                self.download_segment(objects, now, toggle, data, last)
            }
            Request::Abort => {
                self.end();
                Ok(None)
            }
            Request::Unsupported(address) => {
                self.begin(address);
                Err(Abort::Command)
            }
        };
        match reply {
            Ok(reply) => {
                if reply.is_some() && matches!(self.stage, Stage::Idle) {
                    self.end();
                }
                reply
            }
            Err(abort) => Some(self.abort(abort)),
        }
    }

    /// The memory has answered; returns the reply to the write that waited for it.
    pub fn stored(&mut self, succeeded: bool) -> Option<[u8; 8]> {
        if !matches!(self.stage, Stage::Storing) {
            return None;
        }
        if !succeeded {
            return Some(self.abort(Abort::Hardware));
        }
        self.end();
        Some(self.reply)
    }

    /// Ends a transfer whose client is too slow; returns the abort.
    pub fn poll(&mut self, now: Instant) -> Option<[u8; 8]> {
        is_due(&self.expires, now).then(|| self.abort(Abort::TimeOut))
    }

    /// When [`poll`](Self::poll) ends the transfer.
    pub fn deadline(&self) -> Option<Instant> {
        self.expires
    }

    /// Ends the transfer without a word.
    pub fn end(&mut self) {
        self.begin(Address::default());
    }

    /// Ends the transfer and begins one for this object.
    fn begin(&mut self, address: Address) {
        self.stage = Stage::Idle;
        self.address = address;
        self.expires = None;
    }

    /// Ends the transfer with an error.
    fn abort(&mut self, abort: Abort) -> [u8; 8] {
        let reply = message::abort(self.address, abort);
        self.end();
        reply
    }

    /// Waits for the next segment.
    fn wait(&mut self, stage: Stage<O>, now: Instant) {
        self.stage = stage;
        self.expires = Some(after(now, TIME_OUT));
    }

    fn upload<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        address: Address,
    ) -> Result<[u8; 8], Abort> {
        let object = objects.find(address)?;
        if !T::is_readable(object) {
            return Err(Abort::WriteOnly);
        }
        let size = T::size(object);
        if size > 0 {
            let number = objects.number(object, address.sub);
            return Ok(message::number_reply(address, number, size));
        }
        self.data = objects.text(object);
        if self.data.bytes().len() > 4 {
            let stage = Stage::Upload {
                toggle: false,
                sent: 0,
            };
            self.wait(stage, now);
        }
        Ok(message::upload_reply(address, self.data.bytes()))
    }

    fn upload_segment(&mut self, now: Instant, toggle: bool) -> Result<[u8; 8], Abort> {
        let Stage::Upload {
            toggle: expected,
            sent,
        } = self.stage
        else {
            return Err(Abort::Command);
        };
        if toggle != expected {
            return Err(Abort::Toggle);
        }
        let rest = self.data.bytes().get(sent.into()..).unwrap_or(&[]);
        let last = rest.len() <= SEGMENT;
        let reply = message::upload_segment(toggle, rest.get(..SEGMENT).unwrap_or(rest), last);
        if last {
            self.end();
        } else {
            let stage = Stage::Upload {
                toggle: !toggle,
                sent: sent + SEGMENT as u8,
            };
            self.wait(stage, now);
        }
        Ok(reply)
    }

    fn download<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        address: Address,
        announced: Announced,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let object = objects.find(address)?;
        if !T::is_writable(object) {
            return Err(Abort::ReadOnly);
        }
        match announced {
            Announced::Expedited(data, length) => {
                let own = match T::size(object) {
                    0 => 4,
                    size => size,
                };
                let length = length.unwrap_or(own);
                let data = data.get(..length.into()).unwrap_or(&data);
                fits::<T>(object, length.into())?;
                let written = objects.write(now, object, data)?;
                Ok(self.answer(written, message::download_reply(address)))
            }
            Announced::Segmented(size) => {
                if let Some(size) = size {
                    fits::<T>(object, size)?;
                }
                self.data = B::EMPTY;
                let stage = Stage::Download {
                    object,
                    toggle: false,
                    size,
                };
                self.wait(stage, now);
                Ok(Some(message::download_reply(address)))
            }
        }
    }

    fn download_segment<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        toggle: bool,
        data: &[u8],
        last: bool,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let Stage::Download {
            object,
            toggle: expected,
            size,
        } = self.stage
        else {
            return Err(Abort::Command);
        };
        if toggle != expected {
            return Err(Abort::Toggle);
        }
        if !self.data.append(data) {
            return Err(Abort::TooLong);
        }
        let reply = message::download_segment_reply(toggle);
        if !last {
            let stage = Stage::Download {
                object,
                toggle: !toggle,
                size,
            };
            self.wait(stage, now);
            return Ok(Some(reply));
        }
        let length = self.data.bytes().len() as u32;
        if size.is_some_and(|size| size != length) {
            return Err(Abort::Length);
        }
        fits::<T>(object, length)?;
        let data = core::mem::replace(&mut self.data, B::EMPTY);
        let written = objects.write(now, object, data.bytes())?;
        Ok(self.answer(written, reply))
    }

    /// The reply to a write, now or when it is stored.
    fn answer(&mut self, written: Written, reply: [u8; 8]) -> Option<[u8; 8]> {
        match written {
            Written::Done => {
                self.end();
                Some(reply)
            }
            Written::Storing => {
                self.stage = Stage::Storing;
                self.expires = None;
                self.reply = reply;
                None
            }
        }
    }
}

/// Whether data of `size` bytes can be written to an object.
fn fits<T: Objects>(object: T::Object, size: u32) -> Result<(), Abort> {
    let (least, most) = match T::size(object) {
        0 => (0, T::Text::CAPACITY as u32),
        size => (size.into(), size.into()),
    };
    if size > most {
        Err(Abort::TooLong)
    } else if size < least {
        Err(Abort::TooShort)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
