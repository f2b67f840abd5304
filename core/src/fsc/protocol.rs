//! The protocol: identifiers in force, sync frames, cyclic mode, saves, LEDs and the contents of replies.

use super::cyclic::Cyclic;
use super::projection::Row;
use super::status::StatusMasks;
use super::table::{Article, Operation, Product, Source};
use super::wire::Reply;
use crate::application::{Application, Values};
use crate::can::{BitRate, CanId, Filter, Frame};
use crate::node::{BusChange, Context, NodeState, Patterns, Protocol};
use crate::param::{Parameters, meaning};
use crate::store::StoreError;
use crate::time::{Deadline, Instant};
use crate::update::Contact;
use core::marker::PhantomData;

pub(super) type ParametersOf<P> = Parameters<<<P as Product>::Application as Application>::Table>;

/// The number of boot-up messages (section 10.2).
const BOOT_UPS: u8 = 2;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as Product>::Application>;

/// The identifiers in force since the last restart. A written identifier acts after the next restart.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct InForce {
    pub(super) set: CanId,
    pub(super) reply: CanId,
    pub(super) sync: CanId,
}

/// The identification of the article.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Identity {
    product_number: u32,
    revision: u16,
    software_version: u16,
}

/// The protocol of GEMAC function select codes for product `P`.
pub struct Fsc<P> {
    identity: Identity,
    pub(super) in_force: InForce,
    /// The sticky bits of the status byte.
    pub(super) sticky: u8,
    pub(super) cyclic: Option<Cyclic>,
    /// The number of boot-up messages that must be sent. They are built last, so the status byte is final.
    boot_up: u8,
    /// The running save loads the factory values.
    pub(super) loading: bool,
    product: PhantomData<P>,
}

impl<P: Product> Fsc<P> {
    pub(super) const STATUS: StatusMasks = StatusMasks::of(&P::STATUS);
    /// The bit rate code for automatic detection.
    const AUTOMATIC: Option<u32> = P::ROLES.automatic();
    const INCLINATION: Row = P::CODES.row_of(Operation::Inclination);
    const ALIVE: Row = P::CODES.row_of(Operation::Alive);
    const SAVE: Row = P::CODES.row_of(Operation::Save);
    const LOAD: Row = P::CODES.row_of(Operation::Load);

    /// Takes the identifiers from the parameters. `damaged`: the stored record is damaged or not usable.
    pub fn restored(&mut self, article: &Article, parameters: &ParametersOf<P>, damaged: bool) {
        let roles = &P::ROLES;
        let identifier = |id| CanId::from_bits(parameters.get(id));
        self.identity = Identity {
            product_number: article.number.digits(),
            revision: article.revision,
            software_version: article.version.code(),
        };
        self.in_force = InForce {
            set: identifier(roles.set_id),
            reply: identifier(roles.reply_id),
            sync: identifier(roles.sync_id),
        };
        if damaged {
            self.sticky = Self::STATUS.eeprom_error;
        }
    }

    pub(super) fn raise_cmd_param_error(&mut self) {
        self.sticky |= Self::STATUS.cmd_param_error;
    }

    /// Starts cyclic mode with counter 0, or stops it, as set by its parameter.
    pub(super) fn restart_cyclic(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let period = cx.parameters.get(P::ROLES.cyclic_time);
        let on = cx.parameters.get(P::ROLES.cyclic_mode) != 0;
        self.cyclic = on.then(|| Cyclic::start(now, period));
        cx.shell.wake_up();
    }

    /// The status byte of a reply: the sticky bits and those of the present state.
    fn status(&self, cx: &ContextOf<P>) -> u8 {
        let mut status = self.sticky | Self::STATUS.of_faults(cx.values.faults());
        if cx.parameters.is_factory() {
            status |= Self::STATUS.default_param;
        }
        if Some(cx.parameters.get(P::ROLES.bit_rate)) == Self::AUTOMATIC {
            status |= Self::STATUS.autobaud_detection;
        }
        status
    }

    /// The reply of a row: code, status byte and fields.
    fn reply(&self, cx: &ContextOf<P>, row: Row) -> Frame {
        let mut reply = Reply::new(row.code, self.status(cx));
        for item in P::CODES.items(row) {
            let number = match item.source() {
                Source::Parameter(id) => cx.parameters.get(id),
                Source::Value(id) => cx.values.number(id),
                // Outside cyclic mode the reply ends before the counter.
                Source::Counter if self.cyclic.is_none() => break,
                other => self.number(cx, other),
            };
            reply.append(number, item.size);
        }
        reply.frame(self.in_force.reply)
    }

    /// A number that is neither a parameter nor a value.
    fn number(&self, cx: &ContextOf<P>, source: Source) -> u32 {
        let unit = cx.shell.unit();
        match source {
            Source::Counter => self.cyclic.map_or(0, |cyclic| cyclic.counter().into()),
            Source::ProductNumber => unit.article.unwrap_or(self.identity.product_number),
            Source::Revision => unit.revision.unwrap_or(self.identity.revision.into()),
            Source::SerialNumber => cx.shell.serial(),
            Source::SoftwareVersion => self.identity.software_version.into(),
            Source::ActiveSetId => self.in_force.set.bits(),
            Source::Parameter(_) | Source::Value(_) => 0,
        }
    }

    /// Queues the reply of a row.
    #[inline(always)] // measured: a call more delays each answer
    pub(super) fn send(&self, cx: &mut ContextOf<P>, row: Row) {
        self.queue(cx, row, false);
    }

