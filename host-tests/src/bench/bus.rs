//! The wire: arbitration, frame times, acknowledge and bus errors in virtual time.
//!
//! Times inside are in nanoseconds, in which a bit is a whole number at each of the ten rates, so that nothing drifts; what the
//! nodes get is the microsecond in which it happened, rounded up.
//!
//! Where this wire is simpler than a real one:
//! - It has one more participant, which is silent but acknowledges what adapters send, so that a lone client can wake a sensor
//!   that is detecting the bit rate. A device's frame needs another device or an open adapter; until there is one, the device
//!   tries until it is error passive, and then waits quietly instead of repeating for ever.
//! - Two nodes that send the same identifier at the same time do not collide: the one that was attached first goes first.
//! - A disturbed frame is disturbed in its CRC sequence; noise is an error in the bit in which it comes.

mod ending;
mod starting;

use super::adapter::Adapter;
use super::controller::Failure;
use super::device::Device;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Instant, earlier};
use std::collections::{BTreeMap, VecDeque};

/// Error flag and error delimiter.
const ERROR_FRAME: u32 = 6 + 8;

/// The rate at which a detecting device finds the first frame on a bus that follows it.
const FOLLOW_RATE: BitRate = BitRate::K250;

/// Frames that the log holds; after that the oldest are lost.
const LOG_MAX: usize = 1_000_000;

/// The bit rate of the wire.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BusRate {
    /// As on a real wire: who is set to another rate takes no part. A device that detects the rate sees a bus error for each
    /// frame while it listens at another one; a device in normal mode at another rate hears nothing and disturbs nothing; an
    /// adapter opened at another rate reaches nobody and hears nothing.
    Fixed(BitRate),
    /// The wire has the rate of the first device, and the adapters' rates mean nothing. While that device detects the rate,
    /// the wire gives it bus errors before an adapter's frame until it listens at 250 kbit/s, so that the first frame reveals
    /// that rate.
    Follow,
}

/// Names a device on a bus.
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
    /// The end of the frame.
    pub at: Instant,
    /// The frame.
    pub frame: Frame,
    /// Who sent it.
    pub source: Source,
}

/// A frame on the wire.
#[derive(Clone, Copy, Debug)]
struct Transmission {
    frame: Frame,
    source: Source,
    /// The sender's count of starts; when it has changed by the end, the frame was torn off.
    boots: u32,
    rate: BitRate,
    start: Instant,
    end_ns: u64,
    result: Result<(), Failure>,
}

struct Attached {
    device: Device,
    /// The end of an error passive sender's pause.
    suspended_ns: u64,
}

/// Devices and adapters on one wire.
pub struct Bus {
    rate: BusRate,
    now: Instant,
    devices: Vec<Attached>,
    adapters: BTreeMap<AdapterId, Adapter>,
    adapters_made: usize,
    wire: Option<Transmission>,
    idle_ns: u64,
    log: VecDeque<Logged>,
    corrupt: (u32, Option<Source>),
    unacknowledged: u32,
    noise: Vec<Instant>,
}

impl Bus {
    /// A quiet wire at time 0.
    pub fn new(rate: BusRate) -> Self {
        Self {
            rate,
            now: Instant::from_ticks(0),
            devices: Vec::new(),
            adapters: BTreeMap::new(),
            adapters_made: 0,
            wire: None,
            idle_ns: 0,
            log: VecDeque::new(),
            corrupt: (0, None),
            unacknowledged: 0,
            noise: Vec::new(),
        }
    }

    /// Connects a device and switches it on.
    pub fn attach(&mut self, mut device: Device) -> DeviceId {
        device.power_on(self.now);
        self.devices.push(Attached {
            device,
            suspended_ns: 0,
        });
        DeviceId(self.devices.len() - 1)
    }

    /// A device.
    pub fn device(&self, id: DeviceId) -> &Device {
        &self.devices[id.0].device
    }

    /// A device, to be changed.
    pub fn device_mut(&mut self, id: DeviceId) -> &mut Device {
        &mut self.devices[id.0].device
    }

    /// Switches a device off and on again, now.
    pub fn power_cycle(&mut self, id: DeviceId) {
        let now = self.now;
        self.device_mut(id).power_cycle(now);
    }

    /// Connects an adapter; it is closed.
    pub fn adapter(&mut self) -> AdapterId {
        let id = AdapterId(self.adapters_made);
        self.adapters_made += 1;
        self.adapters.insert(id, Adapter::default());
        id
    }

    /// Opens an adapter, at a bit rate or at that of the bus; when it was open, it is closed first.
    pub fn open(&mut self, id: AdapterId, rate: Option<BitRate>, listen_only: bool) {
        let now = self.now;
        if let Some(adapter) = self.adapters.get_mut(&id) {
            adapter.open(now, rate, listen_only);
        }
    }

