//! Transmit PDOs and their triggers (CiA 301, 7.2.2 and 7.5.2.37).
//!
//! | type      | sent                                                                        |
//! |-----------|-----------------------------------------------------------------------------|
//! | 0         | with the SYNC, if the data has changed since the last transmission          |
//! | 1 to 240  | with each n-th SYNC                                                         |
//! | 252       | on a remote frame, with the data of the last SYNC                           |
//! | 253       | on a remote frame                                                           |
//! | 254, 255  | when the event timer expires, at most once in the inhibit time              |
//! | 255       | also when the data has changed, if the [`Triggers`] of the product say so   |
//!
//! Each type answers remote frames, unless bit 30 of the COB-ID is set.

use super::cob_id;
use crate::can::Frame;
use crate::param::Ranges;
use crate::time::{Deadline, Duration, Instant, Periodic};

/// The transmission types of a TPDO; 241 to 251 are reserved.
pub const TRANSMISSION_TYPES: Ranges = Ranges {
    text: "",
    ignored_bits: 0,
    ranges: &[(0, 240), (252, 255)],
};

/// The transmission types of a TPDO without type 0.
pub const TRANSMISSION_TYPES_FROM_1: Ranges = Ranges {
    ranges: &[(1, 240), (252, 255)],
    ..TRANSMISSION_TYPES
};

/// The triggers of transmission types 254 and 255, besides those that all products have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Triggers {
    /// Type 255 is also sent when its data has changed since the last transmission, and once at the beginning of operational.
    pub changes: bool,
    /// Each transmission restarts the event timer. A new event timer acts after the running period, but 0 stops it at once.
    pub restarts_timer: bool,
}

impl Triggers {
    /// Only the event timer, which a transmission on a remote frame does not shift. A new event timer acts at once.
    pub const TIMER: Self = Self {
        changes: false,
        restarts_timer: false,
    };
}

/// The transmission type: a SYNC, if the data has changed.
const ACYCLIC: u8 = 0;
/// The last transmission type that counts SYNCs; the first is 1.
const CYCLIC: u8 = 240;
/// The transmission type: a remote frame; the data is sampled with the SYNC.
const SYNC_REMOTE: u8 = 252;
/// The first of two transmission types: the event timer.
const EVENT: u8 = 254;
/// The second of two transmission types: the event timer, and changes by [`Triggers::changes`].
const CHANGE: u8 = 255;

/// The reaction of a TPDO to a SYNC or a remote frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// The TPDO is not sent.
    None,
    /// Send the present data now.
    Send,
    /// Send the present data if it differs from the data sent last.
    SendChanged,
    /// Keep the present data with [`Tpdo::keep`].
    Keep,
    /// Send the data that an earlier SYNC kept.
    SendKept,
}

/// The kind of contents of a mapped object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Source {
    Value,
    Parameter,
    /// An own object of the product.
    Own,
}

/// A mapped object. It is resolved when it is mapped, so that a SYNC needs no search in the dictionary.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entry {
    /// In a fixed mapping, all objects are published values.
    pub(super) source: Source,
    /// The id of the value or of the parameter, or the place of the own object.
    pub(super) id: u8,
    /// The size of the object in bytes.
    pub(super) size: u8,
}

/// The mapped objects of one TPDO: at least one byte each, so 8 at most.
pub(super) type Entries = heapless::Vec<Entry, 8>;

/// The TPDOs of a product and their mapped objects.
///
/// [`TpdoArray`] is the implementation. The number of TPDOs and of mapped objects is checked against the dictionary at compile
/// time.
pub trait Tpdos: Send + 'static {
    /// The number of TPDOs, 1800h and following.
    const COUNT: usize;
    /// The maximum number of mapped objects of a TPDO.
    const ENTRIES: usize;
    /// Whether a master can change the mapping. Then 1A00h and following consist of parameters.
    const DYNAMIC: bool;
    /// The state before the start: no TPDO is sent.
    const INITIAL: Self;

    /// All TPDOs, in the order of 1800h and following.
    fn all(&self) -> &[Tpdo];
    /// The TPDOs, to change them.
    fn all_mut(&mut self) -> &mut [Tpdo];
    /// The mapped objects of a TPDO.
    fn mapping(&self, number: usize) -> &[Entry];
    /// Maps the objects that `entry` returns for the number of a TPDO and a sub-index from 1 on.
    fn map_all(&mut self, entry: impl Fn(u16, u8) -> Option<Entry>);
    /// Maps the objects that `entry` returns for a sub-index from 1 on into a TPDO.
    fn map(&mut self, number: usize, entry: impl Fn(u8) -> Option<Entry>);
}

