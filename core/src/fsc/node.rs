//! The FSC sensor as a [`Node`]: what it does with each input, and when it acts by itself.

use super::code;
use super::key::Key;
use super::sensor::{InForce, Link, Saving, Sensor};
use super::status::Status;
use super::table::Model;
use super::values::Values;
use crate::can::{Filter, Filters, Frame};
use crate::measure::Reading;
use crate::node::{Action, BusEvent, BusState, Node, Readout};
use crate::store::{Payload, StoreError};
use crate::time::{Duration, Instant, after, earlier, millis, reached};

/// Samples for which a clipped one still counts: 100 ms, so that vibration does not make the error bits flicker.
const CLIP_HOLD: u8 = 20;

/// How long the angles hold without a further sample; then the accelerometer has failed, and the sensor errors say so.
const SAMPLE_LIMIT: Duration = millis(100);

impl<M: Model> Node for Sensor<M> {
    fn ready(&self) -> bool {
        let restarting = matches!(self.link, Link::Restarting(_) | Link::Restarted);
        self.queue.has_room() && self.deferred.is_none() && !restarting
    }

    #[inline(never)] // measured and budgeted as a function
    fn receive(&mut self, now: Instant, frame: &Frame) {
        match self.link {
            // The frame that reveals the rate is not answered: the sensor was silent when it came.
            Link::Detecting(search) => self.go_online(now, search.rate()),
            Link::Online if frame.is_remote() => {}
            Link::Online if frame.id() == self.in_force.set => self.request(now, frame),
            Link::Online if frame.id() == self.in_force.sync && frame.dlc() == 0 => {
                self.send(self.inclination());
            }
            _ => {}
        }
    }

    #[inline(never)] // measured and budgeted as a function
    fn sample(&mut self, now: Instant, reading: &Reading) {
        self.attention |= self.fresh_until.is_none();
        self.fresh_until = Some(after(now, SAMPLE_LIMIT));
        let up = self.inclinometer.sample(reading);
        self.measured = M::measure(up, self.product);
        if reading.clipped {
            self.clip_hold = CLIP_HOLD;
        }
        let mut errors = self.measured.errors;
        if self.clip_hold > 0 {
            self.clip_hold -= 1;
            errors = M::SENSOR_ERRORS;
        }
        self.status.replace(M::SENSOR_ERRORS, errors);
        self.keep_warm(now, reading.temperature);
    }

    #[inline(never)] // measured and budgeted as a function
    fn bus(&mut self, now: Instant, event: BusEvent) {
        match event {
            BusEvent::Error => {
                if let Link::Detecting(search) = &mut self.link {
                    search.error(now);
                    self.listen(now);
                }
            }
            BusEvent::Overrun => {}
            // Without recovery a sensor that went bus-off stays so until it is restarted, whatever the controller does.
            BusEvent::State(_) if self.link == Link::BusOff && !self.values.recovers() => {}
            BusEvent::State(state) => {
                self.bus_state = state;
                match (self.link, state) {
                    (Link::Online, BusState::BusOff) => {
                        self.link = Link::BusOff;
                        self.wanted.recover = self.values.recovers();
                    }
                    (Link::BusOff, BusState::Active | BusState::Warning | BusState::Passive) => {
                        self.link = Link::Online;
                    }
                    _ => {}
                }
                self.show(now);
            }
        }
        self.attention = true;
    }

