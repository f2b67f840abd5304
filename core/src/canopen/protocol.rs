//! The protocol: timers, saves and faults. The received frames are in `receive.rs`.

use super::cob_id;
use super::consumer::Consumers;
use super::emcy::{self, Cause, Emergency, Fault};
use super::feature::{Feature, Initial};
use super::guarding::Guarding;
use super::nmt::State;
use super::pdo::{Tpdo, Tpdos};
use super::product::{ContextOf, ParametersOf, Product};
use super::row::Row;
use super::saved::Saved;
use super::sdo::Server;
use crate::application::{Application, Faults, Values};
use crate::can::{BitRate, CanId, Filter, Frame};
use crate::node::{BusChange, BusState, CanNode, Context, Patterns, Protocol, Restore};
use crate::param::Setting;
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant, Periodic};
use crate::update::Contact;

/// A node of product `P` with the CANopen protocol.
pub type CanopenNode<P> = CanNode<<P as Product>::Application, Canopen<P>>;

/// The CANopen protocol for product `P`.
///
/// A node can have another protocol besides, whose messages transport the SDOs while [`Product::HOSTED`] says so. Such a node, the host,
/// implements [`Protocol`] with the functions below and those of [`Protocol`] for `Canopen`, as
/// [`CanopenOrJ1939`](crate::model::dual::CanopenOrJ1939) does:
///
/// | function of the host     | CANopen is on the bus                   | it is [hosted](Self::is_hosted)                            |
/// |--------------------------|-----------------------------------------|------------------------------------------------------------|
/// | `restored`, `start`      | the same function                       | the same function, then the other protocol goes online     |
/// | `receive`                | [`route`](Self::route), then [`serve`](Self::serve) | [`serve`](Self::serve) with the identifier of the reply |
/// | `tick`, step 0           | the same function                       | [`resets_hosted`](Self::resets_hosted)                      |
/// | `tick`, step 1           | the same function                       | [`tick_hosted`](Self::tick_hosted)                          |
/// | `proceed`                | the same function                       | the same function                                           |
/// | `stored`                 | the same function                       | [`stored_hosted`](Self::stored_hosted)                      |
/// | `bus_changed`            | the same function                       | the same function: it counts the faults                     |
/// | `deadlines`              | the same function                       | [`deadline_hosted`](Self::deadline_hosted)                  |
/// | `filters`, `published`   | the same function                       | those of the other protocol                                 |
pub struct Canopen<P: Product> {
    pub(super) sdo: Server<&'static Row, P::Text, P::Block>,
    pub(super) services: Services<P>,
}

/// All services except the SDO server, which accesses them.
pub(super) struct Services<P: Product> {
    /// The contents of the nonvolatile memory, and the kind of a running save.
    pub(super) saved: Saved<P>,
    /// The node-ID in force, which a configuration changes at the next reset only.
    pub(super) node_id: u8,
    /// The bit rate in force.
    pub(super) rate: BitRate,
    /// The identifier of the SYNC in force; None if the node sends it itself.
    pub(super) sync: Option<CanId>,
    pub(super) state: State,
    /// Another protocol is on the bus and accesses the objects ([`Product::HOSTED`]).
    pub(super) is_hosted: bool,
    pub(super) tpdos: P::Tpdos,
    pub(super) emergency: Emergency<P::History>,
    /// The faults of the application that were reported last.
    faults: Faults,
    pub(super) guarding: Guarding,
    pub(super) consumers: P::Consumers,
    pub(super) lss: P::Lss,
    /// The state of the own objects of the product.
    pub(super) own: P::State,
    /// The number of TPDOs that must still handle the last SYNC.
    pub(super) unsynchronised: u8,
    /// A change of the data of a TPDO is an event, as of the last steps of [`tick`](Protocol::tick). What changes this wakes the node up.
    pub(super) watches: bool,
    /// In [`State::Initialising`]: the delay of a reset.
    pub(super) heartbeat: Periodic,
    /// The earliest deadline. Each step of [`tick`](Protocol::tick) considers its own one: all of them in one step would take too
    /// long for a frame that waits.
    pub(super) earliest: Deadline,
}

