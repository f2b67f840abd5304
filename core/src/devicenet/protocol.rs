//! The protocol: received frames, I/O messages, timers and saves.

use super::allocation::ConnectionSet;
use super::duplicate_check::{self, DuplicateCheck, Step};
use super::explicit::{self, Data, FRAGMENT, Failure, Request, is_response, service};
use super::fragment::{self, Kind, Receiver, Sender};
use super::identifiers::{Group1, group_2, group_2_id, message_of};
use super::leds::{Light, StatusLeds};
use super::objects;
use super::production::{AcknowledgeHandler, Production, Words};
use super::projection::AssemblyRow;
use super::saving::Saving;
use super::table::Product;
use crate::application::{Application, Faults, Values};
use crate::can::{BitRate, CanId, Filter, Frame};
use crate::node::{BusChange, BusState, Context, Protocol};
use crate::param::{ParameterId, Parameters, meaning};
use crate::store::StoreError;
use crate::time::{Deadline, Duration, Instant, millis};
use core::marker::PhantomData;

/// The parameters of product `P`.
pub(super) type ParametersOf<P> = Parameters<<<P as Product>::Application as Application>::Table>;

/// The published values of product `P`.
type ValuesOf<P> = <<P as Product>::Application as Application>::Values;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as Product>::Application>;

/// The longest time that a change of the MAC ID waits until its answer is sent.
const READDRESS_PATIENCE: Duration = millis(250);

/// What follows when the answer to a request is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Departure {
    /// Nothing.
    None,
    /// The node checks its new MAC ID.
    Readdress,
    /// The node restarts when its parameters are stored.
    Restart,
}

/// The DeviceNet protocol for product `P`.
pub struct Devicenet<P: Product> {
    /// The MAC ID in force.
    pub(super) mac: u8,
    /// The bit rate in force.
    rate: BitRate,
    check: DuplicateCheck,
    pub(super) connections: ConnectionSet,
    /// The assembly in poll responses, while the poll connection is allocated.
    polled: Option<&'static AssemblyRow>,
    /// The assembly in COS and cyclic messages, while their connection is established.
    produced: Option<&'static AssemblyRow>,
    pub(super) production: Production,
    pub(super) handler: AcknowledgeHandler,
    receiver: Receiver,
    sender: Sender,
    pub(super) saving: Saving<P::Application>,
    departure: Departure,
    /// The end of the wait of [`Departure::Readdress`].
    patience: Deadline,
    /// The number of times that the controller has gone bus-off.
    pub(super) bus_offs: u8,
    leds: StatusLeds,
    /// The last published values have a fault.
    faulted: bool,
    /// The earliest deadline. Each step of [`tick`](Protocol::tick) considers its own ones.
    earliest: Deadline,
    product: PhantomData<P>,
}

/// The row of the assembly that a parameter selects.
pub(super) fn selected<P: Product>(
    cx: &ContextOf<P>,
    id: ParameterId,
) -> Option<&'static AssemblyRow> {
    let instance = cx.parameters.get(id);
    let mut rows = P::ASSEMBLY_ROWS.iter();
    rows.find(|row| u32::from(row.instance) == instance)
}

/// The words of an assembly.
#[inline(always)] // on the path of a poll
pub(super) fn words<P: Product>(assembly: &AssemblyRow, values: &ValuesOf<P>) -> Words {
    let mut words = [0; 4];
    for (word, id) in words.iter_mut().zip(assembly.words()) {
        *word = values.number(id) as u16;
    }
    words
}

/// Words as the data of a frame.
#[inline(always)] // on the path of a poll
pub(super) fn pack([a, b, c, d]: Words) -> u64 {
    let low = u32::from(a) | u32::from(b) << 16;
    let high = u32::from(c) | u32::from(d) << 16;
    u64::from(high) << 32 | u64::from(low)
}

