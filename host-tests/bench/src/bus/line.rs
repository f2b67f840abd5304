//! The connection of a participant to the wire: the level that it sees, and disturbances from outside.

use super::{Attached, Bus, BusRate, Source};
use crate::sensor::Sensor;
use can_wire::protocol::{Event, Picoseconds, Protocol};
use plumbline::can::Frame;

/// Bits of a disturbance: one more than the equal bits that a frame permits.
pub(super) const NOISE: Picoseconds = 6;

/// A period on the wire: start and end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Span {
    pub(super) from: Picoseconds,
    pub(super) to: Picoseconds,
}

impl Span {
    fn holds(self, now: Picoseconds) -> bool {
        self.from <= now && now < self.to
    }

    /// The next of its two ends.
    pub(super) fn next(self, now: Picoseconds) -> Option<Picoseconds> {
        [self.from, self.to].into_iter().find(|at| *at > now)
    }
}

/// The connection of one participant to the wire.
#[derive(Clone, Debug, Default)]
pub(super) struct Line {
    /// The level that it sees; true is dominant.
    sees: bool,
    /// The frame that it has begun to send.
    pub(super) sending: Option<Frame>,
    /// Its current frame has passed the CRC delimiter.
    judged: bool,
    /// It does not see the dominant ACK slot during this period.
    deaf: Option<Span>,
    /// A dominant pulse that only this participant sees.
    pulse: Option<Span>,
}

impl Line {
    /// Steps the participant's controller, if that is due.
    pub(super) fn step(
        &mut self,
        now: Picoseconds,
        protocol: &mut Protocol,
        offered: Option<Frame>,
    ) -> Option<Event> {
        protocol
            .next_event(offered.is_some())
            .filter(|at| *at <= now)?;
        let event = protocol.step(now, self.sees, offered)?;
        self.note(event, offered);
        Some(event)
    }

    /// Steps the CAN controller of a sensor, if that is due.
    pub(super) fn step_sensor(
        &mut self,
        now: Picoseconds,
        sensor: &mut dyn Sensor,
    ) -> Option<Event> {
        sensor.next_step().filter(|at| *at <= now)?;
        let takes = sensor.protocol().is_some_and(Protocol::takes_offer);
        let offered = if takes { sensor.offered() } else { None };
        let event = sensor.step(now, self.sees)?;
        self.note(event, offered);
        Some(event)
    }

    fn note(&mut self, event: Event, offered: Option<Frame>) {
        if event == Event::Started {
            self.sending = offered;
            self.judged = false;
        }
    }

    /// Passes the level of the wire to a participant; None: it is not connected.
    fn settle(&mut self, now: Picoseconds, protocol: &mut Protocol, wire: Option<bool>) {
        if self.look(now, protocol, wire) == Some(true) {
            protocol.edge(now);
        }
    }

    /// The level that the participant sees from now on, if it has changed.
    fn look(&mut self, now: Picoseconds, protocol: &Protocol, wire: Option<bool>) -> Option<bool> {
        let level = match self.deaf {
            Some(deaf) if deaf.holds(now) => false,
            _ => wire.unwrap_or_else(|| protocol.is_dominant()),
        };
        let sees = level || self.pulse.is_some_and(|span| span.holds(now));
        (std::mem::replace(&mut self.sees, sees) != sees).then_some(sees)
    }

    /// Makes the wire dominant for this participant only, from now on for this time.
    pub(super) fn pulse(&mut self, now: Picoseconds, length: Picoseconds) {
        let to = now + length;
        self.pulse = Some(Span { from: now, to });
    }

    /// The end of the last pulse.
    pub(super) fn pulsed_until(&self) -> Option<Picoseconds> {
        self.pulse.map(|span| span.to)
    }

    /// When the level that it sees next changes without a change on the wire.
    pub(super) fn next_event(&self, now: Picoseconds) -> Option<Picoseconds> {
        let deaf = self.deaf.and_then(|span| span.next(now));
        let pulse = self.pulse.and_then(|span| span.next(now));
        deaf.into_iter().chain(pulse).min()
    }

