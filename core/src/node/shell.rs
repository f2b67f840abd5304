//! The protocol-neutral half of a node: transmit queue, bit rate detection, fault confinement, LEDs, restart, and the actions that
//! wait to be polled.

use super::{Action, Autobaud, BusChange, BusMode, BusState, Indicator, Patterns, TransmitQueue};
use crate::application::Outputs;
use crate::can::{BitRate, CanId, Frame};
use crate::time::{Duration, Earliest, Instant, after, millis, reached};

/// How long a restart waits for replies that are still in the queue.
const RESTART_PATIENCE: Duration = millis(250);

/// How long values are valid without a further reading; then the accelerometer has failed.
const READING_LIMIT: Duration = millis(100);

/// Whether the node takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NodeState {
    /// Not started yet.
    Initial,
    /// The bit rate is being detected.
    Detecting(Autobaud),
    /// On the bus.
    Online,
    /// Off the bus after too many errors.
    BusOff,
    /// A restart was accepted; it happens when the queue is empty, at the latest at this time.
    Restarting(Instant),
    /// The restart has been asked for.
    Restarted,
}

/// The protocol-neutral half of a node.
pub struct Shell {
    serial: u32,
    state: NodeState,
    bus_state: BusState,
    queue: TransmitQueue,
    /// A received frame that waits for the running save to end.
    deferred: Option<Frame>,
    /// The values are valid until then without a further reading,
    valid_until: Instant,
    /// or not any more.
    is_stale: bool,
    indicator: Indicator,
    /// The outputs that the hardware was told.
    reported: Outputs,
    /// The mode and rate of the bus.
    bus: (BusMode, BitRate),
    /// Actions that wait to be polled: that mode and rate,
    new_bus: bool,
    recover: bool,
    save: bool,
    /// The application is to stop, because a restart was accepted.
    stop: bool,
    /// There may be something to do, or another deadline, since the last poll that found nothing. Whoever causes that sets it,
    /// because a poll that finds nothing to do costs as much as a request.
    dirty: bool,
    wake: Option<Instant>,
}

impl Shell {
    /// A node that was not started, with all bits 0.
    pub(super) const INITIAL: Self = Self {
        serial: 0,
        state: NodeState::Initial,
        bus_state: BusState::Active,
        queue: TransmitQueue::EMPTY,
        deferred: None,
        valid_until: Instant::from_ticks(0),
        is_stale: false,
        indicator: Indicator::DARK,
        reported: Outputs::NONE,
        bus: (BusMode::Listen, BitRate::K10),
        new_bus: false,
        recover: false,
        save: false,
        stop: false,
        dirty: false,
        wake: None,
    };

    /// Starts with the serial number of the unit, and with room in the queue for so many frames besides replies.
    pub(super) fn start(&mut self, now: Instant, serial: u32, frames: usize) {
        self.queue.reserve(frames);
        self.serial = serial;
        self.valid_until = after(now, READING_LIMIT);
        self.dirty = true;
    }

    /// The serial number of the unit.
    pub fn serial(&self) -> u32 {
        self.serial
    }

    /// Whether the node takes part in the bus.
    pub fn state(&self) -> NodeState {
        self.state
    }

    /// The fault confinement state of the CAN controller.
    pub fn bus_state(&self) -> BusState {
        self.bus_state
    }

    /// Whether the node is on the bus.
    pub fn is_online(&self) -> bool {
        self.state == NodeState::Online
    }

    /// Whether a restart was accepted.
    pub fn is_leaving(&self) -> bool {
        matches!(self.state, NodeState::Restarting(_) | NodeState::Restarted)
    }

    /// Has the node polled again: something is to be done, or a deadline has changed.
    pub fn wake_up(&mut self) {
        self.dirty = true;
    }

    // What a protocol sends.

    /// Queues a frame that must not be lost.
    pub fn send(&mut self, frame: Frame) {
        self.queue.reply(frame);
    }

