//! Transmit PDOs: when they are sent (CiA 301, 7.2.2 and 7.5.2.37).
//!
//! | type      | sent                                                                        |
//! |-----------|-----------------------------------------------------------------------------|
//! | 0         | with the SYNC, when the data have changed since they were sent              |
//! | 1 to 240  | with every n-th SYNC                                                        |
//! | 252       | on a remote frame; the data are those of the last SYNC                      |
//! | 253       | on a remote frame                                                           |
//! | 254, 255  | when the event timer expires, at most once in the inhibit time              |
//!
//! A remote frame is answered in every type, unless bit 30 of the COB-ID is set.

use super::cob_id;
use super::dictionary::Row;
use super::timer::Periodic;
use crate::can::Frame;
use crate::param::Ranges;
use crate::time::{Duration, Earliest, Instant, after, is_due};

/// The transmission types of a TPDO; 241 to 251 are reserved.
pub const TRANSMISSION_TYPES: Ranges = Ranges {
    text: "",
    ignored_bits: 0,
    ranges: &[(0, 240), (252, 255)],
};

/// When a TPDO is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Type {
    /// With a SYNC, when the data have changed.
    Acyclic,
    /// With every so-many-th SYNC.
    Cyclic(u8),
    /// On a remote frame, sampled with the SYNC.
    SyncRemote,
    /// On a remote frame.
    Remote,
    /// When the event timer expires.
    Event,
}

/// What a SYNC or remote frame makes a TPDO do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// Nothing.
    None,
    /// Send the present data.
    Send,
    /// Send the present data if they differ from what was sent last.
    SendChanged,
    /// Keep the present data with [`Tpdo::keep`].
    Keep,
    /// Send what was kept.
    SendKept,
}

/// An object that a TPDO carries.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entry {
    pub(super) row: &'static Row,
    pub(super) sub: u8,
    /// In bytes.
    pub(super) size: u8,
}

/// The TPDOs of a product, and the objects that they carry.
///
/// [`TpdoArray`] is the implementation; the number of TPDOs and the most objects in one are checked against the dictionary at
/// compile time.
pub trait Tpdos {
    /// How many there are.
    const COUNT: usize;
    /// The most objects that one of them carries.
    const ENTRIES: usize;
    /// All of them disabled.
    const DISABLED: Self;

    /// The TPDOs.
    fn all(&self) -> &[Tpdo];
    /// The TPDOs, to change them.
    fn all_mut(&mut self) -> &mut [Tpdo];
    /// The objects that a TPDO carries.
    fn mapping(&self, number: usize) -> &[Entry];
    /// Starts all TPDOs anew, with the objects that `entry` returns for the number of a TPDO and a sub-index from 1 on.
    fn map(&mut self, entry: impl Fn(u16, u8) -> Option<Entry>);
}

/// `N` TPDOs with at most `E` objects each.
#[derive(Debug)]
pub struct TpdoArray<const N: usize, const E: usize> {
    tpdos: [Tpdo; N],
    mappings: [heapless::Vec<Entry, E>; N],
}

impl<const N: usize, const E: usize> Tpdos for TpdoArray<N, E> {
    const COUNT: usize = N;
    const ENTRIES: usize = E;
    const DISABLED: Self = Self {
        tpdos: [const { Tpdo::DISABLED }; N],
        mappings: [const { heapless::Vec::new() }; N],
    };

    fn all(&self) -> &[Tpdo] {
        &self.tpdos
    }

    fn all_mut(&mut self) -> &mut [Tpdo] {
        &mut self.tpdos
    }

    fn mapping(&self, number: usize) -> &[Entry] {
        self.mappings.get(number).map_or(&[], |mapping| mapping)
    }

    fn map(&mut self, entry: impl Fn(u16, u8) -> Option<Entry>) {
        for tpdo in &mut self.tpdos {
            tpdo.reset();
        }
        for (number, mapping) in (0..).zip(&mut self.mappings) {
            mapping.clear();
            for sub in 1.. {
                let Some(entry) = entry(number, sub) else {
                    break;
                };
                // It fits: the mapping is checked at compile time.
                let _ = mapping.push(entry);
            }
        }
    }
}

/// The communication parameter of a TPDO, as its objects have it (1800h and on).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Communication {
    /// Sub-index 1.
    pub cob_id: u32,
    /// Sub-index 2.
    pub transmission_type: u32,
    /// Sub-index 3, in 100 us.
    pub inhibit_time: u32,
    /// Sub-index 5, in ms.
    pub event_timer: u32,
}

