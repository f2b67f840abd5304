//! The wire, bit by bit, in virtual time.
//!
//! Every participant has the [`Protocol`] state machine of a CAN controller and drives the wire with it. Arbitration,
//! acknowledge, error frames, error counters and bus-off result from the bits; the bus decides nothing per frame.
//!
//! Internal times are in picoseconds; the public functions return microseconds, rounded up.
//!
//! Differences to a real wire:
//! - It has no length: a level is everywhere at once.
//! - Unless it is [`BusRate::Wire`], a participant with another bit rate is not connected. There is one more participant, the
//!   silent assistant, which acknowledges the frames of adapters while no sensor does, so that a lone client can wake a sensor
//!   that is detecting the bit rate. The frame of a sensor needs another sensor or an open adapter. Two adapters send frames with
//!   the same identifier one after the other. An adapter waits for the end of an error frame of a sensor.

mod adapters;
mod leading;
mod line;
mod repetition;
mod stepping;

use super::adapter::Adapter;
use super::sensor::Sensor;
use adapters::Adapters;
use can_wire::protocol::{BitTiming, Picoseconds, Protocol};
use line::{Line, NOISE, Span, Wishes};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after};
use repetition::Attempts;
use std::collections::VecDeque;

/// The bit rate of the first frame for a detecting sensor on a bus that follows it.
const FOLLOW_RATE: BitRate = BitRate::K250;

/// Frames that the log holds; then it drops the oldest.
const LOG_MAX: usize = 1_000_000;

/// The bit rate of the wire and the participants that it connects.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BusRate {
    /// The wire has this rate. A participant with another rate is not connected: it neither sends nor receives. A participant in
    /// listen-only mode is connected at any rate, and sees errors at a wrong one.
    Fixed(BitRate),
    /// The wire has the rate of the first sensor, and the rates of the adapters have no effect. While that sensor detects the
    /// rate, the bus leads it to 250 kbit/s before an adapter's frame starts, so that the sensor detects that rate at the first
    /// frame.
    Follow,
    /// As on a real wire: every participant is connected at its own rate, and a wrong rate disturbs the others. Only adapters
    /// that were opened without a rate have that of the first sensor. The assistant does not acknowledge unless requested
    /// ([`Bus::assist`]).
    Wire,
}

/// Identifies a sensor on a bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct DeviceId(usize);

/// Identifies an adapter on a bus.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct AdapterId(usize);

/// The sender of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A sensor that is [attached](Bus::attach) to the bus.
    Device(DeviceId),
    /// A PLC, a tester or a client.
    Adapter(AdapterId),
}

/// A frame that was sent without error, as every node has received it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Logged {
    /// The start of the frame, to the picosecond.
    pub start: Picoseconds,
    /// The end of the frame.
    pub at: Instant,
    /// Identifier and data of the frame.
    pub frame: Frame,
    /// The node that has sent it.
    pub source: Source,
}

struct Attached {
    sensor: Box<dyn Sensor>,
    line: Line,
}

/// Sensors and adapters on one wire.
pub struct Bus {
    rate: BusRate,
    /// The timing of the wire, if it has one.
    timing: BitTiming,
    time: Picoseconds,
    devices: Vec<Attached>,
    adapters: Adapters,
    adapters_made: usize,
    /// Until then a sensor goes first, because an adapter has just sent a frame.
    adapters_wait_until: Picoseconds,
    /// After its frame, an adapter waits, so that a sensor can send first.
    gives_way: bool,
    /// The silent participant that acknowledges; it is on the bus while an adapter is.
    assistant: (Protocol, Line),
    assists: bool,
    leading: bool,
    wishes: Wishes,
    attempts: Attempts,
    /// Periods in which the wire is dominant regardless of the participants.
    disturbances: Vec<Span>,
    /// Frames whose last bit has been sampled, with the end of that bit.
    ended: VecDeque<(Picoseconds, Logged)>,
    log: VecDeque<Logged>,
}

