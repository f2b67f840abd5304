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

use super::dictionary::Rule;
use super::key::{TpdoKey, tpdo};
use super::timer::Periodic;
use super::values::Values;
use super::wire;
use crate::can::Frame;
use crate::time::{Duration, Earliest, Instant, after, is_due};

/// When a TPDO is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
enum Type {
    /// With a SYNC, when the data have changed.
    #[default]
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

/// The objects that a TPDO carries.
pub type Mapping = heapless::Vec<(&'static Rule, u8), 4>;

/// One transmit PDO.
#[derive(Clone, Debug, Default)]
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
    mapping: Mapping,
}

impl Tpdo {
    /// A TPDO that carries these objects; [`configure`](Self::configure) follows.
    pub fn new(mapping: Mapping) -> Self {
        Self {
            mapping,
            ..Self::default()
        }
    }

    /// Takes its communication parameter over; `number` counts from 0.
    pub fn configure(&mut self, now: Instant, number: u8, values: &Values) {
        let value = |key| values.at(tpdo(number, key));
        let id = value(TpdoKey::Id);
        self.id = (id & wire::DISABLED == 0).then_some((id & 0x7FF) as u16);
        self.remote = id & wire::BIT_30 == 0;
        let kind = match value(TpdoKey::Type) {
            0 => Type::Acyclic,
            252 => Type::SyncRemote,
            253 => Type::Remote,
            254.. => Type::Event,
            count => Type::Cyclic(count as u8),
        };
        let event_ms = value(TpdoKey::Event);
        let changed = (kind, event_ms) != (self.kind, self.event_ms);
        let inhibit = u64::from(value(TpdoKey::Inhibit)) * 100;
        self.inhibit = (inhibit > 0).then(|| Duration::from_ticks(inhibit));
        self.kind = kind;
        self.event_ms = event_ms;
        if changed && self.running {
            self.start(now);
        }
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

    /// The objects that it carries.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
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