impl<P: Product> Devicenet<P> {
    /// Takes the stored parameters. `damaged`: the stored record is damaged or not usable.
    pub(super) fn restored(&mut self, parameters: &ParametersOf<P>, damaged: bool) {
        self.saving.start(parameters, damaged);
        self.handler = AcknowledgeHandler::DEFAULT;
        let code = parameters.get(P::ROLES.baud_rate);
        self.rate = meaning(P::ROLES.bit_rates, code).unwrap_or(BitRate::K125);
    }

    /// Leaves the network after the answer to the present request: all connections are released at once.
    pub(super) fn depart(&mut self, cx: &mut ContextOf<P>, now: Instant, departure: Departure) {
        self.departure = departure;
        self.patience = Deadline::after(now, READDRESS_PATIENCE);
        self.check.stop();
        self.release_all(cx);
    }

    /// Releases all connections.
    fn release_all(&mut self, cx: &mut ContextOf<P>) {
        self.connections = ConnectionSet::EMPTY;
        self.follow(cx);
    }

    /// Takes the MAC ID from the parameters, and checks it.
    fn readdress(&mut self, cx: &mut ContextOf<P>) {
        self.departure = Departure::None;
        self.mac = cx.parameters.get(P::ROLES.mac_id) as u8;
        self.discard(cx);
        self.check.start();
        self.send_check(cx, false);
        cx.shell.wake_up();
    }

    /// Discards all frames that are not sent yet, also those in mailboxes, and sets the filters.
    fn discard(&self, cx: &mut ContextOf<P>) {
        cx.shell.clear_queue();
        cx.shell.go_online(self.rate);
    }

    /// Sends a message of the duplicate MAC ID check.
    fn send_check(&self, cx: &mut ContextOf<P>, is_response: bool) {
        let (data, length) =
            duplicate_check::message(is_response, P::IDENTITY.vendor, cx.shell.serial());
        self.send(cx, group_2::DUPLICATE_CHECK, data, length);
    }

    /// Queues a frame of group 2.
    #[inline(always)] // on the path of a read
    fn send(&self, cx: &mut ContextOf<P>, message: u16, data: u64, length: u8) {
        let id = CanId::standard(group_2_id(self.mac, message));
        cx.shell.send(Frame::word(id, data, length));
    }

    /// Handles a message of the duplicate MAC ID check.
    #[inline(never)] // rarely called
    fn check_duplicate(&mut self, cx: &mut ContextOf<P>, frame: &Frame) {
        match self.check.receive(frame) {
            Step::Respond => self.send_check(cx, true),
            Step::Fault => {
                self.release_all(cx);
                self.discard(cx);
            }
            Step::None | Step::Request | Step::Online => {}
        }
    }

    /// Answers a poll command. One with data is not consumed: the consumed size is 0.
    #[inline(always)] // the shortest path
    fn answer_poll(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if frame.dlc() != 0 || !self.connections.is_polled() {
            return;
        }
        let Some(assembly) = self.polled else {
            return;
        };
        let id = CanId::standard(Group1::PollResponse.id(self.mac));
        let data = pack(words::<P>(assembly, &cx.values));
        cx.shell.send(Frame::word(id, data, assembly.size()));
        if self.connections.polled(now) {
            cx.shell.wake_up();
        }
    }

    /// Handles a frame on the explicit connection.
    #[inline(always)] // on the path of a read
    fn explicit(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let &[header, ref body @ ..] = frame.bytes() else {
            return;
        };
        let Some(&service) = body.first() else {
            return;
        };
        if !self.connections.hears(header & explicit::MAC) {
            return;
        }
        if header & FRAGMENT != 0 {
            return self.fragment(cx, now, header, body);
        }
        if !is_response(service) {
            self.receiver.stop();
            self.serve(cx, now, header, body);
        }
    }

