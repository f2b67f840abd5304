//! The state machine of the SDO server.
//!
//! An initiate request is accepted at any time and ends the previous transfer. The client must send each segment within
//! [`TIME_OUT`]. A server without [block transfer](super::block) aborts it with "command specifier not valid or unknown".

use super::block::Block;
use super::message::{self, Address, Announced, Request};
use crate::canopen::Abort;
use crate::canopen::feature::Feature;
use crate::time::{Deadline, Duration, Instant, millis};
use heapless::Vec;

/// The longest time that the server waits for the next segment.
pub const TIME_OUT: Duration = millis(1000);

/// Data bytes in a segment.
const SEGMENT: usize = 7;

/// The completion of a write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Written {
    /// The new value is in force.
    Done,
    /// Completed after a save; [`Server::stored`] follows.
    Storing,
}

/// The object dictionary of a server.
pub trait Objects {
    /// A reference to an object.
    type Object: Copy;
    /// A buffer for the longest text.
    type Text: Buffer;
    /// The length of the longest text that can be written, in bytes.
    const WRITABLE: usize = Self::Text::CAPACITY;

    /// Finds an object. Errors: [`Abort::NoObject`], [`Abort::NoSubIndex`].
    fn find(&self, address: Address) -> Result<Self::Object, Abort>;

    /// Checks that the object at a sub-index can be read. Errors: [`Abort::WriteOnly`], [`Abort::NoData`].
    fn check_read(&self, object: Self::Object, sub: u8) -> Result<(), Abort>;

    /// Whether it can be written.
    fn is_writable(object: Self::Object) -> bool;

    /// The size of a number in bytes; 0 for a text.
    fn size(object: Self::Object) -> u8;

    /// The least and the most bytes that can be written.
    fn lengths(object: Self::Object) -> (u32, u32) {
        match Self::size(object) {
            0 => (0, Self::WRITABLE as u32),
            size => (size.into(), size.into()),
        }
    }

    /// Handles a write of data whose `length` is other than the [size](Self::size): an object can take it nevertheless, or react to it.
    /// `abort` is the usual answer.
    fn other_length(
        &mut self,
        now: Instant,
        object: Self::Object,
        length: u32,
        abort: Abort,
    ) -> Result<(), Abort> {
        let _ = (now, object, length);
        Err(abort)
    }

    /// The number in an object. A signed number can have more bits than its type.
    fn number(&self, object: Self::Object, sub: u8) -> u32;

    /// The text in an object, or the eight bytes of a number of 64 bits.
    fn text(&self, object: Self::Object) -> Self::Text;

    /// Writes to a writable object. `data` is a text, or has the size of the number or [another length](Self::other_length) that was taken.
    /// On an error, nothing changes.
    fn write(&mut self, now: Instant, object: Self::Object, data: &[u8]) -> Result<Written, Abort>;
}

/// A buffer for the bytes of a text.
pub trait Buffer: Send + 'static {
    /// The buffer without bytes.
    const EMPTY: Self;
    /// The length of the longest text, in bytes.
    const CAPACITY: usize;

    /// The bytes that were appended.
    fn bytes(&self) -> &[u8];

    /// Appends bytes. Returns false without a change if there is no room for all of them.
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

/// The state of the transfer.
#[derive(Clone, Copy, Debug)]
#[repr(u8)] // idle is 0, so that it needs no flash in static memory
enum Stage<O> {
    /// No transfer of segments.
    Idle,
    /// The client reads a text in segments.
    Upload {
        /// The toggle bit expected next.
        toggle: bool,
        /// The number of bytes sent.
        sent: u8,
    },
    /// The client writes in segments.
    Download {
        /// The object that is written.
        object: O,
        /// The toggle bit expected next.
        toggle: bool,
        /// The announced number of bytes.
        size: Option<u32>,
    },
}

/// An SDO server for objects `O` with a buffer `B` for texts, and `K` = `Present<Block>` for block transfer.
#[derive(Clone, Debug)]
pub struct Server<O, B, K> {
    stage: Stage<O>,
    pub(super) address: Address,
    expires: Deadline,
    /// The command byte of the reply that is sent when written data is stored; 0: no data is being stored. Other transfers are
    /// possible meanwhile.
    confirmation: u8,
    /// The address of that data.
    stored: Address,
    pub(super) data: B,
    pub(super) block: K,
}

impl<O: Copy, B: Buffer, K: Feature<Block>> Server<O, B, K> {
    /// The server before the first request.
    pub const IDLE: Self = Self {
        stage: Stage::Idle,
        address: Address { index: 0, sub: 0 },
        expires: Deadline::NEVER,
        confirmation: 0,
        stored: Address { index: 0, sub: 0 },
        data: B::EMPTY,
        block: K::INITIAL,
    };