impl<P: Product> Services<P> {
    pub(super) const MEMORY: u8 = emcy::bits_of(&P::FAULTS, Cause::Memory);
    const OVERRUN: u8 = emcy::bits_of(&P::FAULTS, Cause::Overrun);
    pub(super) const PASSIVE: u8 = emcy::bits_of(&P::FAULTS, Cause::Passive);
    pub(super) const GUARDING: u8 = emcy::bits_of(&P::FAULTS, Cause::Guarding);
    const BUS_OFF: u8 = emcy::bits_of(&P::FAULTS, Cause::BusOff);
    const OVERRUN_EVENT: Option<Fault> = emcy::event_of(P::EVENTS, Cause::Overrun);
    const BUS_OFF_EVENT: Option<Fault> = emcy::event_of(P::EVENTS, Cause::BusOff);
    const CAUSES: emcy::Causes = emcy::causes(&P::FAULTS);
    /// The bits that faults of the application cause.
    const APPLICATION: u8 = emcy::caused(Self::CAUSES, Faults(u16::MAX));
    const FAULTS: &'static [emcy::Fault; 8] = &emcy::faults(&P::FAULTS);

    pub(super) const SYNC_COB_ID: Setting =
        Setting::at_or(P::OBJECTS, 0x1005, 0, cob_id::SYNC_DEFAULT as u32);
    pub(super) const GUARD_TIME: Setting = Setting::at(P::OBJECTS, 0x100C, 0);
    /// Whether the product has node guarding.
    pub(super) const HAS_GUARDING: bool = matches!(Self::GUARD_TIME, Setting::Parameter(_));
    pub(super) const LIFE_TIME_FACTOR: Setting = Setting::at(P::OBJECTS, 0x100D, 0);
    pub(super) const EMCY_COB_ID: Setting = Setting::at(P::OBJECTS, 0x1014, 0);
    pub(super) const EMCY_INHIBIT_TIME: Setting = Setting::at(P::OBJECTS, 0x1015, 0);
    pub(super) const HEARTBEAT_TIME: Setting = Setting::at(P::OBJECTS, 0x1017, 0);
    const ERROR_BEHAVIOUR: Setting = Setting::at(P::OBJECTS, 0x1029, 1);
    pub(super) const START_UP: Setting = Setting::at(P::OBJECTS, 0x1F80, 0);
}

impl<P: Product> Canopen<P> {
    /// Whether layer setting services (CiA 305) are supported.
    pub const LSS: bool = P::Lss::PRESENT;

    /// Sends the next segment of a block upload when all other frames have left the queue, so that they do not wait for it.
    fn stream(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.sdo.is_streaming() && cx.shell.is_online() && !cx.shell.is_sending() {
            let segment = self.sdo.next_segment(now);
            self.services.send_sdo(cx, segment);
        }
    }

    /// Handles the time-out of life guarding, or the loss of the heartbeat of a node: sends an emergency message and performs the error
    /// behaviour (1029h).
    pub(super) fn lose_master(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        /// Error behaviour (1029h): no change of the NMT state.
        const NO_CHANGE: u32 = 1;
        /// Error behaviour (1029h): the node becomes stopped.
        const STOP: u32 = 2;
        self.services.report_guarding(cx);
        // Before the node stops: then it sends no more.
        while self.services.send_emergency(cx, now) {}
        match Services::<P>::ERROR_BEHAVIOUR.get(&cx.parameters) {
            NO_CHANGE => {}
            STOP => self.enter(cx, now, State::Stopped),
            _ if self.services.state == State::Operational => {
                self.enter(cx, now, State::PreOperational);
            }
            _ => {}
        }
    }
}

impl<P: Product> Restore for Canopen<P> {
    type Application = P::Application;
    const IMAGE: ImageId = P::IMAGE;

    fn restored(&mut self, parameters: &mut ParametersOf<P>, damaged: bool) {
        let services = &mut self.services;
        services.saved.parameters = *parameters;
        services.emergency.start(Services::<P>::FAULTS);
        services.begin(parameters);
        services.select_protocol(parameters);
        if damaged {
            services
                .emergency
                .update(Services::<P>::MEMORY, Services::<P>::MEMORY);
        }
    }
}

impl<P: Product> Protocol<P::Application> for Canopen<P> {
    // The heartbeat, the TPDOs, and one emergency message.
    const FRAMES: usize = 2 + P::Tpdos::COUNT;
    // NMT, SYNC, SDO requests, guarding, remote frames for the TPDOs, heartbeats, and LSS requests.
    const FILTERS: usize = 4 + P::Tpdos::COUNT + P::Consumers::COUNT + P::Lss::PRESENT as usize;

