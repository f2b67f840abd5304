//! Reset node and reset communication (CiA 301, 7.3.2.2).

use super::cob_id;
use super::consumer::Consumers;
use super::guarding::Guarding;
use super::mapping::fixed_entry;
use super::nmt::State;
use super::own::Taken;
use super::pdo::{Tpdo, Tpdos};
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::{Canopen, Services, send};
use crate::can::CanId;
use crate::param::ParameterRow;
use crate::time::Instant;

/// The NMT start-up value that starts all nodes (1F80h).
const START_ALL: u32 = 2;
/// The NMT start-up value that starts only this node.
const START_SELF: u32 = 8;

/// The delay of a reset that an object requests, in ms. Meanwhile the driver sends the reply, which a change of the bit rate would
/// discard: four frames of 16 ms at 10 kbit/s, and some time for other nodes.
const DELAY: u32 = 100;

impl<P: Product> Canopen<P> {
    /// Resets the node: restarts with the stored parameters. Node-ID and bit rate keep their present values, also if they are not
    /// stored.
    pub(super) fn reset_node(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let mut parameters = *self.services.parameters_after_reset(cx);
        if !self.services.saved.restarts() {
            parameters.copy(&cx.parameters, [P::NODE_ID, P::BIT_RATE]);
        }
        cx.parameters = parameters;
        // The memory can have values that are not persistent, as they were at the save.
        self.services.restore_communication(cx);
        cx.apply();
        // The history is cleared. Active faults are sent again after the boot-up message. Life guarding restarts, so its time-out
        // is not one of them.
        let mut faults = self.services.emergency.active() & !Services::<P>::GUARDING;
        // A restart ends bus-off, as power-up does. Without automatic recovery, nothing else ends it.
        let was_off = P::RECOVERS.is_some() && cx.shell.leave_bus_off();
        if was_off {
            faults &= !Services::<P>::PASSIVE;
        }
        self.services.emergency.reset();
        self.services.begin(&mut cx.parameters);
        self.services.select_protocol(&cx.parameters);
        if was_off {
            self.services.readdress(cx);
        }
        self.services.reset_lss();
        self.reset_communication(cx, now);
        self.services.emergency.update(faults, faults);
    }

    /// Resets the communication: restarts it with its stored parameters, the node-ID and the bit rate.
    pub(super) fn reset_communication(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.sdo.end();
        self.services.reset_communication(cx, now);
        if self.is_hosted() {
            self.services.be_silent(State::PreOperational);
        } else if !self.services.is_unconfigured() {
            self.start_up(cx, now);
        }
        self.services.indicate_lss(cx, now);
    }

    /// Sends the boot-up message and performs the NMT start-up (1F80h).
    fn start_up(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let node_id = u16::from(self.services.node_id);
        send(cx, cob_id::ERROR_CONTROL + node_id, &[0]);
        let start_up = Services::<P>::START_UP.get(&cx.parameters);
        if start_up == START_ALL {
            send(cx, cob_id::NMT, &[1, 0]);
        }
        if start_up == START_ALL || start_up == START_SELF {
            self.enter(cx, now, State::Operational);
        }
    }
}

impl<P: Product> Services<P> {
    /// Resets the node after its reply. Until then it is silent and accepts only the NMT commands for a reset.
    pub(super) fn prepare_reset(&mut self, now: Instant) {
        self.state = State::Initialising;
        self.guarding = Guarding::OFF;
        self.heartbeat.start(now, DELAY);
        self.operate(now, false);
    }

    /// Whether the delay of a reset has ended.
    pub(super) fn resets(&mut self, now: Instant) -> bool {
        self.state == State::Initialising && self.heartbeat.poll(now)
    }

    /// The stored parameters. A reset during a save takes those that are being saved.
    fn parameters_after_reset<'a>(&'a self, cx: &'a ContextOf<P>) -> &'a ParametersOf<P> {
        cx.saving().unwrap_or(&self.saved.parameters)
    }

    fn reset_communication(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        // The node-ID is 0 before the first call, so the first call always configures the controller.
        let before = (self.node_id, self.rate);
        self.node_id = Self::pending_node_id(cx);
        self.rate = Self::pending_rate(cx);
        if !self.saved.has_begun() {
            self.restore_communication(cx);
            self.adapt(&mut cx.parameters, false);
        }
        cx.shell.clear_queue();
        self.state = State::PreOperational;
        self.guarding = Guarding::OFF;
        self.configure_guarding(cx, now);
        self.configure_heartbeat(cx, now);
        self.configure_emergency(cx);
        let mut changed = self.configure_consumers(cx);
        self.tpdos.all_mut().iter_mut().for_each(Tpdo::reset);
        if P::Tpdos::DYNAMIC {
            self.restore_mappings(cx, now);
        } else {
            self.tpdos.map_all(fixed_entry::<P>);
        }
        // Sent after the boot-up message.
        self.emergency.restart();
        changed |= before != (self.node_id, self.rate);
        for number in 0..P::Tpdos::COUNT {
            changed |= self.configure_tpdo(cx, now, number);
        }
        changed |= self.take_sync(cx);
        if self.is_unconfigured() {
            self.be_silent(State::Initialising);
        }
        if changed {
            self.readdress(cx);
        }
        self.settle(cx);
    }

