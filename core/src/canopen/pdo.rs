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

/// The transmission type: a SYNC, if the data has changed.
const ACYCLIC: u8 = 0;
/// The last transmission type that counts SYNCs; the first is 1.
const CYCLIC: u8 = 240;
/// The transmission type: a remote frame; the data is sampled with the SYNC.
const SYNC_REMOTE: u8 = 252;
/// The first of two transmission types: the event timer.
const EVENT: u8 = 254;

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
    /// Before the start.
    const INITIAL: Self;

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
    const INITIAL: Self = Self {
        tpdos: [const { Tpdo::INITIAL }; N],
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

/// A TPDO is sent while all these conditions hold. The node is operational.
pub(super) const OPERATIONAL: u8 = 1 << 0;
/// Bit 31 of the COB-ID is 0.
const VALID: u8 = 1 << 1;
/// The number of mapped objects (sub-index 0 of 1A00h and following) is not 0.
pub(super) const MAPPED: u8 = 1 << 2;
const ALL: u8 = OPERATIONAL | VALID | MAPPED;

/// One transmit PDO.
#[derive(Clone, Debug)]
pub struct Tpdo {
    /// The identifier, also while the TPDO is not sent.
    id: u16,
    /// The conditions that hold.
    conditions: u8,
    /// It answers remote frames.
    remote: bool,
    transmission_type: u8,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// The inhibit time in 100 us.
    inhibit: u16,
    /// The event timer in ms.
    event_ms: u16,
    /// An event waits for the end of the inhibit time.
    waiting: bool,
    event: Periodic,
    /// The end of the inhibit time.
    inhibited: Deadline,
    /// The frame that was sent last (type 0) or sampled with the SYNC (type 252).
    kept: Option<Frame>,
}

impl Tpdo {
    /// A TPDO before its start, without mapped objects.
    pub(super) const INITIAL: Self = Self {
        id: 0,
        conditions: 0,
        remote: false,
        transmission_type: ACYCLIC,
        syncs: 0,
        inhibit: 0,
        event_ms: 0,
        waiting: false,
        event: Periodic::OFF,
        inhibited: Deadline::NEVER,
        kept: None,
    };

    /// Resets the TPDO. Its communication parameter stays until [`configure`](Self::configure).
    fn reset(&mut self) {
        // By field: a copy of the initial state needs more flash.
        self.conditions = MAPPED;
        self.event.stop();
        self.waiting = false;
        self.syncs = 0;
        self.kept = None;
        self.remote = false;
        self.transmission_type = ACYCLIC;
        self.inhibit = 0;
        self.event_ms = 0;
        self.inhibited = Deadline::NEVER;
    }

    /// Applies its communication parameter: COB-ID, transmission type, inhibit time in 100 us, event timer in ms. Returns true if
    /// the identifier has changed.
    pub(super) fn configure(
        &mut self,
        now: Instant,
        [cob_id, transmission_type, inhibit, event_ms]: [u32; 4],
    ) -> bool {
        let trigger = (transmission_type as u8, event_ms as u16);
        if trigger != (self.transmission_type, self.event_ms) {
            (self.transmission_type, self.event_ms) = trigger;
            self.restart(now);
        }
        self.inhibit = inhibit as u16;
        self.remote = cob_id & cob_id::BIT_30 == 0;
        self.set(now, VALID, cob_id & cob_id::DISABLED == 0);
        let id = cob_id as u16 & 0x7FF;
        let readdressed = id != self.id;
        self.id = id;
        readdressed
    }

    /// Sets whether a condition holds.
    pub(super) fn set(&mut self, now: Instant, condition: u8, holds: bool) {
        let set = if holds { condition } else { 0 };
        let conditions = self.conditions & !condition | set;
        if conditions != self.conditions {
            self.conditions = conditions;
            self.restart(now);
        }
    }

    /// Begins the period and the count of SYNCs again.
    fn restart(&mut self, now: Instant) {
        self.waiting = false;
        self.syncs = 0;
        self.kept = None;
        let has_timer = self.is_sent() && self.transmission_type >= EVENT;
        let event_ms = if has_timer { self.event_ms } else { 0 };
        self.event.start(now, event_ms.into());
    }

    /// Whether all conditions hold under which it is sent.
    pub fn is_sent(&self) -> bool {
        self.conditions == ALL
    }

    /// Whether the number of mapped objects is not 0.
    pub(super) fn is_mapped(&self) -> bool {
        self.conditions & MAPPED != 0
    }

    /// The identifier.
    pub fn id(&self) -> u16 {
        self.id
    }

    /// Handles a SYNC.
    pub fn sync(&mut self) -> Reaction {
        match self.transmission_type {
            ACYCLIC => Reaction::SendChanged,
            count @ ..=CYCLIC => {
                self.syncs = self.syncs.saturating_add(1);
                if self.syncs < count {
                    return Reaction::None;
                }
                self.syncs = 0;
                Reaction::Send
            }
            SYNC_REMOTE => Reaction::Keep,
            _ => Reaction::None,
        }
    }

    /// Handles a remote frame with its identifier.
    pub fn request(&mut self, now: Instant) -> Reaction {
        if !self.remote || !self.is_sent() {
            return Reaction::None;
        }
        match self.transmission_type {
            SYNC_REMOTE => Reaction::SendKept,
            EVENT.. => {
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
    #[inline(always)] // usually there is no event, and a frame can wait
    pub fn poll(&mut self, now: Instant) -> bool {
        self.waiting |= self.event.poll(now);
        self.waiting && self.begin_inhibit_time(now)
    }

    /// Begins the inhibit time of the waiting event. Returns false if the last one has not ended.
    #[inline(never)] // rarely called
    fn begin_inhibit_time(&mut self, now: Instant) -> bool {
        if self.inhibited.is_set() && !self.inhibited.is_reached(now) {
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
