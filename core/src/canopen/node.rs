//! The CANopen sensor as a [`Node`]: what it does with each input, and when it acts by itself.

use super::abort::Abort;
use super::device::{Device, Link, SAMPLE_LIMIT};
use super::emcy;
use super::key::Key;
use super::model::Model;
use super::nmt::{Command, State};
use super::pdo::Reaction;
use super::sync::is_sync;
use super::wire;
use crate::can::{Filter, Filters, Frame, standard};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::node::{Action, BusEvent, BusMode, BusState, Node, Readout};
use crate::store::{Payload, StoreError};
use crate::time::{Earliest, Instant, after, is_due, reached};

/// The faults that a sample decides on.
const MEASURED: u8 = emcy::SENSOR | emcy::LIMIT | emcy::TEMPERATURE;

impl<M: Model> Node for Device<M> {
    fn ready(&self) -> bool {
        let restarting = matches!(self.link, Link::Restarting(_) | Link::Restarted);
        self.queue.has_room() && self.deferred.is_none() && !restarting
    }

    #[inline(never)] // measured and budgeted as a function
    fn receive(&mut self, now: Instant, frame: &Frame) {
        if self.link == Link::Online {
            self.dispatch(now, frame);
        }
    }

    #[inline(never)] // measured and budgeted as a function
    fn sample(&mut self, now: Instant, reading: &Reading) {
        self.attention |= self.fresh_until.is_none();
        self.fresh_until = Some(after(now, SAMPLE_LIMIT));
        let faults = self.model.sample(now, reading);
        self.emergency.update(MEASURED, faults);
        self.attention |= self.emergency.is_waiting() || self.model.has_action();
    }

    #[inline(never)] // measured and budgeted as a function
    fn bus(&mut self, now: Instant, event: BusEvent) {
        match event {
            BusEvent::Error => return,
            BusEvent::Overrun => self.emergency.event(emcy::OVERRUN),
            BusEvent::State(state) => self.bus_changed(state),
        }
        self.show(now);
    }

    #[inline(never)] // measured and budgeted as a function
    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        self.end_save(now, result);
        self.attention = true;
    }

    #[inline(never)] // measured and budgeted as a function
    fn tested(&mut self, _now: Instant, result: Working) {
        self.model.tested(result, &mut self.values);
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
        if self.wanted.bus {
            // It would be dropped from its mailbox.
            return None;
        }
        match self.link {
            Link::Online => {
                let frame = self.queue.pop();
                // An emergency may have waited for room.
                self.attention |= self.emergency.is_waiting();
                frame
            }
            Link::Restarting(_) => {
                // A restart waits for the queue to run empty.
                self.attention |= !self.queue.is_empty();
                self.queue.pop()
            }
            Link::BusOff | Link::Restarted => None,
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.wake
    }

    fn filters(&self) -> Filters {
        let node_id = u16::from(self.node_id);
        let sync = (self.values.get(Key::SyncId) & 0x7FF) as u16;
        let own = [
            wire::NMT,
            sync,
            wire::SDO_REQUEST + node_id,
            wire::ERROR_CONTROL + node_id,
        ];
        let tpdos = self.tpdos.iter().filter_map(|tpdo| tpdo.id());
        let mut filters = Filters::new();
        for id in own.into_iter().chain(tpdos) {
            // Six of the eight that there can be.
            let _ = filters.push(Filter::exact(standard(id)));
        }
        filters
    }

    #[inline(never)] // measured and budgeted as a function
    fn image(&self) -> Payload {
        self.payload()
    }

    fn readout(&self) -> Readout {
        self.model.readout()
    }
}

impl<M: Model> Device<M> {
    /// Does with a frame what its identifier says.
    pub(super) fn dispatch(&mut self, now: Instant, frame: &Frame) {
        let Some(id) = wire::standard_id(frame.id()) else {
            return;
        };
        let node_id = u16::from(self.node_id);
        let sync = (self.values.get(Key::SyncId) & 0x7FF) as u16;
        if id == sync {
            if self.state == State::Operational && is_sync(frame) {
                self.synchronise();
            }
        } else if id == wire::SDO_REQUEST + node_id {
            self.sdo(now, frame);
        } else if id == wire::NMT {
            self.nmt(now, frame);
        } else if id == wire::ERROR_CONTROL + node_id {
            self.guard(now, frame);
        } else if frame.is_remote() && self.state == State::Operational {
            self.requested(now, id);
        }
    }

    /// A SYNC: answered on reception, with the newest sample.
    fn synchronise(&mut self) {
        for number in 0..self.tpdos.len() {
            if let Some(tpdo) = self.tpdos.get_mut(number) {
                let reaction = tpdo.sync();
                self.react(number, reaction);
            }
        }
    }

    /// A remote frame, perhaps for a TPDO.
    fn requested(&mut self, now: Instant, id: u16) {
        let same = |tpdo: &super::pdo::Tpdo| tpdo.id() == Some(id);
        let Some(number) = self.tpdos.iter().position(same) else {
            return;
        };
        if let Some(tpdo) = self.tpdos.get_mut(number) {
            let reaction = tpdo.request(now);
            self.react(number, reaction);
            self.attention = true;
        }
    }