    /// Handles a request. Returns the reply, if there is one now.
    pub fn serve(
        &mut self,
        objects: &mut impl Objects<Object = O, Text = B>,
        now: Instant,
        bytes: [u8; 8],
    ) -> Option<[u8; 8]> {
        if K::PRESENT
            && !message::is_initiate(bytes)
            && let Some(reply) = self.serve_block(objects, now, bytes)
        {
            return reply.unwrap_or_else(|abort| Some(self.abort(abort)));
        }
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
            Request::Abort(address) => {
                self.abandon(address);
                Ok(None)
            }
            Request::Unsupported(address) => {
                self.begin(address);
                Err(Abort::Command)
            }
        };
        match reply {
            Ok(reply) => reply,
            Err(abort) => Some(self.abort(abort)),
        }
    }

    /// Handles the end of a save. Returns the reply to the write that waited for it.
    pub fn stored(&mut self, succeeded: bool) -> Option<[u8; 8]> {
        let confirmation = core::mem::take(&mut self.confirmation);
        match (confirmation, succeeded) {
            (0, _) => None,
            (_, false) => Some(message::abort(self.stored, Abort::Hardware)),
            (_, true) => Some(message::confirmation(confirmation, self.stored)),
        }
    }

    /// Aborts a transfer that has timed out. Returns the abort message.
    pub fn poll(&mut self, now: Instant) -> Option<[u8; 8]> {
        self.expires
            .is_reached(now)
            .then(|| self.abort(Abort::TimeOut))
    }

    /// The time at which [`poll`](Self::poll) aborts the transfer.
    pub fn deadline(&self) -> Deadline {
        self.expires
    }

    /// Ends all transfers without a message. A save continues.
    pub fn end(&mut self) {
        self.confirmation = 0;
        self.finish();
    }

    /// Handles an abort of the client with the address of this object. A client has one transfer at a time, so an abort with any
    /// address ends it. A write that waits for its save ends only if the abort has its address. Some clients send the address 0.
    /// Then both end.
    fn abandon(&mut self, address: Address) {
        let is_stored = address == self.stored;
        if self.confirmation == 0 || !is_stored {
            self.finish();
        }
        if is_stored || address == Address::default() {
            self.confirmation = 0;
        }
    }

    /// Ends the transfer, also without a message.
    pub(in crate::canopen) fn finish(&mut self) {
        self.begin(Address::default());
    }

    /// Ends the transfer and begins a new one for this address.
    pub(super) fn begin(&mut self, address: Address) {
        if let Some(block) = self.block.get_mut() {
            block.end();
        }
        self.stage = Stage::Idle;
        self.address = address;
        self.expires = Deadline::NEVER;
    }

    /// Ends the transfer with an error.
    fn abort(&mut self, abort: Abort) -> [u8; 8] {
        let reply = message::abort(self.address, abort);
        self.finish();
        reply
    }

    /// Waits for the next segment.
    fn wait(&mut self, stage: Stage<O>, now: Instant) {
        self.stage = stage;
        self.extend(now);
    }

    /// Begins the time in which the next message of the client must come.
    pub(super) fn extend(&mut self, now: Instant) {
        self.expires = Deadline::after(now, TIME_OUT);
    }

    pub(super) fn upload<T: Objects<Object = O, Text = B>>(
        &mut self,
        objects: &mut T,
        now: Instant,
        address: Address,
    ) -> Result<[u8; 8], Abort> {
        let object = objects.find(address)?;
        objects.check_read(object, address.sub)?;
        let size = T::size(object);
        if size > 0 {
            self.address = Address::default();
            let number = objects.number(object, address.sub);
            return Ok(message::number_reply(address, number, size));
        }
        self.data = objects.text(object);
        if message::is_expedited(self.data.bytes().len()) {
            self.finish();
        } else {
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
            self.finish();
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
                check_length(objects, now, object, length.into())?;
                let written = objects.write(now, object, data)?;
                Ok(self.answer(written, message::download_reply(address)))
            }
            Announced::Segmented(size) => {
                if let Some(size) = size {
                    check_length(objects, now, object, size)?;
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
        let length = self.data.bytes().len() + data.len();
        if length > T::WRITABLE || !self.data.append(data) {
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
        check_length(objects, now, object, length)?;
        let data = core::mem::replace(&mut self.data, B::EMPTY);
        let written = objects.write(now, object, data.bytes())?;
        Ok(self.answer(written, reply))
    }

    /// The reply to a write, now or after the save.
    pub(super) fn answer(&mut self, written: Written, reply: [u8; 8]) -> Option<[u8; 8]> {
        match written {
            Written::Done => {
                self.finish();
                Some(reply)
            }
            Written::Storing => {
                let [command, ..] = reply;
                self.confirmation = command;
                self.stored = self.address;
                self.finish();
                None
            }
        }
    }
}

/// Checks the length of data before it is written. An object can react to a wrong one.
pub(super) fn check_length<T: Objects>(
    objects: &mut T,
    now: Instant,
    object: T::Object,
    size: u32,
) -> Result<(), Abort> {
    let (least, most) = T::lengths(object);
    if size > most {
        objects.other_length(now, object, size, Abort::TooLong)
    } else if size < least {
        objects.other_length(now, object, size, Abort::TooShort)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
