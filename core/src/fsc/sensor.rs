//! The FSC sensor as a [`Node`]: what it does with each input and when it acts by itself.

use super::code;
use super::cyclic::Cyclic;
use super::measured::Measured;
use super::request::Deferred;
use super::status::Status;
use super::table::values_size;
use super::table::{Model, Product};
use super::values::{Key, Values};
use super::wire::Reply;
use crate::can::{BitRate, Filter, Filters, Frame, standard};
use crate::measure::calibration::{self, Calibration};
use crate::measure::{Inclinometer, Reading};
use crate::node::{Action, Autobaud, Boot, BusEvent, BusMode, BusState, Indicator, Leds, Node};
use crate::node::{Pattern, Readout, TransmitQueue};
use crate::store::{PAYLOAD_MAX, Payload, StoreError};
use crate::time::{Duration, Instant, after, earlier, millis, reached};
use core::marker::PhantomData;
use embedded_can::Id;

/// How long a restart waits for replies that are still in the queue.
const RESTART_PATIENCE: Duration = millis(250);

/// Samples for which a clipped one still counts: 100 ms, so that vibration does not make the error bits flicker.
const CLIP_HOLD: u8 = 20;

/// The baud rates in the order of their codes 1 to 10 (section 9.10.3).
const BAUD_RATES: [BitRate; 10] = [
    BitRate::K10,
    BitRate::K20,
    BitRate::K50,
    BitRate::K100,
    BitRate::K125,
    BitRate::K250,
    BitRate::K500,
    BitRate::K800,
    BitRate::M1,
    BitRate::K62_5,
];

/// Whether the node takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Link {
    /// The bit rate is being detected.
    Detecting(Autobaud),
    /// On the bus.
    Online,
    /// Off the bus after too many errors.
    BusOff,
    /// A software reset was accepted; it happens when the queue is empty, at the latest at this time.
    Restarting(Instant),
    /// The restart has been asked for.
    Restarted,
}

/// What the running save writes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Saving {
    /// The parameters as they are (SAVE).
    Parameters,
    /// The factory values (LOAD).
    Factory,
}

/// The communication parameters in force since the last restart; written ones wait for the next.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct InForce {
    set: Id,
    set_value: u32,
    reply: Id,
    sync: Id,
}

/// Actions that wait to be polled.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Wanted {
    bus: Option<(BusMode, BitRate)>,
    recover: bool,
    save: bool,
}

/// A sensor of model `M`.
pub struct Sensor<M> {
    product: &'static Product,
    serial: u32,
    pub(super) values: Values,
    in_force: InForce,
    pub(super) status: Status,
    inclinometer: Inclinometer,
    pub(super) measured: Measured,
    clip_hold: u8,
    link: Link,
    bus_state: BusState,
    pub(super) cyclic: Option<Cyclic>,
    pub(super) saving: Option<Saving>,
    pub(super) deferred: Option<Deferred>,
    queue: TransmitQueue,
    indicator: Indicator,
    shown: Leds,
    wanted: Wanted,
    /// Something was handed in since the last poll that found nothing to do.
    attention: bool,
    wake: Option<Instant>,
    model: PhantomData<M>,
}

impl<M: Model> Sensor<M> {
    /// The size in bytes of the payload of an image: the values, then the calibration.
    pub const PAYLOAD: usize = {
        let size = values_size(M::RULES) + calibration::SIZE;
        assert!(size <= PAYLOAD_MAX);
        size
    };

