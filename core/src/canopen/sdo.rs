//! The SDO server (CiA 301, 7.2.4): expedited and segmented transfers, one at a time.
//!
//! A request to begin a transfer is served at any time and ends the one before. The client has [`TIME_OUT`] for each segment.
//! Block transfers are refused, as CiA 301 allows, with "command unknown".

use super::abort::Abort;
use super::device::Device;
use super::dictionary::{Found, Home, Rule, find};
use super::model::{Model, TEXT_MAX};
use super::wire::{self, Address, Announced, Request};
use crate::time::{Duration, Instant, after, millis};
use heapless::Vec;

/// How long the server waits for the next segment.
pub const TIME_OUT: Duration = millis(1000);

/// Data bytes in a segment.
const SEGMENT: usize = 7;

/// How far the transfer is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Stage {
    /// There is none.
    #[default]
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
        rule: &'static Rule,
        /// The toggle bit expected next.
        toggle: bool,
        /// The announced number of bytes.
        size: Option<u32>,
    },
    /// What was written is being stored; the reply comes when the memory holds it.
    Storing,
}

/// The transfer.
#[derive(Clone, Debug, Default)]
pub(super) struct Transfer {
    pub stage: Stage,
    pub address: Address,
    pub expires: Option<Instant>,
    /// The reply to be sent when what was written is stored.
    pub reply: [u8; 8],
    data: Vec<u8, TEXT_MAX>,
}

impl Transfer {
    /// There is no transfer any more.
    pub fn end(&mut self) {
        self.stage = Stage::Idle;
        self.address = Address::default();
        self.expires = None;
    }

    fn begin(&mut self, stage: Stage, now: Instant) {
        self.stage = stage;
        self.expires = Some(after(now, TIME_OUT));
    }
}

/// When a write is done.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Written {
    /// Now.
    Done,
    /// When the memory holds it.
    Storing,
}

impl<M: Model> Device<M> {
    /// Serves a request.
    pub(super) fn serve(&mut self, now: Instant, bytes: [u8; 8]) {
        let reply = match Request::parse(bytes) {
            Request::Upload(address) => {
                self.transfer.end();
                self.transfer.address = address;
                self.upload(now, address).map(Some)
            }
            Request::Download(address, announced) => {
                self.transfer.end();
                self.transfer.address = address;
                self.download(now, address, announced)
            }
            Request::UploadSegment { toggle } => self.upload_segment(now, toggle).map(Some),
            Request::DownloadSegment {
                toggle,
                length,
                last,
            } => {
                let [_, data @ ..] = &bytes;
                let data = data.get(..length.into()).unwrap_or(data);
                self.download_segment(now, toggle, data, last)
            }
            Request::Abort => {
                self.transfer.end();
                Ok(None)
            }
            Request::Unsupported(address) => {
                self.transfer.end();
                self.transfer.address = address;
                Err(Abort::Command)
            }
        };
        match reply {
            Ok(Some(reply)) => {
                if matches!(self.transfer.stage, Stage::Idle) {
                    self.transfer.end();
                }
                self.send_sdo(&reply);
            }
            Ok(None) => {}
            Err(abort) => self.abort_transfer(abort),
        }
    }

    /// Ends the transfer and tells the client why.
    pub(super) fn abort_transfer(&mut self, abort: Abort) {
        let reply = wire::abort(self.transfer.address, abort);
        self.transfer.end();
        self.send_sdo(&reply);
    }