    /// Handles a fragment of a request, or the acknowledge of a fragment of a response.
    #[inline(never)] // rarely called
    fn fragment(&mut self, cx: &mut ContextOf<P>, now: Instant, header: u8, bytes: &[u8]) {
        match fragment::kind(bytes) {
            Some(Kind::Acknowledge { count, status }) => self.sender.acknowledge(count, status),
            Some(Kind::Part) => {
                let Some((answer, is_complete)) = self.receiver.receive(bytes) else {
                    return;
                };
                let (data, length) = fragment::acknowledge(header, answer);
                self.send(cx, group_2::RESPONSE, data, length);
                let (body, length) = self.receiver.body();
                if let Some(body) = body.get(..length)
                    && is_complete
                    && body.first().is_some_and(|service| !is_response(*service))
                {
                    self.serve(cx, now, header, body);
                }
            }
            None => {}
        }
        cx.shell.wake_up();
    }

    /// Serves a request of the owner on the explicit connection, and answers it.
    #[inline(never)] // measured: called from two places
    fn serve(&mut self, cx: &mut ContextOf<P>, now: Instant, header: u8, body: &[u8]) {
        if self.connections.requested(now) || self.sender.is_running() {
            self.sender.stop();
            cx.shell.wake_up();
        }
        let master = header & explicit::MAC;
        let result = match Request::parse(body) {
            Ok(request) => objects::serve(self, cx, now, master, &request),
            Err(failure) => Err(failure),
        };
        let service = body.first().copied().unwrap_or(0);
        self.respond(cx, header, service, result);
        if service != service::GET {
            self.follow(cx);
        }
    }

    /// Handles a request to the unconnected port.
    #[inline(never)] // rarely called
    fn unconnected(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let &[header, ref body @ ..] = frame.bytes() else {
            return;
        };
        let Some(&service) = body.first() else {
            return;
        };
        if header & FRAGMENT != 0 || is_response(service) {
            return;
        }
        const NOT_SUPPORTED: Failure = Failure::RESOURCE.with(3);
        let result = match service {
            service::ALLOCATE | service::RELEASE => match Request::parse(body) {
                Ok(request) if objects::is_unconnected(&request) => {
                    objects::devicenet::link(self, now, header & explicit::MAC, &request)
                }
                Ok(_) => Err(NOT_SUPPORTED),
                Err(failure) => Err(failure),
            },
            _ => Err(NOT_SUPPORTED),
        };
        self.respond(cx, header, service, result);
        self.follow(cx);
    }

    /// Queues the response to a request.
    #[inline(always)] // on the path of a read
    fn respond(
        &mut self,
        cx: &mut ContextOf<P>,
        header: u8,
        service: u8,
        result: Result<Data, Failure>,
    ) {
        let header = header & explicit::ECHO;
        let (data, length) = match result {
            Ok(Data::Bytes { bytes, length }) => {
                explicit::unfragmented(header, service, bytes, length)
            }
            Ok(Data::Text(text)) => {
                // Sent by `tick`, after the frames that wait.
                self.sender.start(header, service, text);
                return cx.shell.wake_up();
            }
            Err(failure) => explicit::error(header, failure),
        };
        self.send(cx, group_2::RESPONSE, data, length);
    }

    /// Adapts the I/O to the states of the connections.
    fn follow(&mut self, cx: &mut ContextOf<P>) {
        let connections = &mut self.connections;
        if connections.poll().is_allocated() {
            self.polled = selected::<P>(cx, P::ROLES.polled_assembly);
        }
        if connections.is_producing() {
            self.produced = selected::<P>(cx, P::ROLES.cyclic_assembly);
        } else {
            let is_allocated = connections.producing().is_allocated();
            if self.production.is_running() || !is_allocated {
                self.production.stop();
                self.handler.stop();
                let id = CanId::standard(Group1::ChangeOrCyclic.id(self.mac));
                cx.shell.withdraw(id);
            }
        }
        if !connections.explicit().is_allocated() {
            self.sender.stop();
            self.receiver.stop();
        }
        if !connections.is_owned() {
            self.handler = AcknowledgeHandler::DEFAULT;
        }
        cx.shell.wake_up();
    }