impl Bus {
    /// An idle wire at time 0.
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
            adapters: Adapters::default(),
            adapters_made: 0,
            adapters_wait_until: 0,
            gives_way: true,
            assistant: Default::default(),
            assists: rate != BusRate::Wire,
            leading: false,
            wishes: Wishes::default(),
            attempts: Attempts::default(),
            disturbances: Vec::new(),
            ended: VecDeque::new(),
            log: VecDeque::new(),
        }
    }

    /// Connects a sensor and switches it on.
    pub fn attach(&mut self, sensor: impl Sensor) -> DeviceId {
        self.attach_boxed(Box::new(sensor))
    }

    /// Connects a sensor of any type and switches it on.
    pub fn attach_boxed(&mut self, mut sensor: Box<dyn Sensor>) -> DeviceId {
        sensor.power_on(self.now());
        self.devices.push(Attached {
            sensor,
            line: Line::default(),
        });
        DeviceId(self.devices.len() - 1)
    }

    /// The sensor that [`attach`](Self::attach) gave this id.
    pub fn device(&self, id: DeviceId) -> &dyn Sensor {
        self.devices[id.0].sensor.as_ref()
    }

    /// The sensor that [`attach`](Self::attach) gave this id, to change it.
    pub fn device_mut(&mut self, id: DeviceId) -> &mut dyn Sensor {
        self.devices[id.0].sensor.as_mut()
    }

    /// Switches a sensor off and on again, now.
    pub fn power_cycle(&mut self, id: DeviceId) {
        let now = self.now();
        self.device_mut(id).power_cycle(now);
    }

    /// Sets whether the assistant acknowledges the frames of adapters; it does by default on a bus with one rate.
    pub fn assist(&mut self, assists: bool) {
        self.assists = assists;
        self.call_assistant();
    }

    /// Connects an adapter, which is closed at first.
    pub fn adapter(&mut self) -> AdapterId {
        let id = AdapterId(self.adapters_made);
        self.adapters_made += 1;
        self.adapters.push(id);
        id
    }

    /// Opens an adapter, at a bit rate or at that of the bus; if it is open, closes it first. It takes part after 11 recessive
    /// bits.
    pub fn open(&mut self, id: AdapterId, rate: Option<BitRate>, listen_only: bool) {
        let (now, timing) = (self.time, self.adapter_timing(rate));
        if let Some((adapter, _)) = self.adapters.get_mut(id) {
            adapter.open(rate, listen_only);
            if let Some(timing) = timing {
                adapter.join(now, timing);
            }
        }
        self.call_assistant();
    }

    /// Closes an adapter. Frames not sent yet are dropped, received frames can still be taken.
    pub fn close(&mut self, id: AdapterId) {
        if let Some((adapter, _)) = self.adapters.get_mut(id) {
            adapter.close();
        }
        self.call_assistant();
    }

    /// True when an adapter is open and connected to the wire.
    pub fn takes_part(&self, id: AdapterId) -> bool {
        let adapter = self.adapters.get(id);
        adapter.is_some_and(|(adapter, _)| adapter.protocol.is_on())
    }

    /// Disconnects an adapter; its id is invalid afterwards.
    pub fn remove(&mut self, id: AdapterId) {
        self.adapters.remove(id);
        self.call_assistant();
    }

    /// Makes the assistant take part while it is needed.
    fn call_assistant(&mut self) {
        let is_on = |(one, _): &(Adapter, Line)| one.protocol.is_on();
        let needed = self.assists && self.adapters.values().any(is_on);
        let (assistant, _) = &mut self.assistant;
        if !needed {
            assistant.reset();
        } else if !assistant.is_on() {
            assistant.join(self.time, self.timing, true);
        }
    }

    /// Queues a frame in an adapter; has no effect when the adapter is closed or listen-only. The adapter sends frames in this
    /// order. After each it lets a device with a waiting frame go first, because it does not load its next frame within the
    /// intermission: polls that are queued together get their replies.
    pub fn send(&mut self, id: AdapterId, frame: Frame) {
        if let Some((adapter, _)) = self.adapters.get_mut(id) {
            adapter.push(frame);
        }
    }

    /// Selects whether an adapter waits after its frame, so that a sensor can send first. Without this wait, the adapter sends its next
    /// frame directly after the intermission, and the arbitration decides.
    pub fn give_way(&mut self, gives_way: bool) {
        self.gives_way = gives_way;
    }

    /// Frames that wait in an adapter.
    pub fn queued(&self, id: AdapterId) -> usize {
        let adapter = self.adapters.get(id);
        adapter.map_or(0, |(adapter, _)| adapter.queued())
    }

    /// Takes the frames that an adapter has received from others, each with the time of its end.
    pub fn take_received(&mut self, id: AdapterId) -> Vec<(Instant, Frame)> {
        let Some((adapter, _)) = self.adapters.get_mut(id) else {
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

    /// The number of error flags, active and passive, that a participant has sent since it was switched on or attached: the
    /// frames disturbed at this participant.
    pub fn disturbed(&self, participant: Source) -> u64 {
        let protocol = match participant {
            Source::Device(id) => self.device(id).protocol(),
            Source::Adapter(id) => self.adapters.get(id).map(|(one, _)| &one.protocol),
        };
        protocol.map_or(0, Protocol::error_flags)
    }

    /// Disturbs the next `count` frames, of all senders or only of one; a repetition counts as a frame. The bus makes their CRC
    /// delimiter dominant, so that all participants see the error in the same bit.
    pub fn corrupt(&mut self, count: u32, of: Option<Source>) {
        self.wishes.since = self.time;
        self.wishes.corrupt = (count, of);
    }

    /// Hides the acknowledge of the next `count` frames, also of adapters: the sender does not see the dominant bit in the ACK
    /// slot, the receivers do.
    pub fn drop_acknowledges(&mut self, count: u32) {
        self.wishes.since = self.time;
        self.wishes.unacknowledged = count;
    }

    /// Disturbs the wire at `at`, or now when that has passed: it is dominant for six bits of the bus's rate, which destroys a
    /// frame and is an error on an idle wire.
    pub fn noise(&mut self, at: Instant) {
        let from = picoseconds(at).max(self.time);
        let to = from + NOISE * self.timing.bit;
        self.disturbances.push(Span { from, to });
    }

    /// Holds the wire dominant from now on for this time.
    pub fn hold_dominant(&mut self, time: Duration) {
        let from = self.time;
        let to = picoseconds(after(self.now(), time));
        self.disturbances.push(Span { from, to });
    }

    /// The virtual time of the bus, which its sensors also have.
    pub fn now(&self) -> Instant {
        instant(self.time)
    }

    /// When the next event happens without any input. While the wire is busy, that is the next bit.
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

/// A simulation time in microseconds, rounded up.
pub(super) fn instant(time: Picoseconds) -> Instant {
    Instant::from_ticks(time.div_ceil(1_000_000))
}

/// A time in microseconds, in picoseconds.
pub(super) fn picoseconds(at: Instant) -> Picoseconds {
    at.ticks() * 1_000_000
}
