//! The protocol-neutral half of a node: transmit queue, bit rate detection, fault confinement, LEDs and restart.

use super::{Autobaud, BitTime, BusChange, BusMode, BusState, Patterns, TransmitQueue};
use crate::application::Outputs;
use crate::can::{BitRate, CanId, Frame};
use crate::store::{Boot, Unit};
use crate::time::{Deadline, Duration, Instant, after, millis, reached};
use crate::update::Installed;
use heapless::Deque;

mod work;

/// The maximum number of received frames that wait for the end of a save.
const DEFERRED: usize = 2;

/// The longest time that a restart waits for replies in the queue.
const RESTART_PATIENCE: Duration = millis(250);

/// The time for which values are valid without a new reading. After it, the accelerometer has failed.
const READING_LIMIT: Duration = millis(100);

/// The longest time to the first reading: 100 ms from power-up, of which a board needs up to 11 ms before the start of the node and
/// until the first frame.
const FIRST_READING_LIMIT: Duration = millis(89);

/// Whether the node takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NodeState {
    /// Off the bus, before the first reading.
    Initial,
    /// The bit rate is being detected.
    Detecting(Autobaud),
    /// The node takes part in the traffic.
    Online,
    /// The controller is bus-off.
    BusOff,
    /// A restart is accepted. It is requested when the queue is empty, at this time at the latest.
    Restarting(Instant),
    /// The restart is requested from the driver.
    Restarted,
}

/// Causes for which the node takes no frame, one bit for each.
pub(super) mod cause {
    /// The parameters of an earlier frame are not applied yet.
    pub const PARAMETERS: u8 = 1;
    /// [`Action::Bus`](crate::node::Action::Bus) is pending: the frames received until then are discarded.
    pub const BUS: u8 = 2;
    /// A restart is accepted, so the node takes no more requests.
    pub const LEAVING: u8 = 4;
    /// During a save: no room for a deferred frame. After it: deferred frames come first.
    pub const DEFERRED: u8 = 8;
}

/// The protocol-neutral half of a node.
pub struct Shell {
    /// The serial number of the chip.
    serial: u32,
    unit: Unit,
    /// The program behind a bootloader.
    program: Option<Installed>,
    state: NodeState,
    bus_state: BusState,
    queue: TransmitQueue,
    /// The [causes](cause) for which the node takes no frame. One byte, because it is checked for each frame.
    blocked: u8,
    /// The received frames that wait for the running save to end.
    deferred: Deque<Frame, DEFERRED>,
    /// The end of the validity of the values without a new reading.
    valid_until: Instant,
    /// The values are no longer valid.
    is_stale: bool,
    /// The protocol has started: there was a reading, or it is too late for one.
    is_running: bool,
    /// The patterns of the LEDs.
    patterns: Patterns,
    /// The outputs that were reported to the hardware.
    reported: Outputs,
    /// The last mode and bit rate that the node has requested.
    bus: (BusMode, BitRate),
    /// The patterns have changed, and the LEDs must show them.
    new_patterns: bool,
    /// Actions that the driver must perform, besides [`cause::BUS`].
    recover: bool,
    save: bool,
    /// The application must stop, because a restart is accepted.
    stop: bool,
    /// The next restart is that into the bootloader.
    updates: bool,
    /// There may be an action or a new deadline. Each cause sets this flag, so that the check for work is short.
    dirty: bool,
    wake: Deadline,
}

impl Shell {
    /// A node that is not started. All bits are 0.
    pub(super) const INITIAL: Self = Self {
        serial: 0,
        unit: Unit::NONE,
        program: None,
        state: NodeState::Initial,
        bus_state: BusState::Active,
        queue: TransmitQueue::EMPTY,
        blocked: 0,
        deferred: Deque::new(),
        valid_until: Instant::from_ticks(0),
        is_stale: false,
        is_running: false,
        patterns: Patterns::DARK,
        reported: Outputs::NONE,
        bus: (BusMode::Listen, BitRate::K10),
        new_patterns: false,
        recover: false,
        save: false,
        stop: false,
        updates: false,
        dirty: false,
        wake: Deadline::NEVER,
    };