    /// Whether a word of the produced assembly differs from the one in `sent` by the COS delta or more.
    #[inline(always)] // called for each sample
    fn differs(assembly: Option<&AssemblyRow>, cx: &ContextOf<P>, sent: &Words) -> bool {
        let Some(assembly) = assembly else {
            return false;
        };
        let delta = cx.parameters.get(P::ROLES.cos_delta).max(1);
        let mut words = assembly.words().zip(sent);
        words.any(|(id, &sent)| {
            let word = cx.values.number(id) as u16;
            word != sent && u32::from(P::distance(&cx.parameters, word, sent)) >= delta
        })
    }

    /// Sends a COS or cyclic message that is due, or repeats the last one.
    fn produce(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if !self.production.is_running() {
            return;
        }
        let Some(assembly) = self.produced else {
            return;
        };
        let differs = |sent: &Words| Self::differs(Some(assembly), cx, sent);
        let words = if self.production.is_due(now, differs) {
            let words = words::<P>(assembly, &cx.values);
            self.production.produced(now, words);
            if self.connections.producing().consumes() {
                self.handler.produced(now);
            }
            words
        } else if self.handler.poll(now) {
            *self.production.sent()
        } else {
            return;
        };
        let id = CanId::standard(Group1::ChangeOrCyclic.id(self.mac));
        let frame = Frame::word(id, pack(words), assembly.size());
        cx.shell.send_cyclic(frame);
    }

    /// Handles the acknowledge of a COS or cyclic message: an empty frame.
    #[inline(never)] // keeps the path of a poll short
    fn acknowledge(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if frame.dlc() != 0
            || !self.connections.is_producing()
            || !self.connections.producing().consumes()
        {
            return;
        }
        self.handler.stop();
        if self.connections.acknowledged(now) {
            cx.shell.wake_up();
        }
    }

    /// Sends the next fragment of a response when all other frames have left the queue, so that they do not wait for it.
    fn stream(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.sender.poll(now);
        if !cx.shell.is_online() || cx.shell.is_sending() {
            return;
        }
        if let Some((bytes, length)) = self.sender.take(now) {
            self.send(cx, group_2::RESPONSE, u64::from_le_bytes(bytes), length);
        }
    }

    /// Continues a departure.
    fn leave(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        match self.departure {
            Departure::None => {}
            Departure::Readdress => {
                if self.patience.is_reached(now) {
                    self.readdress(cx);
                } else {
                    self.earliest.consider(self.patience);
                }
            }
            Departure::Restart => {
                if !self.saving.save(cx) && !cx.shell.is_leaving() {
                    cx.shell.restart(now);
                }
            }
        }
    }

    /// Shows the present state on the LEDs.
    fn show(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let network = if self.check.is_faulted() || cx.shell.bus_state() == BusState::BusOff {
            Light::Red
        } else if !self.check.is_online() {
            Light::Off
        } else if self.connections.has_timed_out() {
            Light::FlashingRed
        } else if self.connections.is_used() {
            Light::Green
        } else {
            Light::FlashingGreen
        };
        let module = if self.faulted || self.saving.is_faulted() {
            Light::FlashingRed
        } else {
            Light::Green
        };
        if let Some(patterns) = self.leds.show(now, module, network) {
            cx.shell.show(patterns);
        }
        self.earliest.consider(self.leds.deadline());
    }
}

impl<P: Product> Protocol<P::Application> for Devicenet<P> {
    // A message of the duplicate MAC ID check, a COS or cyclic message, and a fragment.
    const FRAMES: usize = 3;
    const FILTERS: usize = 5;
    const HEARS_SENT: bool = true;

    const INITIAL: Self = Self {
        mac: 0,
        rate: BitRate::K10,
        check: DuplicateCheck::OFF,
        connections: ConnectionSet::EMPTY,
        polled: None,
        produced: None,
        production: Production::OFF,
        handler: AcknowledgeHandler::INITIAL,
        receiver: Receiver::IDLE,
        sender: Sender::IDLE,
        saving: Saving::INITIAL,
        departure: Departure::None,
        patience: Deadline::NEVER,
        bus_offs: 0,
        leds: StatusLeds::DARK,
        faulted: false,
        earliest: Deadline::NEVER,
        product: PhantomData,
    };

