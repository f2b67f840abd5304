//! The layer setting services in the node: identity, pending settings, store, activation and LEDs.

use super::activation::Step;
use super::slave::{Device, Outcome, Slave, standard_bit_rate};
use super::{Store, UNCONFIGURED};
use crate::can::{BitRate, CanId, Frame};
use crate::canopen::cob_id;
use crate::canopen::feature::Feature;
use crate::canopen::guarding::Guarding;
use crate::canopen::nmt::State;
use crate::canopen::product::{ContextOf, ParametersOf, Product};
use crate::canopen::protocol::{Canopen, Services};
use crate::node::Patterns;
use crate::param::Setting;
use crate::time::{Duration, Instant};

/// The settings of a node, for [`Slave`].
struct Unit<'a, P: Product> {
    /// The node-ID in force, which is not the one that is stored after a configuration.
    node_id: u8,
    cx: &'a mut ContextOf<P>,
}

impl<P: Product> Device for Unit<'_, P> {
    fn identity(&self, place: u8) -> u32 {
        let unit = self.cx.shell.unit();
        let number_of = |given: Option<u32>, printed: Setting| {
            given.unwrap_or_else(|| printed.get(&self.cx.parameters))
        };
        match place {
            0 => number_of(unit.vendor, Services::<P>::VENDOR_ID),
            1 => number_of(unit.product_code, Services::<P>::PRODUCT_CODE),
            2 => number_of(unit.revision, Services::<P>::REVISION_NUMBER),
            3 => self.cx.shell.serial(),
            _ => 0,
        }
    }

    fn node_id(&self) -> u8 {
        self.node_id
    }

    fn pending_node_id(&self) -> u8 {
        self.cx.parameters.get(P::NODE_ID) as u8
    }

    fn set_node_id(&mut self, node_id: u8) -> bool {
        let permitted = ParametersOf::<P>::check(P::NODE_ID, node_id.into()).is_ok();
        if permitted {
            self.cx.parameters.set(P::NODE_ID, node_id.into());
        }
        permitted
    }

    fn bit_rate(&self, table: u8, index: u8) -> Option<BitRate> {
        let own = P::LSS_RATES.iter().find(|(number, _)| *number == table);
        match own {
            Some((_, rates)) => rates.get(usize::from(index)).copied().flatten(),
            None => standard_bit_rate(table, index),
        }
    }

    fn set_bit_rate(&mut self, rate: BitRate) -> bool {
        let Some(&(number, _)) = P::BIT_RATES.iter().find(|(_, known)| *known == rate) else {
            return false;
        };
        let permitted = ParametersOf::<P>::check(P::BIT_RATE, number).is_ok();
        if permitted {
            self.cx.parameters.set(P::BIT_RATE, number);
        }
        permitted
    }
}

impl<P: Product> Canopen<P> {
    /// Returns true if a received frame is one of LSS, or is ignored because the node serves nothing else now.
    pub(in crate::canopen) fn layer_setting(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        frame: &Frame,
    ) -> bool {
        let Some(lss) = self.services.lss.get() else {
            return false;
        };
        let unconfigured = self.services.is_unconfigured();
        if lss.is_silent() {
            return true;
        }
        if frame.can_id() != CanId::standard(cob_id::LSS_REQUEST) {
            return unconfigured;
        }
        if (unconfigured || self.services.state != State::Initialising)
            && let Some(bytes) = frame.eight_bytes()
        {
            self.serve_lss(cx, now, bytes);
        }
        true
    }

    fn serve_lss(&mut self, cx: &mut ContextOf<P>, now: Instant, bytes: [u8; 8]) {
        let node_id = self.services.node_id;
        let Some(lss) = self.services.lss.get_mut() else {
            return;
        };
        let was_configuring = lss.slave.is_configuring();
        let outcome = lss.slave.serve(&mut Unit::<P> { node_id, cx }, bytes);
        let is_configuring = lss.slave.is_configuring();
        match outcome {
            Outcome::None => {}
            Outcome::Reply(bytes) => send_lss::<P>(cx, bytes),
            Outcome::Store => self.services.store_configuration(cx),
            Outcome::Activate(delay) => self.activate(cx, now, delay),
        }
        if was_configuring == is_configuring {
            return;
        }
        let pending = cx.parameters.get(P::NODE_ID);
        if !is_configuring && self.services.is_unconfigured() && pending != UNCONFIGURED.into() {
            self.reset_communication(cx, now);
        } else {
            self.services.indicate_lss(cx, now);
        }
        cx.shell.wake_up();
    }

