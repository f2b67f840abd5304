//! Advances virtual time: bit by bit while the wire is busy, in larger steps while it is idle.

use super::{
    AdapterId, Attached, Bus, BusRate, DeviceId, LOG_MAX, Logged, Source, instant, picoseconds,
};
use can_wire::frame_length::arbitration;
use can_wire::protocol::{ErrorCode, Event, Picoseconds, Protocol};
use plumbline::can::Frame;
use plumbline::time::Instant;

/// Largest time difference between several free-running sensors when one of them acts: a bit at the highest rate.
const QUANTUM: Picoseconds = 1_000_000;

/// Bits after the frame of an adapter during which a sensor goes first: the intermission and a start of frame.
const GIVE_WAY: Picoseconds = 4;

/// An attempt to send a frame has ended without an acknowledge.
const NOT_ACKNOWLEDGED: Event = Event::Error {
    code: ErrorCode::Acknowledgment,
    transmitting: true,
};

/// The earlier of two times.
fn earliest(one: Option<Picoseconds>, other: Option<Picoseconds>) -> Option<Picoseconds> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}

/// The result of one step of a controller.
struct Brought {
    source: Source,
    event: Event,
    /// The frame that it sends.
    frame: Option<Frame>,
    start: Picoseconds,
    end: Picoseconds,
}

impl Bus {
    /// Runs the simulation up to and including `t`, which then is the current time.
    pub fn run_until(&mut self, t: Instant) {
        let end = picoseconds(t).max(self.time);
        self.follow();
        self.settle();
        loop {
            let due = self.next_step();
            let target = due.map_or(end, |at| at.min(end)).min(self.horizon());
            self.time = self.let_run(target).max(self.time);
            if due.is_some_and(|at| at <= self.time) {
                self.step();
                self.run_bits(end);
                self.skip_attempts(end);
            } else if self.time >= end {
                return;
            } else {
                self.follow();
                self.settle();
            }
        }
    }

    /// How far free-running sensors may go before the others are stepped: until the first of them acts.
    fn horizon(&self) -> Picoseconds {
        let free = || {
            let sensors = self.devices.iter().map(|attached| &attached.sensor);
            sensors.filter(|sensor| sensor.runs_freely())
        };
        if free().count() > 1 {
            let acts = free().filter_map(|sensor| sensor.next_event()).min();
            acts.unwrap_or_default().max(self.time + QUANTUM)
        } else {
            Picoseconds::MAX
        }
    }

    /// Lets the free-running sensors advance to `target`, or until the first of them needs attention.
    fn let_run(&mut self, target: Picoseconds) -> Picoseconds {
        self.devices
            .iter_mut()
            .filter(|attached| attached.sensor.runs_freely())
            .fold(target, |target, attached| {
                attached.sensor.advance(target).min(target)
            })
    }

    /// The time of the next event on the wire, in a controller, or in a sensor that does not run freely.
    pub(super) fn next_step(&self) -> Option<Picoseconds> {
        let offering = self.offering();
        let devices = self.devices.iter().filter_map(|one| one.sensor.next_step());
        let adapters = self
            .adapters
            .iter()
            .filter_map(|(id, (adapter, _))| adapter.protocol.next_event(offering.contains(id)));
        let (assistant, _) = &self.assistant;
        devices
            .chain(adapters)
            .chain(assistant.next_event(false))
            .chain(self.next_beside())
            .min()
            .map(|at| at.max(self.time))
    }

    /// The time of the next event that is not a bit of a controller.
    pub(super) fn next_beside(&self) -> Option<Picoseconds> {
        let now = self.time;
        let devices = self.devices.iter().flat_map(|attached| {
            let Attached { sensor, line } = attached;
            let own = sensor.next_event().filter(|_| !sensor.runs_freely());
            [own, line.next_event(now), self.next_pulse(attached)]
        });
        let adapters = self
            .adapters
            .values()
            .flat_map(|(adapter, line)| [line.next_event(now), adapter.receives_until(now), None]);
        let disturbances = self.disturbances.iter().map(|span| span.next(now));
        let ended = self.ended.front().map(|(end, _)| *end);
        let waited = self.adapters_wait().then_some(self.adapters_wait_until);
        devices
            .chain(adapters)
            .chain(disturbances)
            .chain([ended, waited])
            .flatten()
            .min()
    }