    /// Disturbs the current frame of the participant, or hides its acknowledge, when requested and due: in the CRC delimiter,
    /// where all participants see it at once, or in the ACK slot. Returns when the wire has to be dominant.
    fn intervene(
        &mut self,
        protocol: &Protocol,
        source: Source,
        wishes: &mut Wishes,
    ) -> Option<Span> {
        if !protocol.is_transmitting() || protocol.frame_start() < wishes.since {
            return None;
        }
        let from = protocol.bit_start();
        let to = from + protocol.timing().bit;
        let bit = Span { from, to };
        if protocol.is_at_crc_delimiter() && !self.judged {
            self.judged = true;
            return wishes.corrupts(source).then_some(bit);
        }
        if protocol.is_at_ack_slot() && self.judged {
            self.judged = false;
            if wishes.unacknowledged > 0 {
                wishes.unacknowledged -= 1;
                self.deaf = Some(bit);
            }
        }
        None
    }
}

/// Requested disturbances of the next frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wishes {
    /// They apply to frames that started at this time or later.
    pub(super) since: Picoseconds,
    /// Number of frames to disturb, of all senders or only of one.
    pub(super) corrupt: (u32, Option<Source>),
    /// Number of frames that are not acknowledged.
    pub(super) unacknowledged: u32,
}

impl Wishes {
    /// True while frames remain to be disturbed.
    pub(super) fn is_pending(&self) -> bool {
        self.corrupt.0 > 0 || self.unacknowledged > 0
    }

    fn corrupts(&mut self, source: Source) -> bool {
        let (count, of) = &mut self.corrupt;
        let hit = *count > 0 && of.is_none_or(|of| of == source);
        *count -= u32::from(hit);
        hit
    }
}

impl Bus {
    /// True when a controller is connected to the wire.
    pub(super) fn is_connected(&self, protocol: &Protocol) -> bool {
        self.rate == BusRate::Wire || protocol.is_silent() || self.has_rate(protocol)
    }

    /// Combines all levels and passes the result to all participants.
    pub(super) fn settle(&mut self) {
        let now = self.time;
        self.disturbances.retain(|span| span.to > now);
        let dominant = self.is_dominant();
        for index in 0..self.devices.len() {
            let sensor = &self.devices[index].sensor;
            let connected = sensor
                .protocol()
                .is_some_and(|protocol| self.is_connected(protocol));
            let wire = connected.then_some(dominant);
            let Attached { sensor, line } = &mut self.devices[index];
            let protocol = sensor.protocol();
            if let Some(level) = protocol.and_then(|protocol| line.look(now, protocol, wire)) {
                sensor.wire(now, level);
            }
        }
        for (adapter, line) in self.adapters.values_mut() {
            line.settle(now, &mut adapter.protocol, Some(dominant));
        }
        let (assistant, line) = &mut self.assistant;
        line.settle(now, assistant, Some(dominant));
    }

    fn is_dominant(&self) -> bool {
        let now = self.time;
        self.disturbances.iter().any(|span| span.holds(now))
            || self.devices.iter().any(|attached| {
                let sensor = &attached.sensor;
                let is_connected = |one| self.is_connected(one);
                sensor.is_dominant() && sensor.protocol().is_none_or(is_connected)
            })
            || self
                .adapters
                .values()
                .any(|(adapter, _)| adapter.protocol.is_dominant())
            || self.assistant_acknowledges()
    }

    /// The silent participant acknowledges what adapters send, unless a sensor takes part. That one acknowledges what it receives.
    fn assistant_acknowledges(&self) -> bool {
        let mut adapters = self.adapters.values();
        self.assistant.0.is_acknowledging()
            && adapters.any(|(adapter, _)| adapter.protocol.is_transmitting())
            && self.is_led()
            && !self.a_sensor_takes_part()
    }

    /// True when a sensor is connected to the wire and acknowledges what it receives.
    fn a_sensor_takes_part(&self) -> bool {
        let takes_part = |one: &Protocol| one.can_acknowledge() && self.is_connected(one);
        let mut sensors = self.devices.iter().map(|attached| &attached.sensor);
        sensors.any(|sensor| sensor.protocol().is_some_and(takes_part))
    }

    /// Applies the requested disturbances to the frames on the wire.
    pub(super) fn intervene(&mut self) {
        if !self.wishes.is_pending() {
            return;
        }
        for (index, attached) in self.devices.iter_mut().enumerate() {
            let source = Source::Device(super::DeviceId(index));
            if let Some(protocol) = attached.sensor.protocol() {
                let span = attached.line.intervene(protocol, source, &mut self.wishes);
                self.disturbances.extend(span);
            }
        }
        for (id, (adapter, line)) in self.adapters.iter_mut() {
            let source = Source::Adapter(*id);
            let span = line.intervene(&adapter.protocol, source, &mut self.wishes);
            self.disturbances.extend(span);
        }
    }
}
