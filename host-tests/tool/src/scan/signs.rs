//! How the frames of a bus show the nodes of a protocol. Each protocol has its own [`Signs`].

use super::listen::Frames;
use super::row::Heard;
use crate::error::RequestError;
use crate::master::{PROTOCOLS, Protocol, Target};
use plumbline::can::{CanId, Frame};
use plumbline::time::Instant;

/// How the frames of a bus show the nodes of a protocol.
#[derive(Debug)]
pub struct Signs {
    /// The node that a frame shows by a message with its address. A frame is a sign of the first protocol that takes it.
    pub node: fn(&Frame) -> Option<Sign>,
    /// No other device sends messages of this form: one of them shows the protocol.
    pub is_own: bool,
    /// Whether a node with such messages is sure, see [`Judge`].
    pub judge: for<'a> fn(&'a Bus<'a>) -> Judge<'a>,
    /// The nodes that are known by their process data alone.
    pub process_data: fn(&Bus) -> Vec<Shown>,
    /// What the user reads if the messages of several nodes tell one address: how many, the address, the serial numbers.
    pub twins: Option<fn(usize, String, String) -> RequestError>,
}

/// Whether the messages of a node are certain, so that the tool asks it without a yes; None: they are no sign of a node.
pub type Judge<'a> = Box<dyn Fn(&Seen) -> Option<bool> + 'a>;

/// A node that a message shows.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Sign {
    /// Its address.
    pub target: Target,
    /// Its serial number, if the message contains it.
    pub serial: Option<u32>,
    /// What the message tells besides: its maker.
    pub text: Option<String>,
}

impl From<Target> for Sign {
    fn from(target: Target) -> Self {
        Self {
            target,
            serial: None,
            text: None,
        }
    }
}

/// A sign, and the times of its messages.
#[derive(Debug)]
pub struct Seen {
    /// The sign.
    pub sign: Sign,
    /// The times.
    pub times: Vec<Instant>,
}

/// A node that is known by its process data.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The identifier of the process data.
    pub id: CanId,
    /// Its row.
    pub heard: Heard,
    /// Its address, if it can be asked after a yes.
    pub target: Option<Target>,
}

/// What the frames of a bus show.
#[derive(Debug)]
pub struct Bus<'a> {
    /// The frames.
    pub frames: &'a Frames,
    /// The identifiers of data frames, each once, in the order of their first frame.
    pub ids: Vec<CanId>,
    /// The nodes with messages of their own, each once, in the order of their first message.
    pub seen: Vec<Seen>,
    /// The protocols of the nodes that are sure.
    pub sure: Vec<&'static Protocol>,
}

impl<'a> Bus<'a> {
    /// The signs in the frames. None of them is sure yet.
    pub(super) fn of(frames: &'a Frames) -> Self {
        let (mut ids, mut seen) = (Vec::new(), Vec::<Seen>::new());
        for (at, frame) in frames.iter().filter(|(_, frame)| !frame.is_remote()) {
            if !ids.contains(&frame.can_id()) {
                ids.push(frame.can_id());
            }
            let mut all = PROTOCOLS.into_iter();
            let Some(sign) = all.find_map(|protocol| (protocol.signs.node)(frame)) else {
                continue;
            };
            match seen.iter_mut().find(|own| own.sign == sign) {
                Some(own) => own.times.push(*at),
                None => seen.push(Seen {
                    sign,
                    times: vec![*at],
                }),
            }
        }
        Self {
            frames,
            ids,
            seen,
            sure: Vec::new(),
        }
    }

    /// The frames with an identifier, and their times.
    pub fn with(&self, id: CanId) -> (Vec<Instant>, Vec<&'a Frame>) {
        let own = self.frames.iter().filter(|(_, own)| own.can_id() == id);
        own.map(|(at, frame)| (*at, frame)).unzip()
    }

    /// Whether all frames have 11 bits and identifiers of a protocol.
    pub fn all_are(&self, is_own: impl Fn(u16) -> bool) -> bool {
        let mut ids = self.frames.iter().map(|(_, frame)| frame.can_id().bits());
        ids.all(|id| u16::try_from(id).is_ok_and(|id| id <= 0x7FF && is_own(id)))
    }

    /// Whether a message is a sign of this protocol.
    pub fn has(&self, protocol: &Protocol) -> bool {
        let mut seen = self.seen.iter();
        seen.any(|seen| seen.sign.target.protocol() == protocol)
    }

    /// Whether a message that no other device sends is a sign of another protocol.
    pub fn has_other(&self, protocol: &Protocol) -> bool {
        let mut seen = self.seen.iter().map(|seen| seen.sign.target.protocol());
        seen.any(|own| own != protocol && own.signs.is_own)
    }

    /// Whether the bus has another protocol for sure.
    pub fn is_other(&self, protocol: &Protocol) -> bool {
        self.sure.iter().any(|own| *own != protocol)
    }
}

/// At least two data frames, all with the same length.
pub fn is_steady(frames: &[&Frame]) -> bool {
    let is_same = |frame: &&Frame| !frame.is_remote() && frame.dlc() == frames[0].dlc();
    frames.len() >= 2 && frames.iter().all(is_same)
}
