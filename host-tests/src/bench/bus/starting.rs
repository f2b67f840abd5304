//! How frames start: who waits, who wins arbitration, and what will come of the frame.

use super::{
    Bus, BusRate, DeviceId, ERROR_FRAME, FOLLOW_RATE, Source, Transmission, bit_time, instant,
    nanos,
};
use crate::bench::adapter::Adapter;
use crate::bench::controller::{Failure, Hearing};
use crate::bench::frame_length::{END_OF_FRAME, arbitration, frame_bits};
use plumbline::can::{BitRate, Frame};
use plumbline::node::{BusMode, BusState};
use plumbline::time::Instant;

/// How many bus errors a detecting device gets at most before it must have come to a rate.
const LEAD_TRIES: usize = 64;

impl Bus {
    /// True when somebody acknowledges a frame of device `sender` that starts at `start`.
    fn acknowledged(&self, sender: usize, start: Instant) -> bool {
        let (fixed, rate) = (self.fixed(), self.rate());
        self.adapters
            .values()
            .any(|adapter| adapter.acknowledges(fixed, start))
            || self.devices.iter().enumerate().any(|(index, other)| {
                index != sender && other.device.hearing(rate, start) == Hearing::Full
            })
    }

    /// The frame that a device could send, and when at the earliest. An error passive device that nobody would acknowledge
    /// waits: it would repeat for ever without any counter changing.
    fn candidate(&self, index: usize) -> Option<(u64, Frame)> {
        let attached = &self.devices[index];
        let frame = attached.device.pending(self.rate())?;
        let passive = attached.device.bus_state() == Some(BusState::Passive);
        (!passive || self.acknowledged(index, self.now))
            .then_some((attached.suspended_ns.max(self.idle_ns), frame))
    }

    /// When the next frame could start, in nanoseconds.
    pub(super) fn next_start(&self) -> Option<u64> {
        let devices = (0..self.devices.len()).filter_map(|index| self.candidate(index));
        let adapter = self.adapters.values().find_map(Adapter::pending);
        devices
            .map(|(at, _)| at)
            .chain(adapter.map(|_| self.idle_ns))
            .min()
    }

    /// Lets the strongest of those that wait send.
    pub(super) fn arbitrate(&mut self) {
        let now = self.now;
        let mut contenders: Vec<(u64, Frame, Source)> = (0..self.devices.len())
            .filter_map(|index| {
                let (at, frame) = self.candidate(index)?;
                Some((at, frame, Source::Device(DeviceId(index))))
            })
            .filter(|(at, ..)| instant(*at) <= now)
            .collect();
        let device_waits = !contenders.is_empty();
        let adapters_give_way = self.adapters.values().any(|adapter| adapter.gives_way);
        contenders.extend(
            self.adapters
                .iter()
                .filter(|_| !(device_waits && adapters_give_way))
                .filter_map(|(id, adapter)| Some((*id, adapter.pending()?)))
                .map(|(id, frame)| (self.idle_ns, frame, Source::Adapter(id))),
        );
        let winner = contenders
            .into_iter()
            .min_by_key(|(_, frame, _)| arbitration(frame));
        for adapter in self.adapters.values_mut() {
            adapter.gives_way = false;
        }
        if let Some((at, frame, source)) = winner {
            // A frame that was already waiting starts with the first bit after the intermission, any other with its tick.
            let start_ns = if instant(at) == now { at } else { nanos(now) };
            self.begin(start_ns, frame, source);
        }
    }

    fn begin(&mut self, start_ns: u64, frame: Frame, source: Source) {
        let start = self.now;
        let mut boots = 0;
        let mut result = Ok(());
        match source {
            Source::Device(DeviceId(index)) => {
                if !self.acknowledged(index, start) {
                    result = Err(Failure::NotAcknowledged);
                }
                let device = &mut self.devices[index].device;
                boots = device.boots();
                device.start();
            }
            Source::Adapter(id) => {
                self.lead_to_follow_rate();
                if let Some(adapter) = self.adapters.get_mut(&id) {
                    adapter.start();
                }
            }
        }
        if self.unacknowledged > 0 {
            self.unacknowledged -= 1;
            result = Err(Failure::NotAcknowledged);
        }
        if self.corrupt.0 > 0 && self.corrupt.1.is_none_or(|of| of == source) {
            self.corrupt.0 -= 1;
            result = Err(Failure::Corrupted);
        }
        // A missing acknowledge shows in the ACK slot, a wrong CRC after the ACK delimiter.
        let bits = match result {
            Ok(()) => frame_bits(&frame),
            Err(Failure::NotAcknowledged) => frame_bits(&frame) - END_OF_FRAME - 1 + ERROR_FRAME,
            Err(Failure::Corrupted) => frame_bits(&frame) - END_OF_FRAME + ERROR_FRAME,
        };
        let rate = self.rate();
        self.wire = Some(Transmission {
            frame,
            source,
            boots,
            rate,
            start,
            end_ns: start_ns + bit_time(rate) * u64::from(bits),
            result,
        });
    }

    /// On a wire that follows its device: leads a detecting device to 250 kbit/s before an adapter's frame starts.
    fn lead_to_follow_rate(&mut self) {
        if self.rate == BusRate::Follow && !self.devices.is_empty() {
            self.lead(0, FOLLOW_RATE);
        }
    }

    /// Gives every detecting device bus errors until it listens at the rate of the wire, as earlier traffic would have done. On a
    /// wire that follows its device this happens by itself.
    pub fn lead_detection(&mut self) {
        if let BusRate::Fixed(rate) = self.rate {
            (0..self.devices.len()).for_each(|index| self.lead(index, rate));
        }
    }

    fn lead(&mut self, index: usize, rate: BitRate) {
        let now = self.now;
        let device = &mut self.devices[index].device;
        for _ in 0..LEAD_TRIES {
            if device.mode() != Some(BusMode::Listen) || device.rate() == Some(rate) {
                return;
            }
            device.disturbed(now, Hearing::Garbled);
        }
    }
}