    const INITIAL: Self = Self {
        sdo: Server::IDLE,
        services: Services {
            saved: Saved::INITIAL,
            node_id: 0,
            rate: BitRate::K10,
            sync: None,
            state: State::Initialising,
            is_hosted: false,
            tpdos: P::Tpdos::INITIAL,
            emergency: Emergency::INITIAL,
            faults: Faults::NONE,
            guarding: Guarding::OFF,
            consumers: P::Consumers::INITIAL,
            lss: P::Lss::INITIAL,
            own: P::State::INITIAL,
            unsynchronised: 0,
            watches: false,
            heartbeat: Periodic::OFF,
            earliest: Deadline::NEVER,
        },
    };

    fn start(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.reset_communication(cx, now);
    }

    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if let Some(reply) = self.route(cx, now, frame) {
            self.serve(cx, now, frame, reply);
        }
    }

    fn published(&mut self, cx: &mut ContextOf<P>, _now: Instant) {
        if cx.values.faults() != self.services.faults
            || P::TRIGGERS.changes && self.services.watches
        {
            cx.shell.wake_up();
        }
    }

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        if change == BusChange::Recovered {
            self.services.resume_flicker(now);
        }
        let emergency = &mut self.services.emergency;
        let passive = match cx.shell.bus_state() {
            BusState::Passive => Services::<P>::PASSIVE,
            _ => 0,
        };
        match change {
            BusChange::Overrun => match Services::<P>::OVERRUN_EVENT {
                Some(event) => emergency.momentary(event),
                None => emergency.event(Services::<P>::OVERRUN),
            },
            BusChange::State if cx.shell.bus_state() != BusState::BusOff => {
                emergency.update(Services::<P>::PASSIVE, passive);
            }
            BusChange::Recovered => {
                match Services::<P>::BUS_OFF_EVENT {
                    Some(event) => emergency.momentary(event),
                    None => emergency.event(Services::<P>::BUS_OFF),
                }
                emergency.update(Services::<P>::PASSIVE, passive);
            }
            BusChange::State | BusChange::Online | BusChange::Unsent => {}
        }
        self.services.show(cx);
    }

    fn recovers(&self, parameters: &ParametersOf<P>) -> bool {
        P::RECOVERS.is_none_or(|recovers| recovers(parameters))
    }

    fn stored(
        &mut self,
        cx: &mut ContextOf<P>,
        _now: Instant,
        saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) {
        let succeeded = result.is_ok();
        self.services.end_save(cx, saved, succeeded);
        let reply = self.sdo.stored(succeeded);
        self.services.send_sdo(cx, reply);
        self.services.stored_lss(cx, succeeded);
    }

    // A frame between two steps that changes a deadline wakes the node up: then all steps follow again.
    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        match step {
            0 => {
                if P::TRIGGERS.changes {
                    self.services.watches = false;
                }
                self.services.take_faults(cx.values.faults());
                if self.services.guarding.poll(now) {
                    self.lose_master(cx, now);
                }
                self.services.earliest = self.services.guarding.deadline();
                self.tick_consumers(cx, now);
            }
            1 => {
                if let Some(expired) = self.sdo.poll(now) {
                    self.services.send_sdo(cx, Some(expired));
                }
                self.stream(cx, now);
                if self.services.resets(now) {
                    self.reset_node(cx, now);
                }
                self.tick_lss(cx, now);
                self.services.earliest.consider(self.sdo.deadline());
                if let Some(lss) = self.services.lss.get() {
                    lss.consider(&mut self.services.earliest);
                }
            }
            2 => self.services.send_heartbeat(cx, now),
            _ => {
                return self.services.send_event(cx, now, usize::from(step - 3))
                    || self.services.send_fault(cx, now);
            }
        }
        true
    }

    fn proceed(&mut self, cx: &mut ContextOf<P>) -> bool {
        self.services.synchronise_next(cx)
    }

    fn waits_for_room(&self) -> bool {
        self.services.emergency.is_waiting() || self.sdo.is_streaming()
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        earliest.consider(self.services.earliest);
    }

    fn contact(&self, cx: &ContextOf<P>) -> Option<Contact> {
        Some(self.services.contact(cx))
    }

    fn address(&self) -> Option<u32> {
        Some(self.services.node_id.into())
    }

    fn filters(&self, _cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        let services = &self.services;
        if P::Lss::PRESENT {
            accept(Filter::exact(CanId::standard(cob_id::LSS_REQUEST)));
        }
        if services.is_unconfigured() {
            return;
        }
        let node_id = u16::from(services.node_id);
        let own = [
            cob_id::NMT,
            cob_id::SDO_REQUEST + node_id,
            cob_id::ERROR_CONTROL + node_id,
        ];
        services
            .sync
            .into_iter()
            .map(Filter::exact)
            .for_each(&mut *accept);
        let tpdos = services.tpdos.all().iter().map(Tpdo::id);
        services
            .heard_ids()
            .map(Filter::exact)
            .for_each(&mut *accept);
        for id in own.into_iter().chain(tpdos) {
            accept(Filter::exact(CanId::standard(id)));
        }
    }
}