    /// Starts with the identity of the unit, and with room in the queue for this number of frames that are not replies.
    pub(super) fn start(&mut self, now: Instant, boot: &Boot, frames: usize) {
        self.queue.reserve(frames);
        self.serial = boot.serial;
        self.unit = boot.unit;
        self.program = boot.program;
        self.valid_until = after(now, FIRST_READING_LIMIT);
        self.dirty = true;
    }

    /// Handles the values of a reading, or of missing readings. Returns true for the first ones: the protocol must start.
    pub(super) fn starts(&mut self) -> bool {
        self.dirty |= !self.is_running;
        !core::mem::replace(&mut self.is_running, true)
    }

    /// Whether the protocol has started.
    pub(super) fn is_running(&self) -> bool {
        self.is_running
    }

    /// The identity that the unit has in place of that of its product.
    pub fn unit(&self) -> &Unit {
        &self.unit
    }

    /// The serial number of the unit: that of its identity, or else that of the chip.
    #[inline(never)] // measured: smaller, and no answer takes longer
    pub fn serial(&self) -> u32 {
        self.unit.serial.unwrap_or(self.serial)
    }

    /// The program, if a [bootloader](crate::update) has started it. Without one, a request for an update gets the error of
    /// an unknown request, as from the original.
    pub fn program(&self) -> Option<Installed> {
        self.program
    }

    /// Whether the node takes part in the bus.
    pub fn state(&self) -> NodeState {
        self.state
    }

    /// The fault confinement state of the CAN controller.
    pub fn bus_state(&self) -> BusState {
        self.bus_state
    }

    /// The bit rate that the node has requested last.
    pub fn rate(&self) -> BitRate {
        let (_, rate) = self.bus;
        rate
    }

    /// Whether the node is on the bus.
    pub fn is_online(&self) -> bool {
        self.state == NodeState::Online
    }

    /// Whether a restart is accepted.
    pub fn is_leaving(&self) -> bool {
        self.is_blocked(cause::LEAVING)
    }

    /// Requests the steps of the timers: there is an action, or a deadline has changed.
    pub fn wake_up(&mut self) {
        self.dirty = true;
    }

    // Transmission, used by a protocol.

    /// Queues a frame that must not be lost.
    pub fn send(&mut self, frame: Frame) {
        self.queue.reply(frame);
    }

    /// Queues a cyclic value. It replaces a queued one with the same identifier.
    pub fn send_cyclic(&mut self, frame: Frame) {
        self.queue.cyclic(frame);
    }

    /// Removes the cyclic value with this identifier from the queue.
    pub fn withdraw(&mut self, id: CanId) {
        self.queue.withdraw(id);
    }

    /// Removes all frames from the queue.
    pub fn clear_queue(&mut self) {
        self.queue.clear();
    }

    /// Whether the queue has room for frames beyond its reserve.
    pub fn has_room(&self) -> bool {
        self.queue.has_room()
    }

    // Bus state, used by a protocol.

    /// Takes part in the bus at this bit rate, with the present filters of the protocol.
    pub fn go_online(&mut self, rate: BitRate) {
        if !self.is_leaving() && self.state != NodeState::BusOff {
            self.state = NodeState::Online;
        }
        self.switch_bus(BusMode::Normal, rate);
    }

    /// Leaves bus-off for a restart of the protocol, also without automatic recovery: the controller recovers after
    /// [`go_online`](Self::go_online), which must follow. Returns false if the node is not in bus-off.
    pub fn leave_bus_off(&mut self) -> bool {
        let was_off = self.state == NodeState::BusOff;
        if was_off {
            self.state = NodeState::Online;
            self.bus_state = BusState::Active;
            self.recover = true;
        }
        was_off
    }

    /// Shows these patterns on the LEDs. During a restart the LEDs are off.
    pub fn show(&mut self, patterns: Patterns) {
        self.patterns = if self.is_leaving() {
            Patterns::DARK
        } else {
            patterns
        };
        self.new_patterns = true;
    }

    /// Accepts a restart: the node takes no more frames and still sends the queued replies.
    pub fn restart(&mut self, now: Instant) {
        self.state = NodeState::Restarting(after(now, RESTART_PATIENCE));
        self.block(cause::LEAVING, true);
        self.stop = true;
        self.show(Patterns::DARK);
        self.dirty = true;
    }

    /// The next [restart](Self::restart) is that into the bootloader, which gets the contact data of the
    /// [protocol](super::Protocol::contact).
    pub fn enter_bootloader(&mut self) {
        self.updates = true;
    }