/// One transmit PDO.
#[derive(Clone, Debug)]
pub struct Tpdo {
    /// The identifier; None: disabled.
    id: Option<u16>,
    remote: bool,
    kind: Type,
    /// None: 0.
    inhibit: Option<Duration>,
    event_ms: u32,
    event: Periodic,
    /// The end of the inhibit time.
    inhibited: Option<Instant>,
    /// An event waits for the end of the inhibit time.
    waiting: bool,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// What was sent last (type 0) or sampled with the SYNC (type 252).
    kept: Option<Frame>,
    running: bool,
}

impl Tpdo {
    /// A TPDO that does not exist on the bus and carries nothing.
    pub(super) const DISABLED: Self = Self {
        id: None,
        remote: false,
        kind: Type::Acyclic,
        inhibit: None,
        event_ms: 0,
        event: Periodic::OFF,
        inhibited: None,
        waiting: false,
        syncs: 0,
        kept: None,
        running: false,
    };

    /// Starts anew; the identifier stays until [`configure`](Self::configure).
    fn reset(&mut self) {
        *self = Self {
            id: self.id,
            ..Self::DISABLED
        };
    }

    /// Takes its communication parameter over; true when the identifier has changed.
    pub(super) fn configure(&mut self, now: Instant, parameter: Communication) -> bool {
        let id = cob_id::in_use(parameter.cob_id);
        let readdressed = id != self.id;
        self.id = id;
        self.remote = parameter.cob_id & cob_id::BIT_30 == 0;
        let kind = match parameter.transmission_type {
            0 => Type::Acyclic,
            252 => Type::SyncRemote,
            253 => Type::Remote,
            254.. => Type::Event,
            count => Type::Cyclic(count as u8),
        };
        let changed = (kind, parameter.event_timer) != (self.kind, self.event_ms);
        let inhibit = u64::from(parameter.inhibit_time) * 100;
        self.inhibit = (inhibit > 0).then(|| Duration::from_ticks(inhibit));
        self.kind = kind;
        self.event_ms = parameter.event_timer;
        if changed && self.running {
            self.start(now);
        }
        readdressed
    }

    /// The node has become operational.
    pub fn start(&mut self, now: Instant) {
        self.stop();
        self.running = true;
        if self.kind == Type::Event {
            self.event.start(now, self.event_ms);
        }
    }

    /// The node is no longer operational.
    pub fn stop(&mut self) {
        self.running = false;
        self.event.stop();
        self.waiting = false;
        self.syncs = 0;
        self.kept = None;
    }

    /// The identifier; None while the TPDO is disabled.
    pub fn id(&self) -> Option<u16> {
        self.id
    }

    /// A SYNC has come in operational.
    pub fn sync(&mut self) -> Reaction {
        match self.kind {
            Type::Acyclic => Reaction::SendChanged,
            Type::Cyclic(count) => {
                self.syncs = self.syncs.saturating_add(1);
                if self.syncs < count {
                    return Reaction::None;
                }
                self.syncs = 0;
                Reaction::Send
            }
            Type::SyncRemote => Reaction::Keep,
            Type::Remote | Type::Event => Reaction::None,
        }
    }

    /// A remote frame with its identifier has come in operational.
    pub fn request(&mut self, now: Instant) -> Reaction {
        if !self.remote {
            return Reaction::None;
        }
        match self.kind {
            Type::SyncRemote => Reaction::SendKept,
            Type::Event => {
                self.waiting = true;
                if self.poll(now) {
                    Reaction::Send
                } else {
                    Reaction::None
                }
            }
            _ => Reaction::Send,
        }
    }

    /// Keeps the data of a frame; false when they are those that are kept already.
    pub fn keep(&mut self, frame: &Frame) -> bool {
        let changed = self.kept.as_ref() != Some(frame);
        if changed {
            self.kept = Some(*frame);
        }
        changed
    }

    /// What is kept.
    pub fn kept(&self) -> Option<Frame> {
        self.kept
    }

    /// True when the TPDO is to be sent now, because of its timer or of an event that the inhibit time has held back.
    pub fn poll(&mut self, now: Instant) -> bool {
        self.waiting |= self.event.poll(now);
        if !self.waiting || (self.inhibited.is_some() && !is_due(&self.inhibited, now)) {
            return false;
        }
        self.waiting = false;
        self.inhibited = self.inhibit.map(|inhibit| after(now, inhibit));
        true
    }

    /// Adds the time at which [`poll`](Self::poll) can become true.
    pub fn consider(&self, next: &mut Earliest) {
        if self.waiting {
            next.consider(self.inhibited);
        }
        next.consider(self.event.deadline());
    }
}