    /// Sends or keeps the data of a TPDO.
    fn react(&mut self, number: usize, reaction: Reaction) {
        let Some(tpdo) = self.tpdos.get(number) else {
            return;
        };
        let frame = match reaction {
            Reaction::None => return,
            Reaction::SendKept => tpdo.kept().or_else(|| self.compose(tpdo)),
            Reaction::Send | Reaction::SendChanged | Reaction::Keep => self.compose(tpdo),
        };
        let Some(frame) = frame else { return };
        let keeps = matches!(reaction, Reaction::SendChanged | Reaction::Keep);
        if keeps {
            let Some(tpdo) = self.tpdos.get_mut(number) else {
                return;
            };
            if !tpdo.keep(&frame) || reaction == Reaction::Keep {
                return;
            }
        }
        self.queue.cyclic(frame);
    }

    fn sdo(&mut self, now: Instant, frame: &Frame) {
        let Ok(bytes) = frame.bytes().try_into() else {
            return;
        };
        if !self.state.communicates() {
            return;
        }
        if self.saving.is_some() {
            self.deferred = Some(*frame);
            return;
        }
        let expires = self.transfer.expires;
        self.serve(now, bytes);
        // A read of a number changes nothing that a timer waits for.
        self.attention |= self.transfer.expires != expires;
    }

    fn nmt(&mut self, now: Instant, frame: &Frame) {
        let Some(command) = Command::parse(frame, self.node_id) else {
            return;
        };
        if self.saving.is_some() && !matches!(command, Command::Enter(_)) {
            self.deferred = Some(*frame);
            return;
        }
        match command {
            Command::Enter(state) => self.enter(now, state),
            Command::ResetNode => self.reset_node(now),
            Command::ResetCommunication => self.reset_communication(now),
        }
        self.attention = true;
    }

    /// The guarding master asks; while there is a heartbeat there is no guarding.
    fn guard(&mut self, now: Instant, frame: &Frame) {
        if !frame.is_remote() || self.values.get(Key::Heartbeat) != 0 {
            return;
        }
        let failed = self.guarding.failed();
        let answer = self.guarding.answer(now, self.state);
        self.send(wire::ERROR_CONTROL + u16::from(self.node_id), &[answer]);
        if failed {
            self.tell_guarding(now);
        }
        self.attention = true;
    }

    /// The controller's fault confinement state has changed.
    fn bus_changed(&mut self, state: BusState) {
        self.bus_state = state;
        let passive = if state == BusState::Passive {
            emcy::PASSIVE
        } else {
            0
        };
        match (self.link, state) {
            (Link::Online, BusState::BusOff) => {
                self.link = Link::BusOff;
                self.wanted.recover = true;
            }
            (Link::BusOff, BusState::BusOff) => {}
            (Link::BusOff, _) => {
                self.link = Link::Online;
                self.emergency.event(emcy::BUS_OFF);
                self.emergency.update(emcy::PASSIVE, passive);
            }
            _ => self.emergency.update(emcy::PASSIVE, passive),
        }
    }

    /// What the timers want done by now; only called when there may be something.
    fn tick(&mut self, now: Instant) {
        if is_due(&self.fresh_until, now) {
            self.fresh_until = None;
            self.model.lose();
            self.emergency.update(emcy::SENSOR, emcy::SENSOR);
        }
        if self.guarding.poll(now) {
            self.master_lost(now);
        }
        if is_due(&self.transfer.expires, now) {
            self.abort_transfer(Abort::TimeOut);
        }
        self.model.tick(now, &mut self.values);
        if self.heartbeat.poll(now) {
            let id = standard(wire::ERROR_CONTROL + u16::from(self.node_id));
            if let Some(frame) = Frame::data(id, &[self.state as u8]) {
                self.queue.cyclic(frame);
            }
        }
        for number in 0..self.tpdos.len() {
            if self
                .tpdos
                .get_mut(number)
                .is_some_and(|tpdo| tpdo.poll(now))
            {
                self.react(number, Reaction::Send);
            }
        }
        self.send_emergencies(now);
    }

    fn send_emergencies(&mut self, now: Instant) {
        let id = self.values.get(Key::EmcyId);
        let enabled = id & wire::DISABLED == 0;
        // Whether one is due comes first: it also ends the inhibit time.
        while self.emergency.is_due(now)
            && self.link == Link::Online
            && self.state.communicates()
            && self.queue.has_room()
            && let Some(message) = self.emergency.take(now)
        {
            if enabled {
                self.send((id & 0x7FF) as u16, &message);
            }
        }
    }

    /// The next action that is wanted, most urgent first.
    fn next_action(&mut self, now: Instant) -> Option<Action> {
        let leds = self.indicator.poll(now);
        if leds != self.shown {
            self.shown = leds;
            return Some(Action::Leds(leds));
        }
        if core::mem::take(&mut self.wanted.bus) {
            return Some(Action::Bus(BusMode::Normal, self.rate));
        }
        if core::mem::take(&mut self.wanted.recover) {
            return Some(Action::Recover);
        }
        if core::mem::take(&mut self.wanted.save) {
            return Some(Action::Save);
        }
        if let Link::Restarting(until) = self.link
            && (self.queue.is_empty() || reached(now, until))
        {
            self.link = Link::Restarted;
            return Some(Action::Restart);
        }
        self.model.action()
    }

    fn next_deadline(&self) -> Option<Instant> {
        let mut next = Earliest::default();
        if let Link::Restarting(until) = self.link {
            next.consider(Some(until));
        }
        next.consider(self.fresh_until);
        next.consider(self.transfer.expires);
        next.consider(self.heartbeat.deadline());
        next.consider(self.guarding.deadline());
        next.consider(self.emergency.deadline());
        for tpdo in &self.tpdos {
            tpdo.consider(&mut next);
        }
        next.consider(self.model.deadline());
        next.consider(self.indicator.deadline());
        next.instant()
    }
}
