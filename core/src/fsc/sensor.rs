//! The FSC sensor: what it consists of, how it starts, and the replies that it composes.

use super::code;
use super::cyclic::Cyclic;
use super::heating::Heating;
use super::key::Key;
use super::measured::Measured;
use super::status::Status;
use super::table::values_size;
use super::table::{Model, Product};
use super::values::Values;
use super::wire::Reply;
use crate::can::{BitRate, Frame, standard};
use crate::measure::Inclinometer;
use crate::measure::calibration::{self, Calibration};
use crate::node::{Autobaud, Boot, BusMode, BusState, Indicator, Leds, Node};
use crate::node::{Pattern, Readout, TransmitQueue};
use crate::store::PAYLOAD_MAX;
use crate::time::{Duration, Instant, after, millis};
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use embedded_can::Id;

/// How long a restart waits for replies that are still in the queue.
const RESTART_PATIENCE: Duration = millis(250);

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
pub(super) enum Link {
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
pub(super) struct InForce {
    pub(super) set: Id,
    pub(super) set_value: u32,
    pub(super) reply: Id,
    pub(super) sync: Id,
}

/// Actions that wait to be polled.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Wanted {
    pub(super) bus: Option<(BusMode, BitRate)>,
    /// The boot-up messages, composed when everything else has had its say.
    pub(super) boot_up: bool,
    pub(super) recover: bool,
    pub(super) save: bool,
}

/// A sensor of model `M`.
pub struct Sensor<M> {
    pub(super) product: &'static Product,
    pub(super) serial: u32,
    pub(super) values: Values,
    pub(super) in_force: InForce,
    pub(super) status: Status,
    pub(super) inclinometer: Inclinometer,
    pub(super) measured: Measured,
    pub(super) clip_hold: u8,
    /// There exactly where the model has a heater.
    pub(super) heating: Option<Heating>,
    /// Without a further sample the angles are out of date then; None: they are.
    pub(super) fresh_until: Option<Instant>,
    pub(super) link: Link,
    pub(super) bus_state: BusState,
    pub(super) cyclic: Option<Cyclic>,
    pub(super) saving: Option<Saving>,
    /// A request that waits for the running save to end.
    pub(super) deferred: Option<Frame>,
    pub(super) queue: TransmitQueue,
    pub(super) indicator: Indicator,
    pub(super) shown: Leds,
    pub(super) wanted: Wanted,
    /// There may be something to do or another deadline since the last poll that found nothing: whoever causes that says so here,
    /// because a poll in vain costs as much as a request.
    pub(super) attention: bool,
    pub(super) wake: Option<Instant>,
    pub(super) model: PhantomData<M>,
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
        let mut sensor = Self::assemble(product, now, &boot);
        sensor.begin(now);
        sensor
    }

    /// As [`new`](Self::new), for a small stack: the sensor is on it for a moment only, before it gets its place and begins.
    pub fn place<'a>(
        place: &'a mut MaybeUninit<Self>,
        product: &'static Product,
        now: Instant,
        boot: &Boot,
    ) -> &'a mut Self {
        let sensor = Self::put(place, product, now, boot);
        sensor.begin(now);
        sensor
    }

    #[inline(never)] // what assembling puts on the stack is gone when the sensor begins
    fn put<'a>(
        place: &'a mut MaybeUninit<Self>,
        product: &'static Product,
        now: Instant,
        boot: &Boot,
    ) -> &'a mut Self {
        place.write(Self::assemble(product, now, boot))
    }

    /// The parts of a sensor that has not begun yet.
    fn assemble(product: &'static Product, now: Instant, boot: &Boot) -> Self {
        let stored = boot.loaded.payload.as_ref();
        let image = stored.and_then(|payload| Self::decode(payload));
        let damaged = boot.loaded.damaged || (stored.is_some() && image.is_none());
        let factory = || (Values::factory(M::RULES), Calibration::IDENTITY);
        let (values, calibration) = image.unwrap_or_else(factory);
        let mut status = Status::default();
        if damaged {
            status.raise(Status::EEPROM_ERROR);
        }
        // Until the first sample there is no angle.
        status.raise(M::SENSOR_ERRORS);
        if M::HEATER.is_some() {
            status.raise(Status::ACCURACY_WARNING);
        }
        Self {
            product,
            serial: boot.serial,
            values,
            in_force: InForce::of(&values),
            status,
            inclinometer: Inclinometer {
                calibration,
                ..Inclinometer::default()
            },
            measured: Measured::default(),
            clip_hold: 0,
            heating: M::HEATER.map(Heating::new),
            fresh_until: None,
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
        }
    }

    /// Begins with what the parameters say.
    fn begin(&mut self, now: Instant) {
        self.retune();
        self.update_status();
        match self.baud_rate() {
            Some(rate) => self.go_online(now, rate),
            None => self.listen(now),
        }
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
    pub(super) fn listen(&mut self, now: Instant) {
        if let Link::Detecting(search) = self.link {
            self.wanted.bus = Some((BusMode::Listen, search.rate()));
        }
        self.show(now);
    }

    /// Takes part in the bus: two boot-up messages (section 9.6), then normal operation.
    pub(super) fn go_online(&mut self, now: Instant, rate: BitRate) {
        self.link = Link::Online;
        self.wanted.bus = Some((BusMode::Normal, rate));
        self.wanted.boot_up = true;
        self.restart_cyclic(now);
        self.show(now);
    }

    /// Cyclic mode as the parameter says, from counter 0.
    pub(super) fn restart_cyclic(&mut self, now: Instant) {
        let period = self.values.get(Key::CyclicTime);
        self.cyclic = self.values.is_cyclic().then(|| Cyclic::start(now, period));
        self.attention = true;
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
        if self.values.is_factory() {
            bits |= Status::DEFAULT_PARAM;
        }
        if self.values.get(Key::BaudRate) == 0 {
            bits |= Status::AUTOBAUD_DETECTION;
        }
        self.status
            .replace(Status::DEFAULT_PARAM | Status::AUTOBAUD_DETECTION, bits);
    }

    /// The LED patterns that fit the present state (table 12).
    pub(super) fn show(&mut self, now: Instant) {
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
        self.stop_heating();
        self.show(now);
    }

    /// Queues a reply without data.
    pub(super) fn reply(&mut self, fsc: u8) {
        self.send(Reply::new(fsc, self.status.0));
    }

    pub(super) fn send(&mut self, reply: Reply) {
        self.queue.reply(reply.frame(self.in_force.reply));
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

    /// Begins a save; its reply comes when the memory holds it.
    pub(super) fn begin_save(&mut self, saving: Saving) {
        self.saving = Some(saving);
        self.wanted.save = true;
        self.attention = true;
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
