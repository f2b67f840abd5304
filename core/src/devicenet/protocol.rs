//! The protocol: its state, received frames, timers and LEDs.

use super::allocation::ConnectionSet;
use super::duplicate_check::{DuplicateCheck, Step};
use super::fragment::{Receiver, Sender};
use super::identifiers::{group_2, group_2_id, message_of};
use super::leds::{Light, StatusLeds};
use super::objects::identity;
use super::production::{AcknowledgeHandler, Production};
use super::projection::AssemblyRow;
use super::saving::Saving;
use super::table::Product;
use crate::application::{Application, Faults, Values};
use crate::can::{BitRate, CanId, Filter, Frame};
use crate::node::{BusChange, BusState, CanNode, Context, Protocol, Restore};
use crate::param::{Parameters, meaning};
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant};
use crate::update::Contact;
use core::marker::PhantomData;

pub(super) type ParametersOf<P> = Parameters<<<P as Product>::Application as Application>::Table>;

/// The published values of product `P`.
pub(super) type ValuesOf<P> = <<P as Product>::Application as Application>::Values;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as Product>::Application>;

/// The action after the answer to a request is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Leaving {
    None,
    /// The node checks its new MAC ID.
    Readdress,
    /// The node restarts when its parameters are stored.
    Restart,
}

/// A node of product `P` with the DeviceNet protocol.
pub type DevicenetNode<P> = CanNode<<P as Product>::Application, Devicenet<P>>;

/// The DeviceNet protocol for product `P`.
pub struct Devicenet<P: Product> {
    /// The MAC ID in force.
    pub(super) mac: u8,
    /// The bit rate in force.
    pub(super) rate: BitRate,
    pub(super) check: DuplicateCheck,
    pub(super) connections: ConnectionSet,
    /// The assembly in poll responses, while the poll connection is allocated.
    pub(super) polled: Option<&'static AssemblyRow>,
    /// The assembly in COS and cyclic messages, while their connection is established.
    pub(super) produced: Option<&'static AssemblyRow>,
    pub(super) production: Production,
    pub(super) handler: AcknowledgeHandler,
    pub(super) receiver: Receiver,
    pub(super) sender: Sender,
    pub(super) saving: Saving<P::Application>,
    pub(super) leaving: Leaving,
    /// The end of the wait of [`Leaving::Readdress`].
    pub(super) leaves_until: Deadline,
    /// The number of times that the controller has gone bus-off.
    pub(super) bus_offs: u8,
    pub(super) leds: StatusLeds,
    /// The last published values have a fault.
    pub(super) faulted: bool,
    /// The earliest deadline. Each step of [`tick`](Protocol::tick) considers its own ones.
    pub(super) earliest: Deadline,
    pub(super) product: PhantomData<P>,
}

impl<P: Product> Devicenet<P> {
    /// Queues a frame of group 2.
    pub(super) fn send(&self, cx: &mut ContextOf<P>, message: u16, data: u64, length: u8) {
        let id = CanId::standard(group_2_id(self.mac, message));
        cx.shell.send(Frame::word(id, data, length));
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

impl<P: Product> Restore for Devicenet<P> {
    type Application = P::Application;
    const IMAGE: ImageId = P::IMAGE;

    fn restored(&mut self, parameters: &mut ParametersOf<P>, damaged: bool) {
        self.saving.start(parameters, damaged);
        self.handler = AcknowledgeHandler::DEFAULT;
        let code = parameters.get(P::ROLES.baud_rate);
        self.rate = meaning(P::ROLES.bit_rates, code).unwrap_or(BitRate::K125);
    }
}

impl<P: Product> Protocol<P::Application> for Devicenet<P> {
    // A message of the duplicate MAC ID check, a COS or cyclic message, and a fragment.
    const FRAMES: usize = 3;
    const FILTERS: usize = 5;
    const USES_SENT: bool = true;

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
        leaving: Leaving::None,
        leaves_until: Deadline::NEVER,
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

    fn published(&mut self, cx: &mut ContextOf<P>, _now: Instant) {
        let faulted = cx.values.faults().intersects(Faults::SENSOR);
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
                if self.leaving == Leaving::Readdress {
                    // The check of the new MAC ID follows the recovery.
                    self.leaving = Leaving::None;
                }
                if self.recovers(&cx.parameters) {
                    self.discard(cx);
                    if !self.check.is_faulted() {
                        self.check.stop();
                    }
                } else {
                    // A change of the mode would let the controller recover.
                    cx.shell.clear_queue();
                    self.check.fault();
                }
            }
            BusChange::Recovered
                if !self.check.is_faulted() && self.leaving != Leaving::Restart =>
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
        if self.leaving == Leaving::Readdress {
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
                    self.update_io(cx);
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
                self.continue_leaving(cx, now);
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

    fn contact(&self, cx: &ContextOf<P>) -> Option<Contact> {
        let id = |message| CanId::standard(group_2_id(self.mac, message));
        let unit = cx.shell.unit();
        Some(Contact {
            rate: self.rate,
            request: id(group_2::REQUEST),
            reply: id(group_2::RESPONSE),
            boot_up: id(group_2::RESPONSE),
            vendor: identity::vendor::<P>(unit).into(),
            product_code: identity::product_code::<P>(unit).into(),
            serial: cx.shell.serial(),
        })
    }

    fn address(&self) -> Option<u32> {
        Some(self.mac.into())
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