    /// Becomes silent for the change of the bit rate.
    fn activate(&mut self, cx: &mut ContextOf<P>, now: Instant, delay: Duration) {
        self.sdo.end();
        let services = &mut self.services;
        services.state = State::Initialising;
        services.unsynchronised = 0;
        services.guarding = Guarding::OFF;
        services.heartbeat.stop();
        services.operate(now, false);
        services.emergency.silence();
        if let Some(lss) = services.lss.get_mut() {
            lss.store = Store::Idle;
            lss.activation.begin(now, delay);
        }
        cx.shell.clear_queue();
        cx.shell.wake_up();
    }

    /// Performs the actions of expired timers.
    pub(in crate::canopen) fn tick_lss(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let Some(lss) = self.services.lss.get_mut() else {
            return;
        };
        let step = lss.activation.poll(now);
        if lss.flicker.poll(now) {
            self.services.show(cx);
        }
        match step {
            None => {}
            Some(Step::Switch) => {
                self.services.rate = Services::<P>::pending_rate(cx);
                self.services.readdress(cx);
            }
            Some(Step::Resume) => self.reset_communication(cx, now),
        }
    }
}

impl<P: Product> Services<P> {
    const VENDOR_ID: Setting = Setting::at(P::OBJECTS, 0x1018, 1);
    const PRODUCT_CODE: Setting = Setting::at(P::OBJECTS, 0x1018, 2);
    const REVISION_NUMBER: Setting = Setting::at(P::OBJECTS, 0x1018, 3);

    /// Whether the node has no valid node-ID and serves only LSS.
    pub(in crate::canopen) fn is_unconfigured(&self) -> bool {
        P::Lss::PRESENT && self.node_id == UNCONFIGURED
    }

    /// The node-ID after reset communication.
    pub(in crate::canopen) fn pending_node_id(cx: &ContextOf<P>) -> u8 {
        let node_id = cx.parameters.get(P::NODE_ID) as u8;
        if P::Lss::PRESENT && node_id == UNCONFIGURED {
            return UNCONFIGURED;
        }
        node_id.clamp(1, 127)
    }

    /// The bit rate after reset communication.
    pub(in crate::canopen) fn pending_rate(cx: &ContextOf<P>) -> BitRate {
        let number = cx.parameters.get(P::BIT_RATE);
        let own = P::BIT_RATES.iter().find(|(own, _)| *own == number);
        own.map_or(BitRate::K125, |(_, rate)| *rate)
    }

    /// Enters the waiting state: the device restarts, or its communication.
    pub(in crate::canopen) fn reset_lss(&mut self) {
        if let Some(lss) = self.lss.get_mut() {
            lss.slave = Slave::WAITING;
            lss.store = Store::Idle;
        }
    }

    fn store_configuration(&mut self, cx: &mut ContextOf<P>) {
        let Some(lss) = self.lss.get_mut() else {
            return;
        };
        if cx.is_saving() {
            lss.store = Store::Waiting;
        } else {
            lss.store = Store::Running;
            self.save_configuration(cx);
        }
    }

    /// Handles the end of a save: answers store configuration, or begins the save that waited.
    pub(in crate::canopen) fn stored_lss(&mut self, cx: &mut ContextOf<P>, succeeded: bool) {
        let Some(lss) = self.lss.get_mut() else {
            return;
        };
        match core::mem::replace(&mut lss.store, Store::Idle) {
            Store::Idle => {}
            Store::Waiting => self.store_configuration(cx),
            Store::Running => send_lss::<P>(cx, Slave::stored(succeeded)),
        }
    }

    /// Lets the LEDs flicker in the configuration state and without a node-ID, while no other protocol is on the bus.
    pub(in crate::canopen) fn indicate_lss(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let (unconfigured, hosted) = (self.is_unconfigured(), self.is_hosted());
        if let Some(lss) = self.lss.get_mut() {
            let flickers = unconfigured || lss.slave.is_configuring();
            lss.flicker.set(now, flickers && !hosted);
        }
        self.show(cx);
    }

    /// The LEDs begin to flicker again after bus-off, in which the red LED is on.
    pub(in crate::canopen) fn resume_flicker(&mut self, now: Instant) {
        if let Some(lss) = self.lss.get_mut() {
            lss.flicker.restart(now);
        }
    }

    /// Replaces the patterns of the LEDs if they flicker. `bus_off`: the red LED shows bus-off.
    pub(in crate::canopen) fn overlay_flicker(&self, patterns: &mut Patterns, bus_off: bool) {
        if let Some(lss) = self.lss.get()
            && let Some((run, error)) = lss.flicker.patterns()
        {
            patterns.run = run;
            patterns.error = if bus_off { patterns.error } else { error };
        }
    }
}

fn send_lss<P: Product>(cx: &mut ContextOf<P>, bytes: [u8; 8]) {
    let id = CanId::standard(cob_id::LSS_REPLY);
    cx.shell.send(Frame::word(id, u64::from_le_bytes(bytes), 8));
}