    /// Steps from bit to bit as long as there are no other events: faster than [`Self::step`], for most of the run time. A single
    /// free-running sensor is advanced to each bit.
    fn run_bits(&mut self, end: Picoseconds) {
        let free = self.devices.iter().filter(|one| one.sensor.runs_freely());
        if free.count() > 1 || self.may_lead() || self.wishes.is_pending() {
            return;
        }
        let beside = self.next_beside().unwrap_or(Picoseconds::MAX);
        while let Some(at) = self.next_bit()
            && at <= end
            && at < beside
            && !self.may_lead()
        {
            let reached = self.let_run(at);
            self.time = reached.max(self.time);
            self.follow();
            if reached < at {
                self.settle();
                return;
            }
            let looks = self.step_controllers(&[]);
            self.settle();
            if looks || !self.disturbances.is_empty() {
                return;
            }
        }
    }

    /// When the next bit of a controller begins or is sampled, or a sensor's controller changes; None when a controller may begin a
    /// frame.
    fn next_bit(&self) -> Option<Picoseconds> {
        let (assistant, _) = &self.assistant;
        let mut next = assistant.next_event(false);
        for Attached { sensor, .. } in &self.devices {
            if let Some(protocol) = sensor.protocol() {
                if protocol.takes_offer() && sensor.offered().is_some() {
                    return None;
                }
                next = earliest(next, sensor.next_step());
            }
        }
        for (adapter, _) in self.adapters.values() {
            if adapter.protocol.takes_offer() && adapter.queued() > 0 {
                return None;
            }
            next = earliest(next, adapter.protocol.next_event(false));
        }
        next
    }

    /// Processes everything that is due now.
    fn step(&mut self) {
        let now = self.time;
        for attached in &mut self.devices {
            let sensor = &mut attached.sensor;
            if !sensor.runs_freely() && sensor.next_event().is_some_and(|at| at <= now) {
                sensor.advance(now);
            }
        }
        self.follow();
        let offering = self.offering();
        self.step_controllers(&offering);
        self.intervene();
        self.lead();
        self.deliver();
        self.settle();
    }

    /// Steps every controller that is due; true when one of them returned an event.
    fn step_controllers(&mut self, offering: &[AdapterId]) -> bool {
        let devices = self.step_devices();
        let adapters = self.step_adapters(offering);
        let (assistant, line) = &mut self.assistant;
        line.step(self.time, assistant, None);
        devices || adapters
    }

    fn step_devices(&mut self) -> bool {
        let mut any = false;
        for index in 0..self.devices.len() {
            let Attached { sensor, line } = &mut self.devices[index];
            let Some(event) = line.step_sensor(self.time, sensor.as_mut()) else {
                continue;
            };
            let Some(protocol) = sensor.protocol() else {
                continue;
            };
            let brought = Brought {
                source: Source::Device(DeviceId(index)),
                event,
                frame: line.sending,
                start: protocol.frame_start(),
                end: protocol.bit_start(),
            };
            self.note(brought);
            any = true;
        }
        any
    }

    fn step_adapters(&mut self, offering: &[AdapterId]) -> bool {
        let now = self.time;
        let mut all = Vec::new();
        for (id, (adapter, line)) in self.adapters.iter_mut() {
            let offered = adapter.offered().filter(|_| offering.contains(id));
            if let Some(event) = line.step(now, &mut adapter.protocol, offered) {
                adapter.note(now, event);
                all.push(Brought {
                    source: Source::Adapter(*id),
                    event,
                    frame: line.sending,
                    start: adapter.protocol.frame_start(),
                    end: adapter.protocol.bit_start(),
                });
            }
        }
        let any = !all.is_empty();
        all.into_iter().for_each(|brought| self.note(brought));
        any
    }