    /// Queues a value that takes the place of an older one with the same identifier.
    pub fn send_cyclic(&mut self, frame: Frame) {
        self.queue.cyclic(frame);
    }

    /// Drops the cyclic value with this identifier, if one waits.
    pub fn withdraw(&mut self, id: CanId) {
        self.queue.withdraw(id);
    }

    /// Drops every frame that waits.
    pub fn clear_queue(&mut self) {
        self.queue.clear();
    }

    /// Whether there is room in the queue for more than what must not be lost.
    pub fn has_room(&self) -> bool {
        self.queue.has_room()
    }

    // How a protocol takes part in the bus.

    /// Listens for the bit rate.
    pub fn detect(&mut self, now: Instant) {
        self.state = NodeState::Detecting(Autobaud::start(now));
        self.listen();
    }

    /// Takes part in the bus at this rate, with the protocol's filters as they are now.
    pub fn go_online(&mut self, rate: BitRate) {
        if !self.is_leaving() && self.state != NodeState::BusOff {
            self.state = NodeState::Online;
        }
        self.switch_bus(BusMode::Normal, rate);
    }

    /// Shows these patterns on the LEDs; a node that restarts shows nothing.
    pub fn show(&mut self, now: Instant, patterns: Patterns) {
        let patterns = if self.is_leaving() {
            Patterns::default()
        } else {
            patterns
        };
        self.indicator.show(now, patterns);
        self.dirty = true;
    }

    /// Accepts a restart: nothing more is taken in, the replies on their way still go out.
    pub fn restart(&mut self, now: Instant) {
        self.state = NodeState::Restarting(after(now, RESTART_PATIENCE));
        self.stop = true;
        self.show(now, Patterns::default());
    }

    /// Keeps a received frame until the running save has ended. Until then no further frame is taken in.
    pub fn defer(&mut self, frame: &Frame) {
        self.deferred = Some(*frame);
    }

    // What the node does.

    pub(super) fn ready(&self) -> bool {
        self.queue.has_room() && self.deferred.is_none() && !self.is_leaving()
    }

    /// Listens at the candidate of the running search.
    fn listen(&mut self) {
        if let NodeState::Detecting(search) = self.state {
            self.switch_bus(BusMode::Listen, search.rate());
        }
    }

    fn switch_bus(&mut self, mode: BusMode, rate: BitRate) {
        self.bus = (mode, rate);
        self.new_bus = true;
        self.dirty = true;
    }

    /// A bus error was seen. True when the node listens at another rate now.
    pub(super) fn error(&mut self, now: Instant) -> bool {
        let NodeState::Detecting(search) = &mut self.state else {
            return false;
        };
        search.error(now);
        self.listen();
        true
    }

    /// The fault confinement state has changed. None when that is of no importance: without recovery a node that went bus-off
    /// stays so until it is restarted, whatever the controller does.
    pub(super) fn confine(&mut self, state: BusState, recovers: bool) -> Option<BusChange> {
        let was_off = self.state == NodeState::BusOff;
        if was_off && !recovers {
            return None;
        }
        self.bus_state = state;
        self.dirty = true;
        if self.state == NodeState::Online && state == BusState::BusOff {
            self.state = NodeState::BusOff;
            self.recover = recovers;
        } else if was_off && state != BusState::BusOff {
            self.state = NodeState::Online;
            return Some(BusChange::Recovered);
        }
        Some(BusChange::State)
    }

    /// A reading has come.
    pub(super) fn sampled(&mut self, now: Instant) {
        self.dirty |= core::mem::take(&mut self.is_stale);
        // As `after`, which is not inlined: the end of time does not come.
        self.valid_until = Instant::from_ticks(now.ticks().wrapping_add(READING_LIMIT.ticks()));
    }

