//! How frames end, and what disturbs them.

use super::{Bus, DeviceId, ERROR_FRAME, LOG_MAX, Logged, Source, Transmission, bit_time, nanos};
use crate::bench::controller::{Failure, Hearing};
use crate::bench::frame_length::INTERMISSION;
use plumbline::can::BitRate;
use plumbline::node::BusState;

/// The bits that an error passive node waits after its own frame.
const SUSPEND: u32 = 8;

impl Bus {
    /// A frame, or the error frame that destroyed it, has ended: everybody learns what came of it.
    pub(super) fn finish(&mut self, transmission: Transmission) {
        let now = self.now;
        let Transmission {
            frame,
            source,
            rate,
            start,
            end_ns,
            ..
        } = transmission;
        self.wire = None;
        self.idle_ns = end_ns + bit_time(rate) * u64::from(INTERMISSION);
        let result = if self.torn_off(&transmission) {
            Err(Failure::Corrupted)
        } else {
            transmission.result
        };
        if result.is_ok() {
            if self.log.len() == LOG_MAX {
                self.log.pop_front();
            }
            self.log.push_back(Logged {
                at: now,
                frame,
                source,
            });
        }
        let fixed = self.fixed();
        for (id, adapter) in &mut self.adapters {
            match result {
                Ok(()) if source == Source::Adapter(*id) => adapter.transmitted(),
                Ok(()) if adapter.hears(fixed, start) => adapter.receive(now, frame),
                _ => {}
            }
        }
        for (index, attached) in self.devices.iter_mut().enumerate() {
            let device = &mut attached.device;
            if source == Source::Device(DeviceId(index)) {
                if device.boots() != transmission.boots || !device.is_on() {
                    continue;
                }
                let passive = device.bus_state() == Some(BusState::Passive);
                if passive {
                    let pause = bit_time(rate) * u64::from(SUSPEND);
                    attached.suspended_ns = self.idle_ns + pause;
                }
                match result {
                    Ok(()) => device.transmitted(now),
                    Err(failure) => device.not_transmitted(now, failure),
                }
                continue;
            }
            let hearing = device.hearing(rate, start);
            match result {
                Ok(()) => device.received(now, hearing, &frame),
                Err(Failure::Corrupted) => device.disturbed(now, hearing),
                // The receivers took the frame for good; the sender's error flag is not theirs.
                Err(Failure::NotAcknowledged) if hearing == Hearing::Garbled => {
                    device.disturbed(now, hearing);
                }
                Err(Failure::NotAcknowledged) => {}
            }
        }
    }

    /// True when the sender lost its power in the middle of the frame.
    fn torn_off(&self, transmission: &Transmission) -> bool {
        match transmission.source {
            Source::Device(id) => {
                let device = self.device(id);
                !device.is_on() || device.boots() != transmission.boots
            }
            Source::Adapter(_) => false,
        }
    }

    /// Noise, now: it destroys the frame on the wire, or is an error of its own.
    pub(super) fn disturb(&mut self) {
        let now = self.now;
        let rate = self.rate();
        if let Some(transmission) = &mut self.wire {
            if transmission.result.is_ok() {
                let error = bit_time(transmission.rate) * u64::from(ERROR_FRAME);
                transmission.end_ns = nanos(now) + error;
                transmission.result = Err(Failure::Corrupted);
            }
            return;
        }
        for attached in &mut self.devices {
            let hearing = attached.device.hearing(rate, now);
            attached.device.disturbed(now, hearing);
        }
        let bits = u64::from(ERROR_FRAME + INTERMISSION);
        self.idle_ns = self.idle_ns.max(nanos(now) + bit_time(rate) * bits);
    }

    /// An adapter at another rate than the wire's sends: whoever detects at yet another rate sees an error.
    pub(super) fn send_off_rate(&mut self, rate: BitRate) {
        let now = self.now;
        for attached in &mut self.devices {
            let hearing = attached.device.hearing(rate, now);
            if hearing == Hearing::Garbled {
                attached.device.disturbed(now, hearing);
            }
        }
    }
}