    fn send_boot_up(&mut self, cx: &mut ContextOf<P>) {
        self.boot_up = self.boot_up.saturating_sub(1);
        self.send(cx, Self::ALIVE);
    }

    /// Queues a reply with code and status only.
    pub(super) fn acknowledge(&self, cx: &mut ContextOf<P>, code: u8) {
        self.queue(cx, Row::bare(code), false);
    }

    /// Queues a reply with this data, at most six bytes.
    pub(super) fn answer(&self, cx: &mut ContextOf<P>, code: u8, data: &[u8]) {
        let mut reply = Reply::new(code, self.status(cx));
        data.iter().for_each(|byte| reply.append((*byte).into(), 1));
        cx.shell.send(reply.frame(self.in_force.reply));
    }

    fn queue(&self, cx: &mut ContextOf<P>, row: Row, cyclic: bool) {
        let frame = self.reply(cx, row);
        if cyclic {
            cx.shell.send_cyclic(frame);
        } else {
            cx.shell.send(frame);
        }
    }

    /// Switches cyclic mode off, and restarts after the frames that wait.
    pub(super) fn restart(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.cyclic = None;
        cx.shell.restart(now);
    }

    /// Shows the LED patterns of the present state (table 12).
    fn show(&self, cx: &mut ContextOf<P>) {
        let leds = &P::LEDS;
        let patterns = match cx.shell.state() {
            NodeState::Detecting(_) => Patterns {
                run: leds.detecting,
                error: leds.error.working,
                ..Patterns::default()
            },
            _ => Patterns {
                run: leds.normal,
                error: leds.error.of(cx.shell.bus_state()),
                ..Patterns::default()
            },
        };
        cx.shell.show(patterns);
    }
}

/// The fixed bit rate; None for automatic detection.
fn bit_rate<P: Product>(parameters: &ParametersOf<P>) -> Option<BitRate> {
    meaning(P::ROLES.bit_rates, parameters.get(P::ROLES.bit_rate)).flatten()
}

impl<P: Product> Protocol<P::Application> for Fsc<P> {
    // Two boot-up messages and a cyclic value.
    const FRAMES: usize = 3;
    const FILTERS: usize = 2;
    const DETECTS: bool = true;
    const DEFERS: bool = true;

    const INITIAL: Self = Self {
        identity: Identity {
            product_number: 0,
            revision: 0,
            software_version: 0,
        },
        in_force: InForce {
            set: CanId::standard(0),
            reply: CanId::standard(0),
            sync: CanId::standard(0),
        },
        sticky: 0,
        cyclic: None,
        boot_up: 0,
        loading: false,
        product: PhantomData,
    };

    fn detects(&self, parameters: &ParametersOf<P>) -> bool {
        bit_rate::<P>(parameters).is_none()
    }

    fn start(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        match bit_rate::<P>(&cx.parameters) {
            Some(rate) => {
                cx.shell.go_online(rate);
                self.bus_changed(cx, now, BusChange::Online);
            }
            None => self.show(cx),
        }
    }

    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        while self.boot_up > 0 {
            // No reply overtakes a boot-up message.
            self.send_boot_up(cx);
        }
        if frame.is_remote() {
            return;
        }
        if frame.can_id() == self.in_force.set {
            let [low, _] = frame.data_words();
            let row = (frame.dlc() > 0).then(|| P::CODES.find(low as u8));
            match row.flatten() {
                // A read is answered here, because this path is shorter than `request`.
                Some(row) if row.is_read() => self.send(cx, row),
                row => self.request(cx, now, frame, row),
            }
        } else if frame.can_id() == self.in_force.sync && frame.dlc() == 0 {
            self.send(cx, Self::INCLINATION);
        }
    }

    fn published(&mut self, _cx: &mut ContextOf<P>, _now: Instant) {}

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        if change == BusChange::Online {
            self.boot_up = BOOT_UPS;
            self.restart_cyclic(cx, now);
        }
        self.show(cx);
    }

    fn recovers(&self, parameters: &ParametersOf<P>) -> bool {
        parameters.get(P::ROLES.bus_off_recovery) != 0
    }

    fn stored(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) {
        let row = if self.loading { Self::LOAD } else { Self::SAVE };
        if result.is_err() {
            self.sticky |= Self::STATUS.sticky();
        } else if self.loading {
            cx.parameters = *saved;
            cx.apply();
            self.restart_cyclic(cx, now);
        }
        self.acknowledge(cx, row.code);
    }

    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, _step: u8) -> bool {
        if self.boot_up > 0 {
            self.send_boot_up(cx);
            return true;
        }
        let due = self.cyclic.as_mut().is_some_and(|cyclic| cyclic.poll(now));
        if due {
            self.queue(cx, Self::INCLINATION, true);
        }
        false
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        if let Some(cyclic) = &self.cyclic {
            earliest.consider(Deadline::at(cyclic.deadline()));
        }
    }

    fn contact(&self, cx: &ContextOf<P>) -> Option<Contact> {
        Some(Contact {
            rate: cx.shell.rate(),
            request: self.in_force.set,
            reply: self.in_force.reply,
            boot_up: self.in_force.reply,
            vendor: 0,
            product_code: self.number(cx, Source::ProductNumber),
            serial: cx.shell.serial(),
        })
    }

    fn address(&self) -> Option<u32> {
        let InForce { set, reply, sync } = &self.in_force;
        Some(set.bits() ^ reply.bits().rotate_left(3) ^ sync.bits().rotate_left(6))
    }

    fn filters(&self, _cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        accept(Filter::exact(self.in_force.set));
        accept(Filter::exact(self.in_force.sync));
    }
}
