//! The bit rate of the wire, and how the bus leads a detecting sensor to it.
//!
//! A detecting sensor that listens at a wrong rate sees a pulse of one bit of the wire, which no other participant sees, and
//! measures the rate of the wire.

use super::adapters::Connected;
use super::{Attached, Bus, BusRate, FOLLOW_RATE};
use can_wire::protocol::{BitTiming, Picoseconds, Protocol};
use plumbline::can::BitRate;

/// Largest clock deviation, in parts of a bit, at which two bit rates are treated as equal.
const SAME_RATE: Picoseconds = 32;

/// The time between two pulses: the firmware measures a pulse when the wire is silent after it, then changes the rate.
const PATIENCE: Picoseconds = 20_000_000_000;

impl Bus {
    /// From now on the bus leads every detecting sensor to the bit rate of the wire, as earlier traffic would have done, until it
    /// takes part. The firmware of a sensor needs some 5 ms for that. On a wire that follows its sensor, the bus always does this.
    pub fn lead_detection(&mut self) {
        self.leading = true;
    }

    /// The bit rate of the wire; on a wire with several rates, that of the first sensor.
    pub fn rate(&self) -> BitRate {
        match self.rate {
            BusRate::Fixed(rate) => rate,
            BusRate::Follow | BusRate::Wire => self
                .devices
                .first()
                .and_then(|first| first.sensor.rate())
                .unwrap_or(FOLLOW_RATE),
        }
    }

    /// True when a controller has the rate of the wire.
    pub(super) fn has_rate(&self, protocol: &Protocol) -> bool {
        let wire = self.timing.bit;
        protocol.timing().bit.abs_diff(wire) < wire / SAME_RATE
    }

    /// The timing of an adapter that was opened with this rate; None when it is not connected.
    pub(super) fn adapter_timing(&self, own: Option<BitRate>) -> Option<BitTiming> {
        match (self.rate, own) {
            (BusRate::Fixed(rate), Some(own)) if own != rate => None,
            (BusRate::Wire, Some(own)) => Some(BitTiming::of(own)),
            _ => Some(self.timing),
        }
    }

    /// Sets the wire to the timing of the first sensor, unless the wire has a fixed rate. While the sensor detects, the wire
    /// waits at 250 kbit/s.
    pub(super) fn follow(&mut self) {
        if matches!(self.rate, BusRate::Fixed(_)) {
            return;
        }
        let Some(first) = self.devices.first() else {
            return;
        };
        let Some(protocol) = first.sensor.protocol().filter(|one| one.is_on()) else {
            return;
        };
        let timing = if protocol.is_silent() {
            BitTiming::of(FOLLOW_RATE)
        } else if self.has_rate(protocol) {
            return;
        } else {
            let rate = first.sensor.rate();
            rate.map_or(protocol.timing(), BitTiming::of)
        };
        // A frame that the sensor has received is complete for its sender one bit later.
        let is_at_end = |(one, _): &Connected| one.protocol.is_at_end_of_frame();
        let is_ending = self.adapters.values().any(is_at_end);
        if timing == self.timing || is_ending {
            return;
        }
        self.timing = timing;
        let (now, rate) = (self.time, self.rate);
        for (adapter, _) in self.adapters.values_mut() {
            if rate == BusRate::Follow || adapter.own_rate().is_none() {
                adapter.join(now, timing);
            }
        }
        if self.assistant.0.is_on() {
            self.assistant.0.join(now, timing, true);
        }
    }

    /// False while the wire follows a detecting sensor that does not listen yet at the rate at which an adapter would send.
    pub(super) fn is_led(&self) -> bool {
        let first = self.devices.first();
        let Some(protocol) = first.and_then(|first| first.sensor.protocol()) else {
            return true;
        };
        self.rate != BusRate::Follow
            || !protocol.is_silent()
            || (self.has_rate(protocol) && (protocol.is_idle() || protocol.is_busy()))
    }

    /// When a sensor that the bus leads to the bit rate sees the next pulse.
    pub(super) fn next_pulse(&self, attached: &Attached) -> Option<Picoseconds> {
        let protocol = attached.sensor.protocol()?;
        let lost = protocol.is_silent() && protocol.is_idle() && !self.has_rate(protocol);
        let until = attached.line.pulsed_until();
        (lost && self.leads(attached)).then(|| until.map_or(0, |until| until + PATIENCE))
    }

    /// True when the bus may have to lead a sensor.
    pub(super) fn may_lead(&self) -> bool {
        let silent = |one: &Attached| one.sensor.protocol().is_some_and(Protocol::is_silent);
        self.devices
            .iter()
            .any(|one| silent(one) && self.leads(one))
    }

    fn leads(&self, attached: &Attached) -> bool {
        match self.rate {
            BusRate::Fixed(_) => self.leading,
            BusRate::Wire => false,
            BusRate::Follow => {
                let first = self.devices.first();
                first.is_some_and(|first| std::ptr::eq(first, attached))
                    && self.adapters.values().any(|(one, _)| one.queued() > 0)
            }
        }
    }

    /// Sends a pulse to the sensors that listen at a wrong rate and have to be led.
    pub(super) fn lead(&mut self) {
        for index in 0..self.devices.len() {
            let attached = &self.devices[index];
            if self.next_pulse(attached).is_some_and(|at| at <= self.time) {
                self.devices[index].line.pulse(self.time, self.timing.bit);
            }
        }
        let takes_part = |one: &Protocol| one.is_on() && !one.is_silent();
        self.leading &= !self
            .devices
            .iter()
            .all(|attached| attached.sensor.protocol().is_some_and(takes_part));
    }
}