    #[inline(never)] // measured and budgeted as a function
    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        let Some(saving) = self.saving.take() else {
            return;
        };
        if result.is_err() {
            self.status.raise(Status::STICKY);
        } else if saving == Saving::Factory {
            self.values = Values::factory(M::RULES);
            self.retune();
            self.restart_cyclic(now);
            self.update_status();
        }
        self.reply(match saving {
            Saving::Parameters => code::SAVE,
            Saving::Factory => code::LOAD,
        });
        self.resume(now);
        self.attention = true;
    }

    #[inline(never)] // measured and budgeted as a function
    fn poll(&mut self, now: Instant) -> Option<Action> {
        let due = self.wake.is_some_and(|wake| reached(now, wake));
        if !self.attention && !due {
            return None;
        }
        self.tick(now);
        let action = self.next_action(now);
        self.attention = action.is_some();
        self.wake = self.next_deadline();
        action
    }

    #[inline(never)] // measured and budgeted as a function
    fn transmit(&mut self, _now: Instant) -> Option<Frame> {
        match self.link {
            Link::Online | Link::Restarting(_) => {
                let frame = self.queue.pop();
                // A restart waits for the queue to run empty.
                self.attention |= self.link != Link::Online;
                frame
            }
            Link::Detecting(_) | Link::BusOff | Link::Restarted => None,
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.wake
    }

    fn filters(&self) -> Filters {
        let InForce { set, sync, .. } = self.in_force;
        Filters::from_slice(&[Filter::exact(set), Filter::exact(sync)]).unwrap_or_default()
    }

    #[inline(never)] // measured and budgeted as a function
    fn image(&self) -> Payload {
        let values = match self.saving {
            Some(Saving::Factory) => Values::factory(M::RULES),
            _ => self.values,
        };
        let mut payload = Payload::new();
        let calibration = self.inclinometer.calibration.encode();
        for byte in values.encode(M::RULES).chain(calibration) {
            // PAYLOAD bytes, and PAYLOAD_MAX is more: see the assertion there.
            let _ = payload.push(byte);
        }
        payload
    }

    fn readout(&self) -> Readout {
        let offset = |measured, key| M::with_offset(measured, self.values.get(key));
        Readout {
            x: offset(self.measured.x, Key::ZeroX),
            y: (M::AXES > 1).then(|| offset(self.measured.y, Key::ZeroY)),
        }
    }
}

impl<M: Model> Sensor<M> {
    /// What the timers want done by now; only called when there may be something.
    fn tick(&mut self, now: Instant) {
        if let Link::Detecting(search) = &mut self.link
            && search.poll(now)
        {
            self.listen(now);
        }
        if self.fresh_until.is_some_and(|until| reached(now, until)) {
            self.fresh_until = None;
            self.status.raise(M::SENSOR_ERRORS);
            self.stop_heating();
        }
        if core::mem::take(&mut self.wanted.boot_up) {
            self.reply_alive();
            self.reply_alive();
        }
        let due = self.cyclic.as_mut().is_some_and(|cyclic| cyclic.poll(now));
        if due {
            let frame = self.inclination().frame(self.in_force.reply);
            self.queue.cyclic(frame);
        }
    }

    /// The next action that is wanted, most urgent first.
    fn next_action(&mut self, now: Instant) -> Option<Action> {
        let leds = self.indicator.poll(now);
        if leds != self.shown {
            self.shown = leds;
            return Some(Action::Leds(leds));
        }
        if let Some((mode, rate)) = self.wanted.bus.take() {
            return Some(Action::Bus(mode, rate));
        }
        if core::mem::take(&mut self.wanted.recover) {
            return Some(Action::Recover);
        }
        if core::mem::take(&mut self.wanted.save) {
            return Some(Action::Save);
        }
        if let Some(action) = self.heater_action() {
            return Some(action);
        }
        match self.link {
            Link::Restarting(until) if self.queue.is_empty() || reached(now, until) => {
                self.link = Link::Restarted;
                Some(Action::Restart)
            }
            _ => None,
        }
    }

    fn next_deadline(&self) -> Option<Instant> {
        let link = match self.link {
            Link::Detecting(search) => Some(search.deadline()),
            Link::Restarting(until) => Some(until),
            Link::Online | Link::BusOff | Link::Restarted => None,
        };
        let cyclic = self.cyclic.map(|cyclic| cyclic.deadline());
        let own = earlier(link, earlier(cyclic, self.fresh_until));
        earlier(own, self.indicator.deadline())
    }
}