    fn note(&mut self, brought: Brought) {
        if let (NOT_ACKNOWLEDGED, Source::Device(id)) = (brought.event, brought.source) {
            self.attempts.failed = Some(id);
        }
        let (Event::Transmitted, Some(frame)) = (brought.event, brought.frame) else {
            return;
        };
        if matches!(brought.source, Source::Adapter(_)) {
            self.adapters_wait_until = brought.end + GIVE_WAY * self.timing.bit;
        }
        let logged = Logged {
            start: brought.start,
            at: instant(brought.end),
            frame,
            source: brought.source,
        };
        self.ended.push_back((brought.end, logged));
    }

    /// Logs the frames whose last bit has ended.
    fn deliver(&mut self) {
        while let Some((end, logged)) = self.ended.front().copied()
            && end <= self.time
        {
            self.ended.pop_front();
            if self.log.len() == LOG_MAX {
                self.log.pop_front();
            }
            self.log.push_back(logged);
        }
    }

    /// True when adapters may begin a frame: no sensor with a waiting frame goes first, and all sensors are ready to receive.
    fn adapters_send(&self) -> bool {
        self.adapters
            .values()
            .any(|(adapter, _)| adapter.queued() > 0)
            && !(self.adapters_wait() && self.devices.iter().any(|one| self.waits(one)))
            && self.is_led()
            && !self.an_adapter_joins()
            && !self.devices.iter().any(|one| self.is_unready(one))
    }

    /// True while a sensor would see an error instead of the start of an adapter's frame: after 11 recessive bits an adapter takes
    /// part, but a sensor that nobody has acknowledged may still be in its error frame. On [`BusRate::Wire`] it sees the error.
    fn is_unready(&self, attached: &Attached) -> bool {
        let unready = |one: &Protocol| one.refuses_start_of_frame() && self.is_connected(one);
        self.rate != BusRate::Wire && attached.sensor.protocol().is_some_and(unready)
    }

    /// True while an opened adapter does not take part yet. Its client expects to receive every frame from now on, so the others
    /// wait. On [`BusRate::Wire`] they do not wait.
    fn an_adapter_joins(&self) -> bool {
        let mut adapters = self.adapters.values();
        self.rate != BusRate::Wire && adapters.any(|(adapter, _)| adapter.protocol.is_joining())
    }

    /// The adapters that offer their frames.
    fn offering(&self) -> Vec<AdapterId> {
        if !self.adapters_send() {
            return Vec::new();
        }
        self.adapters
            .iter()
            .filter_map(|(id, (adapter, _))| {
                let frame = adapter.offered()?;
                let offers = adapter.protocol.takes_offer() && !self.is_held(*id, &frame);
                offers.then_some(*id)
            })
            .collect()
    }

    /// True when another adapter goes first with the same identifier: two clients on one bus must not collide. With
    /// [`BusRate::Wire`] they do.
    fn is_held(&self, id: AdapterId, frame: &Frame) -> bool {
        let same = |other: &Frame| arbitration(other) == arbitration(frame);
        self.rate != BusRate::Wire
            && self.adapters.iter().any(|(other, (adapter, _))| {
                let protocol = &adapter.protocol;
                let first = protocol.is_transmitting() || (*other < id && protocol.can_send());
                *other != id && first && adapter.offered().as_ref().is_some_and(same)
            })
    }

    fn adapters_wait(&self) -> bool {
        self.gives_way && self.time < self.adapters_wait_until
    }

    /// True when a sensor has a frame that it could send next.
    fn waits(&self, attached: &Attached) -> bool {
        let can_send = |one: &Protocol| one.can_send() && self.is_connected(one);
        attached.sensor.protocol().is_some_and(can_send) && attached.sensor.offered().is_some()
    }
}