    /// A sensor after power-up or a restart. An image that does not decode as a whole gives factory values and EEPROMError.
    pub fn new(product: &'static Product, now: Instant, boot: Boot) -> Self {
        let stored = boot.loaded.payload.as_ref();
        let image = stored.and_then(|payload| Self::decode(payload));
        let damaged = boot.loaded.damaged || (stored.is_some() && image.is_none());
        let factory = || (Values::factory(M::RULES), Calibration::IDENTITY);
        let (values, calibration) = image.unwrap_or_else(factory);
        let mut sensor = Self {
            product,
            serial: boot.serial,
            values,
            in_force: InForce::of(&values),
            status: Status(if damaged { Status::EEPROM_ERROR } else { 0 }),
            inclinometer: Inclinometer {
                calibration,
                ..Inclinometer::default()
            },
            measured: Measured::default(),
            clip_hold: 0,
            link: Link::Detecting(Autobaud::start(now)),
            bus_state: BusState::Active,
            cyclic: None,
            saving: None,
            deferred: None,
            queue: TransmitQueue::default(),
            indicator: Indicator::default(),
            shown: Leds::default(),
            wanted: Wanted::default(),
            attention: true,
            wake: None,
            model: PhantomData,
        };
        sensor.retune();
        sensor.update_status();
        match sensor.baud_rate() {
            Some(rate) => sensor.go_online(now, rate),
            None => sensor.listen(now),
        }
        sensor
    }

    fn decode(payload: &[u8]) -> Option<(Values, Calibration)> {
        let (values, calibration) = payload.split_at_checked(values_size(M::RULES))?;
        let calibration = Calibration::decode(calibration.try_into().ok()?)?;
        Some((Values::decode(M::RULES, values)?, calibration))
    }

    /// The fixed bit rate; None for automatic detection.
    fn baud_rate(&self) -> Option<BitRate> {
        let code = self.values.get(Key::BaudRate) as usize;
        BAUD_RATES.get(code.checked_sub(1)?).copied()
    }

    /// Listens at the candidate of the running search.
    fn listen(&mut self, now: Instant) {
        if let Link::Detecting(search) = self.link {
            self.wanted.bus = Some((BusMode::Listen, search.rate()));
        }
        self.show(now);
    }

    /// Takes part in the bus: two boot-up messages (section 9.6), then normal operation.
    fn go_online(&mut self, now: Instant, rate: BitRate) {
        self.link = Link::Online;
        self.wanted.bus = Some((BusMode::Normal, rate));
        self.reply_alive();
        self.reply_alive();
        self.restart_cyclic(now);
        self.show(now);
    }

    /// Cyclic mode as the parameter says, from counter 0.
    pub(super) fn restart_cyclic(&mut self, now: Instant) {
        let period = self.values.get(Key::CyclicTime);
        self.cyclic = self.values.is_cyclic().then(|| Cyclic::start(now, period));
    }

    /// Hands the filter parameter to the low-pass.
    pub(super) fn retune(&mut self) {
        let (kind, cutoff) = self.values.filter();
        // Only values that the filter takes get this far.
        let _ = self.inclinometer.low_pass.tune(kind, cutoff);
    }

    /// Derives the bits that follow from the parameters.
    pub(super) fn update_status(&mut self) {
        let mut bits = 0;
        if self.values.is_factory(M::RULES) {
            bits |= Status::DEFAULT_PARAM;
        }
        if self.values.get(Key::BaudRate) == 0 {
            bits |= Status::AUTOBAUD_DETECTION;
        }
        self.status
            .replace(Status::DEFAULT_PARAM | Status::AUTOBAUD_DETECTION, bits);
    }

    /// The LED patterns that fit the present state (table 12).
    fn show(&mut self, now: Instant) {
        let leds = M::LEDS;
        let error = match self.bus_state {
            BusState::Active => leds.working,
            BusState::Warning | BusState::Passive => leds.warning,
            BusState::BusOff => leds.bus_off,
        };
        let (run, error) = match self.link {
            Link::Detecting(_) => (leds.detecting, leds.working),
            Link::Online | Link::BusOff => (leds.normal, error),
            Link::Restarting(_) | Link::Restarted => (Pattern::Off, Pattern::Off),
        };
        self.indicator.show(now, run, error);
        self.attention = true;
    }

    /// Accepts a software reset: nothing more is taken in, the replies on their way still go out.
    pub(super) fn restart(&mut self, now: Instant) {
        self.link = Link::Restarting(after(now, RESTART_PATIENCE));
        self.cyclic = None;
        self.show(now);
    }

    /// Queues a reply without data.
    pub(super) fn reply(&mut self, fsc: u8) {
        self.send(Reply::new(fsc, self.status.0));
    }

