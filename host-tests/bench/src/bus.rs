//! The wire, true to the bit, in virtual time.
//!
//! Every participant has the [`Protocol`] state machine of a CAN controller and drives the wire with it. Arbitration, acknowledge, error
//! frames, error counters and bus-off are what comes of that; nothing is decided for whole frames.
//!
//! Times inside are in picoseconds; what is told outside is the microsecond in which it happened, rounded up.
//!
//! Where this wire is not like a real one:
//! - It has no length: a level is everywhere at once.
//! - Unless it is [`BusRate::Wire`], who has another bit rate is left out, and there is one more participant, which is silent but
//!   acknowledges what adapters send, so that a lone client can wake a sensor that is detecting the bit rate. A sensor's frame needs
//!   another sensor or an open adapter. Two adapters with the same identifier go one after the other.

mod leading;
mod line;
mod stepping;

use super::adapter::Adapter;
use super::sensor::Sensor;
use can_wire::protocol::{BitTiming, Picoseconds, Protocol};
use line::{Line, NOISE, Span, Wishes};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::collections::{BTreeMap, VecDeque};

/// The rate at which a detecting sensor finds the first frame on a bus that follows it.
const FOLLOW_RATE: BitRate = BitRate::K250;

/// Frames that the log holds; after that the oldest are lost.
const LOG_MAX: usize = 1_000_000;

/// Who takes part at which bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BusRate {
    /// The wire has this rate. Who takes part at another one is not connected: it reaches nobody and hears nobody. Who only
    /// listens is connected at any rate, and sees errors at a wrong one.
    Fixed(BitRate),
    /// The wire has the rate of the first sensor, and the adapters' rates mean nothing. While that sensor detects the rate,
    /// it is led to 250 kbit/s before an adapter's frame starts, so that the first frame reveals that rate.
    Follow,
    /// As on a copper wire: everybody is connected, each at its own rate, and disturbs the others when that is a wrong one. Only
    /// adapters that were opened without a rate have that of the first sensor. Nobody helps out with acknowledges
    /// ([`Bus::assist`]).
    Wire,
}

/// Names a sensor on a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct DeviceId(usize);

/// Names an adapter on a bus.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct AdapterId(usize);

/// Who sent a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A sensor.
    Device(DeviceId),
    /// A PLC, a tester or a client.
    Adapter(AdapterId),
}

/// A frame that came to its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Logged {
    /// The start of the frame, to the picosecond.
    pub start: Picoseconds,
    /// The end of the frame.
    pub at: Instant,
    /// The frame.
    pub frame: Frame,
    /// Who sent it.
    pub source: Source,
}

struct Attached {
    sensor: Box<dyn Sensor>,
    line: Line,
}

/// Sensors and adapters on one wire.
pub struct Bus {
    rate: BusRate,
    /// The timing of the wire, where it has one.
    timing: BitTiming,
    time: Picoseconds,
    devices: Vec<Attached>,
    adapters: BTreeMap<AdapterId, (Adapter, Line)>,
    adapters_made: usize,
    /// Until then a sensor goes first, because an adapter has just sent a frame.
    adapters_wait_until: Picoseconds,
    /// The silent participant that acknowledges; it takes part while an adapter is open.
    assistant: (Protocol, Line),
    assists: bool,
    leading: bool,
    wishes: Wishes,
    /// When the wire is dominant whatever is sent.
    disturbances: Vec<Span>,
    /// Frames whose last bit has been sampled, with the end of that bit.
    ended: VecDeque<(Picoseconds, Logged)>,
    log: VecDeque<Logged>,
}

impl Bus {
    /// A quiet wire at time 0.
    pub fn new(rate: BusRate) -> Self {
        let timing = match rate {
            BusRate::Fixed(rate) => rate,
            BusRate::Follow | BusRate::Wire => FOLLOW_RATE,
        };
        Self {
            rate,
            timing: BitTiming::of(timing),
            time: 0,
            devices: Vec::new(),
            adapters: BTreeMap::new(),
            adapters_made: 0,
            adapters_wait_until: 0,
            assistant: Default::default(),
            assists: rate != BusRate::Wire,
            leading: false,
            wishes: Wishes::default(),
            disturbances: Vec::new(),
            ended: VecDeque::new(),
            log: VecDeque::new(),
        }
    }

    /// Connects a sensor and switches it on.
    pub fn attach(&mut self, sensor: impl Sensor) -> DeviceId {
        self.attach_boxed(Box::new(sensor))
    }

    /// Connects a sensor of whatever kind and switches it on.
    pub fn attach_boxed(&mut self, mut sensor: Box<dyn Sensor>) -> DeviceId {
        sensor.power_on(self.now());
        self.devices.push(Attached {
            sensor,
            line: Line::default(),
        });
        DeviceId(self.devices.len() - 1)
    }

    /// A sensor.
    pub fn device(&self, id: DeviceId) -> &dyn Sensor {
        self.devices[id.0].sensor.as_ref()
    }

    /// A sensor, to be changed.
    pub fn device_mut(&mut self, id: DeviceId) -> &mut dyn Sensor {
        self.devices[id.0].sensor.as_mut()
    }

    /// Switches a sensor off and on again, now.
    pub fn power_cycle(&mut self, id: DeviceId) {
        let now = self.now();
        self.device_mut(id).power_cycle(now);
    }

