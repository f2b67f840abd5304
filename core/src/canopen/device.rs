//! The CANopen device: what it consists of, how it starts, and its NMT states.

use super::dictionary::{Found, Home, find, stored_size};
use super::emcy::{self, Emergency};
use super::guarding::Guarding;
use super::key::{Key, TPDOS};
use super::model::Model;
use super::nmt::State;
use super::pdo::{Mapping, Tpdo};
use super::saving::Saving;
use super::sdo::Transfer;
use super::timer::Periodic;
use super::values::Values;
use super::wire;
use crate::can::{BitRate, Frame, standard};
use crate::measure::Calibration;
use crate::measure::calibration;
use crate::node::{Boot, BusState, Indicator, Leds, Pattern, TransmitQueue};
use crate::store::{ImageId, PAYLOAD_MAX};
use crate::time::{Duration, Instant, after, millis};
use core::mem::MaybeUninit;

/// How long the angles hold without a further sample; then the accelerometer has failed.
pub(super) const SAMPLE_LIMIT: Duration = millis(100);

/// How long a restart waits for replies that are still in the queue.
const RESTART_PATIENCE: Duration = millis(250);

/// The error behaviour that leaves the NMT state as it is (1029h).
const NO_CHANGE: u32 = 1;
/// The error behaviour that stops the node.
const STOP: u32 = 2;
/// The NMT start-up that starts all nodes (1F80h).
const START_ALL: u32 = 2;
/// The NMT start-up that starts this node only.
const START_SELF: u32 = 8;

/// Whether the node takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Link {
    /// On the bus.
    Online,
    /// Off the bus after too many errors.
    BusOff,
    /// A restart was asked for; it happens when the queue is empty, at the latest at this time.
    Restarting(Instant),
    /// The restart has been asked for.
    Restarted,
}

/// What the controller has to know to be on the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Addresses {
    pub(super) rate: BitRate,
    pub(super) node_id: u8,
    pub(super) sync: u16,
    pub(super) tpdos: [Option<u16>; TPDOS],
}

/// Actions that wait to be polled.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Wanted {
    pub(super) bus: bool,
    pub(super) recover: bool,
    pub(super) save: bool,
}

/// A sensor of model `M`.
pub struct Device<M> {
    pub(super) model: M,
    pub(super) serial: u32,
    /// The values as they are.
    pub(super) values: Values,
    /// The values in nonvolatile memory.
    pub(super) saved: Values,
    /// The node id in force.
    pub(super) node_id: u8,
    pub(super) rate: BitRate,
    /// What the controller was last told.
    pub(super) addresses: Option<Addresses>,
    pub(super) state: State,
    pub(super) link: Link,
    pub(super) bus_state: BusState,
    pub(super) tpdos: [Tpdo; TPDOS],
    pub(super) emergency: Emergency,
    pub(super) guarding: Guarding,
    pub(super) heartbeat: Periodic,
    pub(super) transfer: Transfer,
    pub(super) saving: Option<Saving>,
    /// A request that waits for the running save to end.
    pub(super) deferred: Option<Frame>,
    /// Without a further sample the angles are out of date then; None: they are.
    pub(super) fresh_until: Option<Instant>,
    pub(super) queue: TransmitQueue,
    pub(super) indicator: Indicator,
    pub(super) shown: Leds,
    pub(super) wanted: Wanted,
    /// Something was handed in since the last poll that found nothing to do.
    pub(super) attention: bool,
    pub(super) wake: Option<Instant>,
}

impl<M: Model> Device<M> {
    /// Marks the images of this model.
    pub const IMAGE: ImageId = M::IMAGE;

    /// The size in bytes of the payload of an image: the values, then the calibration.
    pub const PAYLOAD: usize = {
        let hidden = (M::HIDDEN.end - M::HIDDEN.start) as usize;
        let size = stored_size(M::OBJECTS, hidden) + calibration::SIZE;
        assert!(size <= PAYLOAD_MAX);
        size
    };

    /// A sensor after power-up or a restart. An image that does not decode as a whole gives factory values and the hardware fault.
    pub fn new(now: Instant, boot: Boot) -> Self {
        let mut device = Self::assemble(now, &boot);
        device.begin(now);
        device
    }