    pub(super) fn send(&mut self, reply: Reply) {
        if let Some(frame) = reply.frame(self.in_force.reply) {
            self.queue.reply(frame);
        }
    }

    /// The inclination values (tables 21 and 22); the counter is there while cyclic mode is on.
    pub(super) fn inclination(&self) -> Reply {
        let mut reply = Reply::new(code::INCLINATION, self.status.0);
        let Readout { x, y } = self.readout();
        reply = reply.with(x as u32, 2);
        if let Some(y) = y {
            reply = reply.with(y as u32, 2);
        }
        match self.cyclic {
            Some(cyclic) => reply.with(cyclic.counter().into(), 2),
            None => reply,
        }
    }

    /// The boot-up message and alive frame (table 16).
    pub(super) fn reply_alive(&mut self) {
        let reply = Reply::new(code::ALIVE, self.status.0)
            .with(self.in_force.set_value, 4)
            .with(self.product.version.code().into(), 2);
        self.send(reply);
    }

    pub(super) fn reply_product(&mut self) {
        let reply = Reply::new(code::PRODUCT, self.status.0)
            .with(self.product.article, 4)
            .with(self.product.revision.into(), 2);
        self.send(reply);
    }

    pub(super) fn reply_serial(&mut self) {
        let reply = Reply::new(code::SERIAL, self.status.0)
            .with(self.serial, 4)
            .with(self.product.version.code().into(), 2);
        self.send(reply);
    }

    /// What the timers want done by now; only called when there may be something.
    fn tick(&mut self, now: Instant) {
        if let Link::Detecting(search) = &mut self.link
            && search.poll(now)
        {
            self.listen(now);
        }
        let due = self.cyclic.as_mut().is_some_and(|cyclic| cyclic.poll(now));
        if due && let Some(frame) = self.inclination().frame(self.in_force.reply) {
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
        match self.link {
            Link::Restarting(until) if self.queue.is_empty() || reached(now, until) => {
                self.link = Link::Restarted;
                Some(Action::Restart)
            }
            _ => None,
        }
    }

    /// Begins a save; its reply comes when the memory holds it.
    pub(super) fn begin_save(&mut self, saving: Saving) {
        self.saving = Some(saving);
        self.wanted.save = true;
    }

    fn next_deadline(&self) -> Option<Instant> {
        let link = match self.link {
            Link::Detecting(search) => Some(search.deadline()),
            Link::Restarting(until) => Some(until),
            Link::Online | Link::BusOff | Link::Restarted => None,
        };
        let cyclic = self.cyclic.map(|cyclic| cyclic.deadline());
        earlier(earlier(link, cyclic), self.indicator.deadline())
    }
}

impl InForce {
    fn of(values: &Values) -> Self {
        let identifier = |key| values.identifier(key).unwrap_or(standard(0));
        Self {
            set: identifier(Key::SetId),
            set_value: values.get(Key::SetId),
            reply: identifier(Key::ReplyId),
            sync: identifier(Key::SyncId),
        }
    }
}

impl<M: Model> Node for Sensor<M> {
    fn ready(&self) -> bool {
        let restarting = matches!(self.link, Link::Restarting(_) | Link::Restarted);
        self.queue.has_room() && self.deferred.is_none() && !restarting
    }

    fn receive(&mut self, now: Instant, frame: &Frame) {
        match self.link {
            // The frame that reveals the rate is not answered: the sensor was silent when it came.
            Link::Detecting(search) => self.go_online(now, search.rate()),
            Link::Online if frame.is_remote() => {}
            Link::Online if frame.id() == self.in_force.set => self.request(now, frame.bytes()),
            Link::Online if frame.id() == self.in_force.sync && frame.dlc() == 0 => {
                self.send(self.inclination());
            }
            _ => {}
        }
        self.attention = true;
    }

    fn sample(&mut self, _now: Instant, reading: &Reading) {
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
    }

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

    fn transmit(&mut self, _now: Instant) -> Option<Frame> {
        match self.link {
            Link::Online | Link::Restarting(_) => {
                let frame = self.queue.pop();
                // A restart waits for the queue to run empty.
                self.attention |= frame.is_some();
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