/// `N` TPDOs with at most `E` objects each, with a fixed mapping unless `DYNAMIC`.
#[derive(Debug)]
pub struct TpdoArray<const N: usize, const E: usize, const DYNAMIC: bool = false> {
    tpdos: [Tpdo; N],
    mappings: [heapless::Vec<Entry, E>; N],
}

/// `N` TPDOs to which a master maps up to `E` objects each, 8 at most.
pub type DynamicTpdos<const N: usize, const E: usize> = TpdoArray<N, E, true>;

impl<const N: usize, const E: usize, const DYNAMIC: bool> Tpdos for TpdoArray<N, E, DYNAMIC> {
    const COUNT: usize = N;
    const ENTRIES: usize = E;
    const DYNAMIC: bool = DYNAMIC;
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

    fn map_all(&mut self, entry: impl Fn(u16, u8) -> Option<Entry>) {
        for (number, mapping) in (0..).zip(&mut self.mappings) {
            fill(mapping, |sub| entry(number, sub));
        }
    }

    fn map(&mut self, number: usize, entry: impl Fn(u8) -> Option<Entry>) {
        if let Some(mapping) = self.mappings.get_mut(number) {
            fill(mapping, entry);
        }
    }
}

/// Maps the objects that `entry` returns for a sub-index from 1 on.
fn fill<const E: usize>(
    mapping: &mut heapless::Vec<Entry, E>,
    entry: impl Fn(u8) -> Option<Entry>,
) {
    mapping.clear();
    for sub in 1.. {
        let Some(entry) = entry(sub) else {
            break;
        };
        // There is always room: a fixed mapping is checked at compile time, another one before this call.
        let _ = mapping.push(entry);
    }
}

/// A TPDO is sent while all these conditions hold. The node is operational.
pub(super) const OPERATIONAL: u8 = 1 << 0;
/// Bit 31 of the COB-ID is 0.
const VALID: u8 = 1 << 1;
/// The number of mapped objects (sub-index 0 of 1A00h and following) is not 0.
pub(super) const MAPPED: u8 = 1 << 2;
const ALL: u8 = OPERATIONAL | VALID | MAPPED;

/// A remote frame or changed data.
const EVENT_OF_DATA: u8 = 1 << 0;
/// The end of a period of the event timer.
const EVENT_OF_TIMER: u8 = 1 << 1;