impl<P: Product> Services<P> {
    /// Reports a life guarding time-out or the loss of a heartbeat, or its end, as a fault.
    pub(super) fn report_guarding(&mut self, cx: &mut ContextOf<P>) {
        let fault = if self.has_lost() { Self::GUARDING } else { 0 };
        self.emergency.update(Self::GUARDING, fault);
        self.show(cx);
    }

    /// Whether life guarding has timed out, or the heartbeat of a node is lost.
    fn has_lost(&self) -> bool {
        self.guarding.failed() || self.lost()
    }

    /// Takes over changed faults of the application.
    pub(super) fn take_faults(&mut self, faults: Faults) {
        if faults != self.faults {
            self.faults = faults;
            let bits = emcy::caused(Self::CAUSES, faults);
            self.emergency.want(Self::APPLICATION, bits);
        }
    }

    fn send_heartbeat(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.heartbeat.poll(now) {
            let id = CanId::standard(cob_id::ERROR_CONTROL + u16::from(self.node_id));
            let state = self.state as u8;
            cx.shell.send_cyclic(Frame::word(id, state.into(), 1));
        }
        self.earliest.consider(self.heartbeat.deadline());
    }

    /// Announces one fault of the application and sends one emergency message, after the last TPDO. Both are in one step, so that a
    /// frame waits for a fault only if its answer waits for the emergency message. Returns false if there is nothing more.
    fn send_fault(&mut self, cx: &mut ContextOf<P>, now: Instant) -> bool {
        let more = self.emergency.announce_next();
        let sent = self.emergency.is_waiting() && self.send_emergency(cx, now);
        self.earliest.consider(self.emergency.deadline());
        more || sent
    }

    /// Sends the next emergency message. Returns false if there is none, or if it must wait.
    fn send_emergency(&mut self, cx: &mut ContextOf<P>, now: Instant) -> bool {
        // `is_due` must be called first: it also ends the inhibit time.
        if self.emergency.is_due(now)
            && cx.shell.is_online()
            && self.state.communicates()
            && cx.shell.has_room()
            && let Some(message) = self.emergency.take(now)
        {
            let id = self.on_bus(Self::EMCY_COB_ID.get(&cx.parameters));
            if let Some(id) = self.emergency_id(id) {
                self.emergency.told(&message);
                let [low, high, register, status, ..] = message;
                let additional = P::additional(status);
                let message = u32::from_le_bytes([low, high, register, additional]);
                cx.shell.send(Frame::word(id, message.into(), 8));
            }
            return true;
        }
        false
    }

    /// Shows the LED patterns of the present state. Another protocol on the bus shows its own.
    pub(super) fn show(&self, cx: &mut ContextOf<P>) {
        if self.is_hosted() {
            return;
        }
        let leds = &P::LEDS;
        let run = match self.state {
            State::PreOperational => leds.pre_operational,
            State::Operational => leds.operational,
            State::Stopped | State::Initialising => leds.stopped,
        };
        let error = match cx.shell.bus_state() {
            BusState::Active | BusState::Warning | BusState::Passive if self.has_lost() => {
                leds.guarding
            }
            state => leds.error.of(state),
        };
        let mut patterns = Patterns {
            run,
            error,
            ..Patterns::default()
        };
        let bus_off = cx.shell.bus_state() == BusState::BusOff;
        self.overlay_flicker(&mut patterns, bus_off);
        cx.shell.show(patterns);
    }

    /// Queues a reply of the SDO server, if there is one.
    pub(super) fn send_sdo(&self, cx: &mut ContextOf<P>, reply: Option<[u8; 8]>) {
        let id = CanId::standard(cob_id::SDO_REPLY + u16::from(self.node_id));
        send_reply(cx, id, reply);
    }
}

/// Queues a reply of the SDO server with this identifier, if there is one.
pub(super) fn send_reply<A: Application>(cx: &mut Context<A>, id: CanId, reply: Option<[u8; 8]>) {
    if let Some(bytes) = reply {
        cx.shell.send(Frame::word(id, u64::from_le_bytes(bytes), 8));
    }
}

/// Queues a frame that must not be lost.
pub(super) fn send<A: Application>(cx: &mut Context<A>, id: u16, data: &[u8]) {
    if let Some(frame) = Frame::data(crate::can::standard(id), data) {
        cx.shell.send(frame);
    }
}