    fn lookup(address: Address) -> Result<&'static Rule, Abort> {
        match find(M::RULES, address.index, address.sub) {
            Found::Row(rule) => Ok(rule),
            Found::NoSubIndex => Err(Abort::NoSubIndex),
            Found::NoObject => Err(Abort::NoObject),
        }
    }

    fn upload(&mut self, now: Instant, address: Address) -> Result<[u8; 8], Abort> {
        let rule = Self::lookup(address)?;
        if !rule.is_readable() {
            return Err(Abort::WriteOnly);
        }
        let size = rule.data_type().size();
        if size > 0 {
            let number = self.number(rule, address.sub);
            return Ok(wire::number_reply(address, number, size));
        }
        self.transfer.data = self.text(rule);
        if self.transfer.data.len() > 4 {
            let stage = Stage::Upload {
                toggle: false,
                sent: 0,
            };
            self.transfer.begin(stage, now);
        }
        Ok(wire::upload_reply(address, &self.transfer.data))
    }

    fn upload_segment(&mut self, now: Instant, toggle: bool) -> Result<[u8; 8], Abort> {
        let Stage::Upload {
            toggle: expected,
            sent,
        } = self.transfer.stage
        else {
            return Err(Abort::Command);
        };
        if toggle != expected {
            return Err(Abort::Toggle);
        }
        let rest = self.transfer.data.get(sent.into()..).unwrap_or(&[]);
        let last = rest.len() <= SEGMENT;
        let reply = wire::upload_segment(toggle, rest.get(..SEGMENT).unwrap_or(rest), last);
        if last {
            self.transfer.end();
        } else {
            let stage = Stage::Upload {
                toggle: !toggle,
                sent: sent + SEGMENT as u8,
            };
            self.transfer.begin(stage, now);
        }
        Ok(reply)
    }

    fn download(
        &mut self,
        now: Instant,
        address: Address,
        announced: Announced,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let rule = Self::lookup(address)?;
        if !rule.is_writable() {
            return Err(Abort::ReadOnly);
        }
        match announced {
            Announced::Expedited(data, length) => {
                let own = match rule.data_type().size() {
                    0 => 4,
                    size => size,
                };
                let length = usize::from(length.unwrap_or(own));
                let written = self.write(now, rule, data.get(..length).unwrap_or(&data))?;
                Ok(self.answer_write(written, wire::download_reply(address)))
            }
            Announced::Segmented(size) => {
                if let Some(size) = size {
                    fits(rule, size)?;
                }
                self.transfer.data.clear();
                let stage = Stage::Download {
                    rule,
                    toggle: false,
                    size,
                };
                self.transfer.begin(stage, now);
                Ok(Some(wire::download_reply(address)))
            }
        }
    }

    fn download_segment(
        &mut self,
        now: Instant,
        toggle: bool,
        data: &[u8],
        last: bool,
    ) -> Result<Option<[u8; 8]>, Abort> {
        let Stage::Download {
            rule,
            toggle: expected,
            size,
        } = self.transfer.stage
        else {
            return Err(Abort::Command);
        };
        if toggle != expected {
            return Err(Abort::Toggle);
        }
        if self.transfer.data.extend_from_slice(data).is_err() {
            return Err(Abort::TooLong);
        }
        let reply = wire::download_segment_reply(toggle);
        if !last {
            let toggle = !toggle;
            let stage = Stage::Download { rule, toggle, size };
            self.transfer.begin(stage, now);
            return Ok(Some(reply));
        }
        let length = self.transfer.data.len() as u32;
        if size.is_some_and(|size| size != length) {
            return Err(Abort::Length);
        }
        let data = core::mem::take(&mut self.transfer.data);
        let written = self.write(now, rule, &data)?;
        Ok(self.answer_write(written, reply))
    }

    /// The reply to a write, now or when it is stored.
    fn answer_write(&mut self, written: Written, reply: [u8; 8]) -> Option<[u8; 8]> {
        match written {
            Written::Done => {
                self.transfer.end();
                Some(reply)
            }
            Written::Storing => {
                self.transfer.stage = Stage::Storing;
                self.transfer.expires = None;
                self.transfer.reply = reply;
                None
            }
        }
    }
}

/// Whether data of `size` bytes can be written to an object.
pub(super) fn fits(rule: &Rule, size: u32) -> Result<(), Abort> {
    let (least, most) = match rule.home {
        Home::Key => (0, TEXT_MAX as u32),
        _ => (
            rule.data_type().size().into(),
            rule.data_type().size().into(),
        ),
    };
    if size > most {
        Err(Abort::TooLong)
    } else if size < least {
        Err(Abort::TooShort)
    } else {
        Ok(())
    }
}