    /// Keeps a received frame until the running save has ended. When two frames are kept, the node takes no more frames.
    pub fn defer(&mut self, frame: &Frame) {
        // There is room: without room, the node does not take the frame.
        let _ = self.deferred.push_back(*frame);
        self.order_deferred(true);
    }

    /// Whether a frame is kept.
    pub fn has_deferred(&self) -> bool {
        !self.deferred.is_empty()
    }

    // Methods for the node.

    /// Whether the node can take the next frame. These causes are ignored.
    pub(super) fn ready(&self, ignored: u8) -> bool {
        self.blocked & !ignored == 0 && self.queue.has_room()
    }

    /// Whether the restart is that into the bootloader.
    pub(super) fn enters_bootloader(&self) -> bool {
        self.updates
    }

    pub(super) fn is_blocked(&self, cause: u8) -> bool {
        self.blocked & cause != 0
    }

    /// Sets or clears a cause for which the node takes no frame.
    pub(super) fn block(&mut self, cause: u8, set: bool) {
        self.blocked = self.blocked & !cause | if set { cause } else { 0 };
    }

    /// The node takes no frame if there is no room for deferred frames, or if they must be handled first.
    pub(super) fn order_deferred(&mut self, saving: bool) {
        let waits = if saving {
            self.deferred.is_full()
        } else {
            self.has_deferred()
        };
        self.block(cause::DEFERRED, waits);
    }

    /// Begins the bit rate detection.
    pub(super) fn detect(&mut self) {
        self.state = NodeState::Detecting(Autobaud::START);
        self.listen();
    }

    /// Handles a valid frame during the bit rate detection.
    pub(super) fn found(&mut self) {
        if let NodeState::Detecting(search) = &mut self.state {
            search.receive();
        }
    }

    /// The detected bit rate, if the node can go online with it.
    pub(super) fn detected(&self) -> Option<BitRate> {
        match self.state {
            NodeState::Detecting(search) if self.is_running => search.found(),
            _ => None,
        }
    }

    /// Listens at the bit rate of the running search.
    fn listen(&mut self) {
        if let NodeState::Detecting(search) = self.state {
            self.switch_bus(BusMode::Listen, search.rate());
        }
    }

    fn switch_bus(&mut self, mode: BusMode, rate: BitRate) {
        self.bus = (mode, rate);
        self.block(cause::BUS, true);
        self.dirty = true;
    }

    pub(super) fn error(&mut self) {
        if let NodeState::Detecting(search) = &mut self.state {
            search.error();
        }
    }

    /// Handles the measured bit time of a frame.
    pub(super) fn measured(&mut self, time: BitTime) {
        if let NodeState::Detecting(search) = &mut self.state
            && search.measured(time)
        {
            self.listen();
        }
    }

    /// Handles a change of the fault confinement state. Without recovery, a node in bus-off stays there until a restart and the
    /// result is None.
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

    /// Notes a reading: the values are valid for [`READING_LIMIT`] from now on.
    pub(super) fn sampled(&mut self, now: Instant) {
        self.dirty |= core::mem::take(&mut self.is_stale);
        self.valid_until = after(now, READING_LIMIT);
    }

    /// Returns true once when the values are no longer valid, because readings are missing.
    pub(super) fn becomes_stale(&mut self, now: Instant) -> bool {
        let stale = !self.is_stale && reached(now, self.valid_until) && !self.is_leaving();
        self.is_stale |= stale;
        stale
    }

    pub(super) fn take_deferred(&mut self) -> Option<Frame> {
        self.deferred.pop_front()
    }

    /// Returns true once if the application must stop.
    pub(super) fn stops(&mut self) -> bool {
        core::mem::take(&mut self.stop)
    }

    /// Whether the queue has a frame.
    pub fn is_sending(&self) -> bool {
        !self.queue.is_empty()
    }

    pub(super) fn transmit(&mut self) -> Option<Frame> {
        // `Action::Bus` would discard the frame in its mailbox.
        if self.is_blocked(cause::BUS) {
            return None;
        }
        match self.state {
            NodeState::Online => {}
            // The restart waits until the queue is empty.
            NodeState::Restarting(_) => self.dirty = true,
            _ => return None,
        }
        self.queue.pop()
    }
}