/// A transmit PDO: when its data is sent.
#[derive(Clone, Debug)]
pub struct Tpdo {
    /// The identifier, also while the TPDO is not sent.
    id: u16,
    /// The conditions of [`ALL`] that hold: it is sent while all of them do.
    conditions: u8,
    /// It answers remote frames: bit 30 of its COB-ID is 0.
    remote: bool,
    transmission_type: u8,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// The inhibit time in 100 us.
    inhibit: u16,
    /// The event timer in ms.
    event_ms: u16,
    /// What waits for the end of the inhibit time.
    waiting: u8,
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
        waiting: 0,
        event: Periodic::OFF,
        inhibited: Deadline::NEVER,
        kept: None,
    };

    /// Resets the TPDO. Its communication parameter stays until [`configure`](Self::configure).
    pub(super) fn reset(&mut self) {
        // By field: a copy of the initial state needs more flash.
        self.conditions = MAPPED;
        self.event.stop();
        self.waiting = 0;
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
        triggers: Triggers,
        [cob_id, transmission_type, inhibit, event_ms]: [u32; 4],
    ) -> bool {
        let trigger = (transmission_type as u8, event_ms as u16);
        if triggers.restarts_timer && trigger.0 == self.transmission_type {
            self.change_timer(now, trigger.1);
        } else if trigger != (self.transmission_type, self.event_ms) {
            (self.transmission_type, self.event_ms) = trigger;
            self.restart(now);
        }
        self.change_inhibit_time(inhibit as u16);
        self.remote = cob_id & cob_id::BIT_30 == 0;
        self.set(now, VALID, cob_id & cob_id::DISABLED == 0);
        let id = cob_id as u16 & 0x7FF;
        let readdressed = id != self.id;
        self.id = id;
        readdressed
    }

    /// Sets the inhibit time. A running one counts from the same frame.
    fn change_inhibit_time(&mut self, inhibit: u16) {
        let before = self.inhibit_time();
        self.inhibit = inhibit;
        self.inhibited = self.inhibited.with_delay(before, self.inhibit_time());
    }

    fn inhibit_time(&self) -> Duration {
        Duration::from_ticks(u64::from(self.inhibit) * 100)
    }

    /// Sets the event timer. A running period continues, unless the timer is switched off.
    fn change_timer(&mut self, now: Instant, event_ms: u16) {
        if event_ms == 0 {
            self.waiting &= !EVENT_OF_TIMER;
        }
        let before = core::mem::replace(&mut self.event_ms, event_ms);
        if before != 0 && event_ms != 0 {
            self.event.set_period(event_ms.into());
        } else if before != event_ms {
            self.start_timer(now);
        }
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
        self.waiting = 0;
        self.syncs = 0;
        self.kept = None;
        self.start_timer(now);
    }

    /// Begins the period of the event timer.
    fn start_timer(&mut self, now: Instant) {
        let has_timer = self.is_sent() && self.transmission_type >= EVENT;
        let event_ms = if has_timer { self.event_ms } else { 0 };
        self.event.start(now, event_ms.into());
    }

    /// Whether bit 31 of its COB-ID is 0.
    pub(super) fn is_valid(&self) -> bool {
        self.conditions & VALID != 0
    }

    /// Whether a change of its data is an event, if the product has that [trigger](Triggers::changes).
    pub(super) fn watches(&self) -> bool {
        self.transmission_type == CHANGE && self.is_sent()
    }

    /// Notes that its data has changed.
    pub(super) fn changed(&mut self) {
        self.waiting |= EVENT_OF_DATA;
    }

    /// Whether all conditions hold under which it is sent.
    pub fn is_sent(&self) -> bool {
        self.conditions == ALL
    }

    /// Whether the number of mapped objects is not 0.
    pub(super) fn is_mapped(&self) -> bool {
        self.conditions & MAPPED != 0
    }

    /// The identifier of its frames, also while it is not sent.
    pub fn id(&self) -> u16 {
        self.id
    }

    /// Counts a SYNC, and returns what it causes by the transmission type.
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
    pub fn request(&mut self, now: Instant, triggers: Triggers) -> Reaction {
        if !self.remote || !self.is_sent() {
            return Reaction::None;
        }
        match self.transmission_type {
            SYNC_REMOTE => Reaction::SendKept,
            EVENT.. => {
                self.waiting |= EVENT_OF_DATA;
                if self.poll(now, triggers) {
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

    /// The frame with the data that a SYNC kept, for a remote frame.
    pub fn kept(&self) -> Option<Frame> {
        self.kept
    }

    /// Returns true if the TPDO must be sent now: its event timer has expired, or the inhibit time that delayed an event has
    /// ended.
    pub fn poll(&mut self, now: Instant, triggers: Triggers) -> bool {
        let expired = self.event.poll(now);
        if expired {
            self.waiting |= EVENT_OF_TIMER;
        }
        self.waiting != 0 && self.begin_inhibit_time(now, triggers.restarts_timer && !expired)
    }

    /// Begins the inhibit time of the waiting event, and restarts the event timer on request. Returns false if the last inhibit time
    /// has not ended.
    fn begin_inhibit_time(&mut self, now: Instant, restarts_timer: bool) -> bool {
        if self.inhibited.is_set() && !self.inhibited.is_reached(now) {
            return false;
        }
        self.waiting = 0;
        if restarts_timer {
            self.start_timer(now);
        }
        self.inhibited = if self.inhibit > 0 {
            Deadline::after(now, self.inhibit_time())
        } else {
            Deadline::NEVER
        };
        true
    }

    /// Adds the time at which [`poll`](Self::poll) can become true.
    pub fn consider(&self, next: &mut Deadline) {
        if self.waiting != 0 {
            next.consider(self.inhibited);
        }
        next.consider(self.event.deadline());
    }
}
