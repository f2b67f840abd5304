//! Transmit PDOs and their triggers (CiA 301, 7.2.2 and 7.5.2.37).
//!
//! | type      | sent                                                                        |
//! |-----------|-----------------------------------------------------------------------------|
//! | 0         | with the SYNC, if the data has changed since the last transmission          |
//! | 1 to 240  | with each n-th SYNC                                                         |
//! | 252       | on a remote frame, with the data of the last SYNC                           |
//! | 253       | on a remote frame                                                           |
//! | 254, 255  | when the event timer expires, at most once in the inhibit time              |
//!
//! Each type answers remote frames, unless bit 30 of the COB-ID is set.

use super::cob_id;
use super::row::Row;
use super::timer::Periodic;
use crate::can::Frame;
use crate::param::Ranges;
use crate::time::{Deadline, Duration, Instant};

/// The transmission types of a TPDO; 241 to 251 are reserved.
pub const TRANSMISSION_TYPES: Ranges = Ranges {
    text: "",
    ignored_bits: 0,
    ranges: &[(0, 240), (252, 255)],
};

/// The trigger of a TPDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Type {
    /// A SYNC, if the data has changed.
    Acyclic,
    /// Each n-th SYNC.
    Cyclic(u8),
    /// A remote frame; the data is sampled with the SYNC.
    SyncRemote,
    /// A remote frame.
    Remote,
    /// The event timer.
    Event,
}

/// The reaction of a TPDO to a SYNC or a remote frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// Nothing.
    None,
    /// Send the present data.
    Send,
    /// Send the present data if it differs from the data sent last.
    SendChanged,
    /// Keep the present data with [`Tpdo::keep`].
    Keep,
    /// Send the kept data.
    SendKept,
}

/// A mapped object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entry {
    pub(super) row: &'static Row,
    pub(super) sub: u8,
    /// The size in bytes.
    pub(super) size: u8,
}

/// The TPDOs of a product and their mapped objects.
///
/// [`TpdoArray`] is the implementation. The number of TPDOs and of mapped objects is checked against the dictionary at compile
/// time.
pub trait Tpdos {
    /// The number of TPDOs.
    const COUNT: usize;
    /// The maximum number of mapped objects of a TPDO.
    const ENTRIES: usize;
    /// All of them disabled.
    const DISABLED: Self;

    /// The TPDOs.
    fn all(&self) -> &[Tpdo];
    /// The TPDOs, to change them.
    fn all_mut(&mut self) -> &mut [Tpdo];
    /// The mapped objects of a TPDO.
    fn mapping(&self, number: usize) -> &[Entry];
    /// Resets all TPDOs and maps the objects that `entry` returns for the number of a TPDO and a sub-index from 1 on.
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
                // There is always room: the mapping is checked at compile time.
                let _ = mapping.push(entry);
            }
        }
    }
}

/// The communication parameter of a TPDO in the coding of its objects (1800h and following).
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
    /// The identifier; None if the TPDO is disabled.
    id: Option<u16>,
    remote: bool,
    kind: Type,
    /// The inhibit time in 100 us.
    inhibit: u32,
    event_ms: u32,
    event: Periodic,
    /// The end of the inhibit time.
    inhibited: Deadline,
    /// An event waits for the end of the inhibit time.
    waiting: bool,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// The frame that was sent last (type 0) or sampled with the SYNC (type 252).
    kept: Option<Frame>,
    running: bool,
}

impl Tpdo {
    /// A disabled TPDO without mapped objects.
    pub(super) const DISABLED: Self = Self {
        id: None,
        remote: false,
        kind: Type::Acyclic,
        inhibit: 0,
        event_ms: 0,
        event: Periodic::OFF,
        inhibited: Deadline::NEVER,
        waiting: false,
        syncs: 0,
        kept: None,
        running: false,
    };

    /// Resets the TPDO. Its communication parameter stays until [`configure`](Self::configure).
    fn reset(&mut self) {
        self.stop();
        self.inhibited = Deadline::NEVER;
    }

    /// Applies its communication parameter. Returns true if the identifier has changed.
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
        self.inhibit = parameter.inhibit_time;
        self.kind = kind;
        self.event_ms = parameter.event_timer;
        if changed && self.running {
            self.start(now);
        }
        readdressed
    }

    /// Handles the change to operational.
    pub fn start(&mut self, now: Instant) {
        self.stop();
        self.running = true;
        if self.kind == Type::Event {
            self.event.start(now, self.event_ms);
        }
    }

    /// Handles the end of operational.
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

    /// Handles a SYNC in operational.
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

    /// Handles a remote frame with its identifier in operational.
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

    /// Keeps a frame. Returns false if it is equal to the frame kept before.
    pub fn keep(&mut self, frame: &Frame) -> bool {
        let changed = self.kept.as_ref() != Some(frame);
        if changed {
            self.kept = Some(*frame);
        }
        changed
    }

    /// The kept frame.
    pub fn kept(&self) -> Option<Frame> {
        self.kept
    }

    /// Returns true if the TPDO must be sent now: its event timer has expired, or the inhibit time that delayed an event has
    /// ended.
    pub fn poll(&mut self, now: Instant) -> bool {
        self.waiting |= self.event.poll(now);
        if !self.waiting || (self.inhibited.is_set() && !self.inhibited.is_reached(now)) {
            return false;
        }
        self.waiting = false;
        self.inhibited = if self.inhibit > 0 {
            let inhibit = u64::from(self.inhibit) * 100;
            Deadline::after(now, Duration::from_ticks(inhibit))
        } else {
            Deadline::NEVER
        };
        true
    }

    /// Adds the time at which [`poll`](Self::poll) can become true.
    pub fn consider(&self, next: &mut Deadline) {
        if self.waiting {
            next.consider(self.inhibited);
        }
        next.consider(self.event.deadline());
    }
}