    fn start(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.leds.start(now);
        self.readdress(cx);
    }

    #[inline(always)] // called from one place
    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let message = message_of(frame.can_id(), self.mac);
        if message > 7 || frame.is_remote() {
            return;
        }
        let message = message as u16;
        if message == group_2::DUPLICATE_CHECK {
            self.check_duplicate(cx, frame);
        } else if self.check.is_online() {
            match message {
                group_2::POLL => self.answer_poll(cx, now, frame),
                group_2::REQUEST => self.explicit(cx, now, frame),
                group_2::ACKNOWLEDGE => self.acknowledge(cx, now, frame),
                group_2::UNCONNECTED => self.unconnected(cx, now, frame),
                _ => {}
            }
        }
    }

    #[inline(always)] // called for each sample
    fn published(&mut self, cx: &mut ContextOf<P>, _now: Instant) {
        let has_failed = cx.values.faults().intersects(Faults::SENSOR);
        let faulted = has_failed && !cx.shell.is_starting();
        if faulted != self.faulted {
            self.faulted = faulted;
            cx.shell.wake_up();
        }
        if self.production.watches() && Self::differs(self.produced, cx, self.production.sent()) {
            self.production.change();
            cx.shell.wake_up();
        }
    }

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, _now: Instant, change: BusChange) {
        match change {
            BusChange::State if cx.shell.bus_state() == BusState::BusOff => {
                self.bus_offs = self.bus_offs.saturating_add(1);
                self.release_all(cx);
                self.discard(cx);
                if !self.recovers(&cx.parameters) {
                    self.check.fault();
                } else if !self.check.is_faulted() {
                    self.check.stop();
                }
            }
            BusChange::Recovered
                if !self.check.is_faulted() && self.departure != Departure::Restart =>
            {
                self.readdress(cx);
            }
            _ => {}
        }
        cx.shell.wake_up();
    }

    fn recovers(&self, parameters: &ParametersOf<P>) -> bool {
        parameters.get(P::ROLES.bus_off_interrupt) != 0
    }

    fn stored(
        &mut self,
        _cx: &mut ContextOf<P>,
        now: Instant,
        saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) {
        self.saving.stored(now, saved, result.is_ok());
    }

    fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.departure == Departure::Readdress {
            self.readdress(cx);
        } else if self.check.sent(now) {
            cx.shell.wake_up();
        }
    }

    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        match step {
            0 => {
                self.earliest = Deadline::NEVER;
                if self.check.poll(now) == Step::Request {
                    self.send_check(cx, false);
                }
                self.earliest.consider(self.check.deadline());
                if self.connections.expire(now) {
                    self.follow(cx);
                }
                self.connections.consider(&mut self.earliest);
            }
            1 => {
                self.produce(cx, now);
                self.earliest.consider(self.production.deadline());
                self.earliest.consider(self.handler.deadline());
            }
            2 => {
                self.stream(cx, now);
                self.earliest.consider(self.sender.deadline());
            }
            3 => {
                self.saving.poll(cx, now);
                self.leave(cx, now);
                self.earliest.consider(self.saving.deadline(cx));
            }
            _ => {
                self.show(cx, now);
                return false;
            }
        }
        true
    }

    fn waits_for_room(&self) -> bool {
        self.sender.is_pending()
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        earliest.consider(self.earliest);
    }

    fn filters(&self, _cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        let messages = [
            group_2::ACKNOWLEDGE,
            group_2::REQUEST,
            group_2::POLL,
            group_2::UNCONNECTED,
            group_2::DUPLICATE_CHECK,
        ];
        for message in messages {
            let id = CanId::standard(group_2_id(self.mac, message));
            accept(Filter::exact(id));
        }
    }
}