    /// Whether a silent participant acknowledges what adapters send; it does on a bus with one rate.
    pub fn assist(&mut self, assists: bool) {
        self.assists = assists;
        self.call_assistant();
    }

    /// Connects an adapter; it is closed.
    pub fn adapter(&mut self) -> AdapterId {
        let id = AdapterId(self.adapters_made);
        self.adapters_made += 1;
        self.adapters.insert(id, Default::default());
        id
    }

    /// Opens an adapter, at a bit rate or at that of the bus; when it was open, it is closed first. It takes part after 11
    /// recessive bits.
    pub fn open(&mut self, id: AdapterId, rate: Option<BitRate>, listen_only: bool) {
        let (now, timing) = (self.time, self.adapter_timing(rate));
        if let Some((adapter, _)) = self.adapters.get_mut(&id) {
            adapter.open(rate, listen_only);
            if let Some(timing) = timing {
                adapter.join(now, timing);
            }
        }
        self.call_assistant();
    }

    /// Closes an adapter; what it has not sent yet is dropped, what it has received can still be taken.
    pub fn close(&mut self, id: AdapterId) {
        if let Some((adapter, _)) = self.adapters.get_mut(&id) {
            adapter.close();
        }
        self.call_assistant();
    }

    /// Disconnects an adapter; its id means nothing afterwards.
    pub fn remove(&mut self, id: AdapterId) {
        self.adapters.remove(&id);
        self.call_assistant();
    }

    /// The assistant takes part while it is needed.
    fn call_assistant(&mut self) {
        let needed = self.assists && self.adapters.values().any(|(one, _)| one.is_open());
        let (assistant, _) = &mut self.assistant;
        if !needed {
            assistant.reset();
        } else if !assistant.is_on() {
            assistant.join(self.time, self.timing, true);
        }
    }

    /// Queues a frame in an adapter; nothing happens when it is closed or only listens. Frames are sent in this order, and
    /// after each the adapter lets a device with a waiting frame go first, because its next frame is not loaded within the
    /// intermission: polls queued all at once get their replies.
    pub fn send(&mut self, id: AdapterId, frame: Frame) {
        if let Some((adapter, _)) = self.adapters.get_mut(&id) {
            adapter.push(frame);
        }
    }

    /// Frames that wait in an adapter.
    pub fn queued(&self, id: AdapterId) -> usize {
        let adapter = self.adapters.get(&id);
        adapter.map_or(0, |(adapter, _)| adapter.queued())
    }

    /// What an adapter has received: the frames of others, each with the time at which it ended.
    pub fn take_received(&mut self, id: AdapterId) -> Vec<(Instant, Frame)> {
        let Some((adapter, _)) = self.adapters.get_mut(&id) else {
            return Vec::new();
        };
        let received = adapter.take_received(self.time);
        received
            .into_iter()
            .map(|(end, frame)| (instant(end), frame))
            .collect()
    }

    /// Every completed frame since the last call, at most the newest million.
    pub fn take_log(&mut self) -> Vec<Logged> {
        self.log.drain(..).collect()
    }

    /// The error flags that somebody has sent, active and passive, since it was switched on or attached: the frames that have
    /// been disturbed for it.
    pub fn disturbed(&self, who: Source) -> u64 {
        let protocol = match who {
            Source::Device(id) => self.device(id).protocol(),
            Source::Adapter(id) => self.adapters.get(&id).map(|(one, _)| &one.protocol),
        };
        protocol.map_or(0, Protocol::error_flags)
    }

    /// Disturbs the next `count` frames, all or only those of one sender; a repetition counts as a frame. Their CRC delimiter
    /// is made dominant, so that everybody sees the error in the same bit.
    pub fn corrupt(&mut self, count: u32, of: Option<Source>) {
        self.wishes.since = self.time;
        self.wishes.corrupt = (count, of);
    }

    /// Lets the next `count` frames go unacknowledged, adapters' frames too: their senders do not see the dominant bit in the ACK
    /// slot, those who send it do.
    pub fn drop_acknowledges(&mut self, count: u32) {
        self.wishes.since = self.time;
        self.wishes.unacknowledged = count;
    }

    /// Disturbs the wire at `at`, or now when that is past: it is dominant for six bits of the bus's rate, which destroys a frame
    /// and is an error on a quiet wire.
    pub fn noise(&mut self, at: Instant) {
        let from = picoseconds(at).max(self.time);
        let to = from + NOISE * self.timing.bit;
        self.disturbances.push(Span { from, to });
    }

    /// The present.
    pub fn now(&self) -> Instant {
        instant(self.time)
    }

    /// When something happens next, without anything from outside. While something is on the wire that is the next bit.
    pub fn next_event(&self) -> Option<Instant> {
        self.devices
            .iter()
            .filter(|attached| attached.sensor.runs_freely())
            .filter_map(|attached| attached.sensor.next_event())
            .chain(self.next_step())
            .min()
            .map(|at| instant(at.max(self.time)))
    }
}

/// The microsecond in which something happens, rounded up.
pub(super) fn instant(time: Picoseconds) -> Instant {
    Instant::from_ticks(time.div_ceil(1_000_000))
}

/// A microsecond.
pub(super) fn picoseconds(at: Instant) -> Picoseconds {
    at.ticks() * 1_000_000
}