    /// Readings are missing: the values are no longer valid. True once.
    pub(super) fn becomes_stale(&mut self, now: Instant) -> bool {
        let stale = !self.is_stale && reached(now, self.valid_until) && !self.is_leaving();
        self.is_stale |= stale;
        stale
    }

    /// Moves on in the search for the bit rate; true when the node listens at another rate now.
    pub(super) fn search(&mut self, now: Instant) -> bool {
        let moved = match &mut self.state {
            NodeState::Detecting(search) => search.poll(now),
            _ => false,
        };
        if moved {
            self.listen();
        }
        moved
    }

    pub(super) fn take_deferred(&mut self) -> Option<Frame> {
        self.deferred.take()
    }

    /// Whether the application is to stop; true once.
    pub(super) fn stops(&mut self) -> bool {
        core::mem::take(&mut self.stop)
    }

    pub(super) fn begin_save(&mut self) {
        self.save = true;
        self.dirty = true;
    }

    /// True when a poll would find nothing to do.
    pub(super) fn is_idle(&self, now: Instant) -> bool {
        let due = self.wake.is_some_and(|wake| reached(now, wake));
        !self.dirty && !due
    }

    /// The next action that is wanted, most urgent first; `outputs` is what the application wants.
    pub(super) fn next_action(&mut self, now: Instant, outputs: Option<Outputs>) -> Option<Action> {
        if let Some(leds) = self.indicator.poll(now) {
            return Some(Action::Leds(leds));
        }
        if core::mem::take(&mut self.new_bus) {
            let (mode, rate) = self.bus;
            return Some(Action::Bus(mode, rate));
        }
        if core::mem::take(&mut self.recover) {
            return Some(Action::Recover);
        }
        if core::mem::take(&mut self.save) {
            return Some(Action::Save);
        }
        if let Some(outputs) = outputs
            && outputs != self.reported
        {
            return Some(self.report(outputs));
        }
        match self.state {
            NodeState::Restarting(until) if self.queue.is_empty() || reached(now, until) => {
                self.state = NodeState::Restarted;
                Some(Action::Restart)
            }
            _ => None,
        }
    }

    /// Tells the hardware one of the outputs that differ.
    fn report(&mut self, outputs: Outputs) -> Action {
        if let Some(connected) = outputs.termination()
            && outputs.termination() != self.reported.termination()
        {
            self.reported = self.reported.with_termination(connected);
            return Action::Termination(connected);
        }
        if let Some(duty) = outputs.heater()
            && outputs.heater() != self.reported.heater()
        {
            self.reported = self.reported.with_heater(duty);
            return Action::Heater(duty);
        }
        self.reported = outputs;
        Action::SelfTest
    }

    /// Whether the hardware was told these outputs.
    pub(super) fn has_reported(&self, outputs: Outputs) -> bool {
        self.reported == outputs
    }

    /// What [`Node::transmit`](super::Node::transmit) hands out.
    pub(super) fn transmit(&mut self) -> Option<Frame> {
        // The change of the bus would drop it from its mailbox.
        if self.queue.is_empty() || self.new_bus {
            return None;
        }
        match self.state {
            NodeState::Online => {}
            // The restart waits for the queue to run empty.
            NodeState::Restarting(_) => self.dirty = true,
            _ => return None,
        }
        self.queue.pop()
    }

    /// A poll has ended: `earliest` is the protocol's and the application's next deadline.
    pub(super) fn polled(&mut self, more: bool, mut earliest: Earliest) {
        match self.state {
            NodeState::Detecting(search) => earliest.consider(Some(search.deadline())),
            NodeState::Restarting(until) => earliest.consider(Some(until)),
            _ => {}
        }
        if !self.is_stale && !self.is_leaving() {
            earliest.consider(Some(self.valid_until));
        }
        self.indicator.consider(&mut earliest);
        self.dirty = more;
        self.wake = earliest.instant();
    }

    pub(super) fn deadline(&self) -> Option<Instant> {
        self.wake
    }
}