    /// Takes parameters of the memory, as after power-up.
    pub(super) fn begin(&mut self, parameters: &mut ParametersOf<P>) {
        self.adapt(parameters, true);
        self.saved.begin();
    }

    /// Lets the product adapt parameters that were taken from the memory.
    fn adapt(&mut self, parameters: &mut ParametersOf<P>, starts: bool) {
        let taken = Taken {
            parameters,
            state: &mut self.own,
            stored: &self.saved.parameters,
            history: self.emergency.history_mut(),
        };
        P::adapt(taken, starts);
    }

    /// Sends no more frames by itself.
    pub(super) fn be_silent(&mut self, state: State) {
        self.state = state;
        self.heartbeat.stop();
        self.guarding = Guarding::OFF;
        self.emergency.silence();
        self.consumers = P::Consumers::INITIAL;
    }

    /// Sets the parameters of the communication profile to their stored values, or to their factory values if they are not
    /// persistent.
    fn restore_communication(&self, cx: &mut ContextOf<P>) {
        for row in P::ROWS {
            let Some(id) = row.communication_parameter() else {
                continue;
            };
            let is_stored = ParametersOf::<P>::row(id).is_some_and(ParameterRow::is_stored);
            let value = if is_stored {
                self.parameters_after_reset(cx).get(id)
            } else {
                ParametersOf::<P>::factory_value(id)
            };
            cx.parameters.set(id, value);
        }
    }

    /// Starts the heartbeat with the producer heartbeat time (1017h).
    pub(super) fn configure_heartbeat(&mut self, cx: &ContextOf<P>, now: Instant) {
        self.heartbeat
            .start(now, Self::HEARTBEAT_TIME.get(&cx.parameters));
    }

    /// Configures the inhibit time of emergency messages.
    pub(super) fn configure_emergency(&mut self, cx: &ContextOf<P>) {
        self.emergency
            .configure(Self::EMCY_INHIBIT_TIME.get(&cx.parameters));
    }

    /// Configures life guarding. A heartbeat overrides node guarding.
    pub(super) fn configure_guarding(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let guard_time = match Self::HEARTBEAT_TIME.get(&cx.parameters) {
            0 => Self::GUARD_TIME.get(&cx.parameters),
            _ => 0,
        };
        let life_time_factor = Self::LIFE_TIME_FACTOR.get(&cx.parameters);
        self.guarding.configure(now, guard_time, life_time_factor);
        self.report_guarding(cx);
    }

    /// Applies the communication parameter of TPDO `number` (from 0). Returns true if its identifier has changed.
    pub(super) fn configure_tpdo(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        number: usize,
    ) -> bool {
        let Some(settings) = P::TPDO_SETTINGS.get(number) else {
            return false;
        };
        let mut settings = settings.map(|id| cx.parameters.get(id));
        let [cob_id, ..] = &mut settings;
        *cob_id = self.on_bus(*cob_id);
        let Some(tpdo) = self.tpdos.all_mut().get_mut(number) else {
            return false;
        };
        let before = tpdo.id();
        let readdressed = tpdo.configure(now, P::TRIGGERS, settings);
        if !P::Tpdos::DYNAMIC {
            self.withdraw(cx);
        } else if readdressed || !tpdo.is_sent() {
            // Only this TPDO: a disabled one can have the identifier of another one.
            cx.shell.withdraw(CanId::standard(before));
        }
        readdressed
    }

    /// Removes the queued TPDOs that must not be sent now.
    pub(super) fn withdraw(&self, cx: &mut ContextOf<P>) {
        for tpdo in self.tpdos.all().iter().filter(|tpdo| !tpdo.is_sent()) {
            cx.shell.withdraw(CanId::standard(tpdo.id()));
        }
    }

    /// Configures the controller with the identifiers and the bit rate.
    pub(super) fn readdress(&self, cx: &mut ContextOf<P>) {
        if !self.is_hosted() {
            cx.shell.go_online(self.rate);
        }
    }
}
