//! Mode changes and their effects: reset by CAN_MCR.RESET, joining and leaving the bus, recovery from bus-off.

use super::errors::Confinement;
use super::mode::{Change, Mode};
use super::registers::Register;
use super::silicon::{self, Resetting};
use super::transmit::Outcome;
use super::{BxCan, Recovery};
use can_wire::protocol::Picoseconds;
use plumbline::node::BusState;

impl BxCan {
    /// A reset by CAN_MCR.RESET: the controller leaves the bus at once.
    pub(super) fn begin_reset(&mut self, now: Picoseconds) {
        let again = self.state.control.retransmits();
        self.state.transmitter.ended(Outcome::Failed, again);
        self.protocol.leave();
        self.recovery = Recovery::None;
        self.state.control.reset();
        for fifo in &mut self.state.fifos {
            fifo.discard();
        }
        self.resetting = Some(Resetting::begin(self.silicon.reset, now, self.clock));
        self.requested_at = now;
        self.changed = true;
    }

    /// When initialization or sleep mode is acknowledged.
    pub(super) fn acknowledges_at(&self) -> Option<Picoseconds> {
        let due = self.state.control.due(self.protocol.is_busy());
        let waits = self.resetting.is_none() && matches!(due, Some(Change::Acknowledge(_)));
        waits.then(|| self.requested_at + silicon::time(self.silicon.mode, self.clock))
    }

    /// Updates the mode, the recovery and the error status after events and requests.
    pub(super) fn settle(&mut self, now: Picoseconds) {
        self.violations.now = now;
        for fifo in &mut self.state.fifos {
            fifo.settle(now);
        }
        if self.resetting.is_some_and(|reset| reset.has_ended(now)) {
            self.resetting = None;
            self.requested_at = now;
        }
        match self.state.control.due(self.protocol.is_busy()) {
            Some(Change::Join) => self.join(now),
            Some(Change::Acknowledge(mode))
                if self.acknowledges_at().is_some_and(|at| at <= now) =>
            {
                self.acknowledge(mode)
            }
            _ => {}
        }
        if self.is_recovery_due() {
            self.protocol.recover(now);
            self.recovery = Recovery::UnderWay;
            self.changed = true;
        }
        let before = self.state.status.interrupts();
        self.state
            .status
            .sleeps(self.state.control.mode() == Mode::Sleep);
        self.state.status.follow(Confinement::from(&self.protocol));
        self.changed |= before != self.state.status.interrupts();
    }

    /// Starts to wait for 11 recessive bits.
    fn join(&mut self, now: Picoseconds) {
        let state = &mut self.state;
        if let Some(fault) = state.timing.fault(self.clock) {
            self.violations.record(Register::BitTiming.name(), fault);
        }
        if state.timing.is_silent() && state.transmitter.is_pending() {
            let register = Register::TransmitStatus.name();
            self.violations
                .record(register, "a transmission is pending in silent mode");
        }
        state.control.joining();
        if state.timing.is_silent() {
            self.lock.silence();
        }
        let timing = state.timing.bit_timing(self.clock);
        self.protocol.join(now, timing, state.timing.is_silent());
        let in_bus_off = self.protocol.state() == BusState::BusOff;
        if in_bus_off && !self.is_recovery_due() {
            self.state.control.joined();
        }
        self.changed = true;
    }

    /// Leaves the bus and acknowledges a mode.
    fn acknowledge(&mut self, mode: Mode) {
        self.protocol.leave();
        self.state.control.enter(mode);
        let asked = mode == Mode::Initialization || self.recovery == Recovery::Due;
        self.recovery = if asked && self.protocol.state() == BusState::BusOff {
            Recovery::Due
        } else {
            Recovery::None
        };
        self.changed = true;
    }

    /// True when the recovery from bus-off has to begin: on the bus, and requested or automatic.
    fn is_recovery_due(&self) -> bool {
        let asked = match self.recovery {
            Recovery::None => self.state.control.recovers(),
            Recovery::Due => true,
            Recovery::UnderWay => false,
        };
        asked && self.state.control.is_on() && self.protocol.state() == BusState::BusOff
    }
}