    /// As [`new`](Self::new), for a small stack: the sensor is on it for a moment only, before it gets its place and begins.
    pub fn place<'a>(place: &'a mut MaybeUninit<Self>, now: Instant, boot: &Boot) -> &'a mut Self {
        let device = Self::put(place, now, boot);
        device.begin(now);
        device
    }

    #[inline(never)] // what assembling puts on the stack is gone when the sensor begins
    fn put<'a>(place: &'a mut MaybeUninit<Self>, now: Instant, boot: &Boot) -> &'a mut Self {
        place.write(Self::assemble(now, boot))
    }

    /// The parts of a sensor that has not begun yet.
    fn assemble(now: Instant, boot: &Boot) -> Self {
        let stored = boot.loaded.payload.as_ref();
        let image = stored.and_then(|payload| Self::decode(payload));
        let damaged = boot.loaded.damaged || (stored.is_some() && image.is_none());
        let factory = (*M::FACTORY, Calibration::IDENTITY);
        let (saved, calibration) = image.unwrap_or(factory);
        let mut emergency = Emergency::new(M::FAULTS);
        if damaged {
            emergency.update(emcy::HARDWARE, emcy::HARDWARE);
        }
        Self {
            model: M::new(calibration),
            serial: boot.serial,
            values: saved,
            saved,
            node_id: 1,
            rate: BitRate::K125,
            addresses: None,
            state: State::PreOperational,
            link: Link::Online,
            bus_state: BusState::Active,
            tpdos: Default::default(),
            emergency,
            guarding: Guarding::default(),
            heartbeat: Periodic::default(),
            transfer: Transfer::default(),
            saving: None,
            deferred: None,
            fresh_until: Some(after(now, SAMPLE_LIMIT)),
            queue: TransmitQueue::default(),
            indicator: Indicator::default(),
            shown: Leds::default(),
            wanted: Wanted::default(),
            attention: true,
            wake: None,
        }
    }

    /// Begins with what the parameters say.
    fn begin(&mut self, now: Instant) {
        self.model.configure(&self.values);
        self.reset_communication(now);
    }

    /// Starts anew with the stored values. Node id and bit rate are taken along even when they are not stored.
    pub(super) fn reset_node(&mut self, now: Instant) {
        let mut values = self.saved;
        values.copy(&self.values, M::TAKEN_ALONG);
        self.values = values;
        self.model.configure(&values);
        // The history begins anew; the faults that still are begin again behind the boot-up message. A master that was lost is
        // none of them: guarding begins anew as well.
        let faults = self.emergency.present() & !emcy::GUARDING;
        self.emergency = Emergency::new(M::FAULTS);
        self.reset_communication(now);
        self.emergency.update(faults, faults);
    }

    /// Starts the communication anew with its stored values, the node id and the bit rate.
    pub(super) fn reset_communication(&mut self, now: Instant) {
        self.node_id = M::node_id(&self.values);
        self.rate = M::bit_rate(&self.values);
        let communication = M::RULES.iter().filter(|rule| rule.is_communication());
        for rule in communication {
            let Some(slot) = rule.home.slot() else {
                continue;
            };
            let source = if rule.is_stored() {
                self.saved.at(slot)
            } else {
                M::FACTORY.at(slot)
            };
            let node_id = if rule.is_node_relative() {
                self.node_id
            } else {
                0
            };
            self.values.set(slot, source + u32::from(node_id));
        }
        self.transfer.end();
        self.queue.clear();
        self.state = State::PreOperational;
        self.guarding = Guarding::default();
        self.configure_guarding(now);
        self.heartbeat.start(now, self.values.get(Key::Heartbeat));
        self.emergency.configure(self.values.get(Key::EmcyInhibit));
        for (number, tpdo) in (0..TPDOS as u8).zip(&mut self.tpdos) {
            *tpdo = Tpdo::new(mapping::<M>(number));
        }
        self.configure_tpdos(now);
        self.start_up(now);
        self.show(now);
    }

    /// The boot-up message, and what comes after it (1F80h).
    fn start_up(&mut self, now: Instant) {
        self.send(wire::ERROR_CONTROL + u16::from(self.node_id), &[0]);
        let start_up = self.values.get(Key::StartUp);
        if start_up == START_ALL {
            self.send(wire::NMT, &[1, 0]);
        }
        if start_up == START_ALL || start_up == START_SELF {
            self.enter(now, State::Operational);
        }
    }

    /// Tells the controller the identifiers and the bit rate, when they have changed.
    pub(super) fn readdress(&mut self) {
        let [first, second] = &self.tpdos;
        let addresses = Addresses {
            rate: self.rate,
            node_id: self.node_id,
            sync: (self.values.get(Key::SyncId) & 0x7FF) as u16,
            tpdos: [first.id(), second.id()],
        };
        if self.addresses != Some(addresses) {
            self.addresses = Some(addresses);
            self.wanted.bus = true;
        }
    }

    /// Enters an NMT state.
    pub(super) fn enter(&mut self, now: Instant, state: State) {
        if state == self.state {
            return;
        }
        self.state = state;
        for tpdo in &mut self.tpdos {
            if state == State::Operational {
                tpdo.start(now);
            } else {
                tpdo.stop();
                if let Some(id) = tpdo.id() {
                    self.queue.withdraw(standard(id));
                }
            }
        }
        if !state.communicates() {
            self.transfer.end();
        }
        self.show(now);
    }

    /// The guarding master is silent: an emergency, and what 1029h says.
    pub(super) fn master_lost(&mut self, now: Instant) {
        self.tell_guarding(now);
        match self.values.get(Key::ErrorBehaviour) {
            NO_CHANGE => {}
            STOP => self.enter(now, State::Stopped),
            _ if self.state == State::Operational => self.enter(now, State::PreOperational),
            _ => {}
        }
    }

    /// Announces what has become of the guarding master.
    pub(super) fn tell_guarding(&mut self, now: Instant) {
        let fault = if self.guarding.failed() {
            emcy::GUARDING
        } else {
            0
        };
        self.emergency.update(emcy::GUARDING, fault);
        self.show(now);
    }

    /// The LED patterns that fit the present state.
    pub(super) fn show(&mut self, now: Instant) {
        let leds = &M::LEDS;
        let run = match self.state {
            State::PreOperational => leds.pre_operational,
            State::Operational => leds.operational,
            State::Stopped => leds.stopped,
        };
        let error = match self.bus_state {
            BusState::BusOff => leds.bus_off,
            _ if self.guarding.failed() => leds.guarding,
            BusState::Warning | BusState::Passive => leds.warning,
            BusState::Active => leds.working,
        };
        let (run, error) = match self.link {
            Link::Online | Link::BusOff => (run, error),
            Link::Restarting(_) | Link::Restarted => (Pattern::Off, Pattern::Off),
        };
        self.indicator.show(now, run, error);
        self.attention = true;
    }

    /// Accepts a restart: nothing more is taken in, the replies on their way still go out.
    pub(super) fn restart(&mut self, now: Instant) {
        self.link = Link::Restarting(after(now, RESTART_PATIENCE));
        self.heartbeat.stop();
        for tpdo in &mut self.tpdos {
            tpdo.stop();
        }
        self.show(now);
    }

    /// Queues a frame that must not be lost.
    pub(super) fn send(&mut self, id: u16, data: &[u8]) {
        if let Some(frame) = Frame::data(standard(id), data) {
            self.queue.reply(frame);
        }
    }

    /// Queues a reply of the SDO server.
    pub(super) fn send_sdo(&mut self, bytes: &[u8; 8]) {
        let id = standard(wire::SDO_REPLY + u16::from(self.node_id));
        self.queue
            .reply(Frame::word(id, u64::from_le_bytes(*bytes), 8));
    }

    /// The present data of a TPDO.
    pub(super) fn compose(&self, tpdo: &Tpdo) -> Option<Frame> {
        let (mut data, mut length) = (0_u64, 0);
        // From the last object to the first, because shifts of 64 bits by a constant are cheap.
        for (rule, sub) in tpdo.mapping().iter().rev() {
            let value = u64::from(self.number(rule, *sub));
            let size = rule.data_type().size();
            // A signed number comes with more bits than it has.
            data = match size {
                1 => data << 8 | value & 0xFF,
                2 => data << 16 | value & 0xFFFF,
                _ => data << 32 | value,
            };
            length += size;
        }
        let id = standard(tpdo.id()?);
        Some(Frame::word(id, data, length))
    }
}

/// The objects that the fixed mapping of a TPDO (1A00h, 1A01h) names.
fn mapping<M: Model>(number: u8) -> Mapping {
    let parameter = 0x1A00 + u16::from(number);
    let mut mapping = Mapping::new();
    for sub in 1..=Mapping::new().capacity() as u8 {
        let Found::Row(rule) = find(M::RULES, parameter, sub) else {
            break;
        };
        let Home::Constant(entry) = rule.home else {
            break;
        };
        let [_, sub, low, high] = entry.to_le_bytes();
        if let Found::Row(mapped) = find(M::RULES, u16::from_le_bytes([low, high]), sub) {
            let _ = mapping.push((mapped, sub));
        }
    }
    mapping
}