    /// Closes an adapter; what it has not sent yet is dropped, what it has received can still be taken.
    pub fn close(&mut self, id: AdapterId) {
        if let Some(adapter) = self.adapters.get_mut(&id) {
            adapter.close();
        }
    }

    /// Disconnects an adapter; its id means nothing afterwards.
    pub fn remove(&mut self, id: AdapterId) {
        self.adapters.remove(&id);
    }

    /// Queues a frame in an adapter; nothing happens when it is closed or only listens. Frames are sent in this order, and
    /// after each the adapter lets a device with a waiting frame go first, because its next frame is not loaded within the
    /// intermission: polls queued all at once get their replies.
    pub fn send(&mut self, id: AdapterId, frame: Frame) {
        let fixed = self.fixed();
        let Some(adapter) = self.adapters.get_mut(&id) else {
            return;
        };
        match adapter.sends_at() {
            Some(Some(own)) if fixed.is_some_and(|rate| rate != own) => self.send_off_rate(own),
            Some(_) => adapter.push(frame),
            None => {}
        }
    }

    /// Frames that wait in an adapter.
    pub fn queued(&self, id: AdapterId) -> usize {
        self.adapters.get(&id).map_or(0, Adapter::queued)
    }

    /// What an adapter has received: the frames of others, each with the time at which it ended.
    pub fn take_received(&mut self, id: AdapterId) -> Vec<(Instant, Frame)> {
        self.adapters
            .get_mut(&id)
            .map_or_else(Vec::new, Adapter::take_received)
    }

    /// Every completed frame since the last call, at most the newest million.
    pub fn take_log(&mut self) -> Vec<Logged> {
        self.log.drain(..).collect()
    }

    /// Disturbs the next `count` frames, all or only those of one sender; a repetition counts as a frame.
    pub fn corrupt(&mut self, count: u32, of: Option<Source>) {
        self.corrupt = (count, of);
    }

    /// Lets the next `count` frames go unacknowledged, adapters' frames too.
    pub fn drop_acknowledges(&mut self, count: u32) {
        self.unacknowledged = count;
    }

    /// Disturbs the wire for a moment at `at`, or now when that is past: a frame is destroyed, a quiet wire sees an error.
    pub fn noise(&mut self, at: Instant) {
        self.noise.push(at.max(self.now));
    }

    /// The present.
    pub fn now(&self) -> Instant {
        self.now
    }

    /// When something happens next, without anything from outside.
    pub fn next_event(&self) -> Option<Instant> {
        let wire = match &self.wire {
            Some(transmission) => Some(transmission.end_ns),
            None => self.next_start(),
        };
        self.devices
            .iter()
            .filter_map(|attached| attached.device.next_event())
            .chain(self.noise.iter().copied())
            .chain(wire.map(instant))
            .map(|at| at.max(self.now))
            .fold(None, |first, at| earlier(first, Some(at)))
    }

    /// Lets everything happen up to and including `t`, which then is the present.
    pub fn run_until(&mut self, t: Instant) {
        while let Some(at) = self.next_event().filter(|at| *at <= t) {
            self.now = at;
            self.step();
        }
        self.now = self.now.max(t);
    }

    /// Does what is due now; who has just become ready takes part in the arbitration that is due.
    fn step(&mut self) {
        let now = self.now;
        if let Some(transmission) = self.wire
            && instant(transmission.end_ns) <= now
        {
            self.finish(transmission);
        }
        for index in 0..self.noise.len() {
            if self.noise[index] <= now {
                self.noise.swap_remove(index);
                self.disturb();
                break;
            }
        }
        for attached in &mut self.devices {
            if attached.device.next_event().is_some_and(|at| at <= now) {
                attached.device.advance(now);
            }
        }
        if self.wire.is_none() && self.next_start().is_some_and(|at| instant(at) <= now) {
            self.arbitrate();
        }
    }

    /// The rate of a wire that has one of its own.
    fn fixed(&self) -> Option<BitRate> {
        match self.rate {
            BusRate::Fixed(rate) => Some(rate),
            BusRate::Follow => None,
        }
    }

    /// The bit rate of the wire.
    pub fn rate(&self) -> BitRate {
        self.fixed().unwrap_or_else(|| {
            let first = self.devices.first();
            first
                .and_then(|first| first.device.rate())
                .unwrap_or(FOLLOW_RATE)
        })
    }
}

/// A bit time in nanoseconds; a whole number for each of the ten rates.
fn bit_time(rate: BitRate) -> u64 {
    1_000_000_000 / u64::from(rate.bits_per_second())
}

/// The microsecond in which something happens, rounded up.
fn instant(ns: u64) -> Instant {
    Instant::from_ticks(ns.div_ceil(1000))
}

fn nanos(at: Instant) -> u64 {
    at.ticks() * 1000
}
