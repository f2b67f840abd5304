//! The order in which a driver drives a node. The boards, the simulated sensors and the examples use this code.
//!
//! A driver implements two traits, [`Controller`] and [`Platform`], and calls a [`Driver`]:
//!
//! ```text
//!   receive interrupt  --> Link::receive ----+        +--> Controller::put, abort, phase, ...
//!   transmit interrupt --> Link::transmitted-+-> node-+
//!   main loop          --> Driver::sample ---+        +--> Platform::perform, save, restart, ...
//!                          Driver::turn -----+
//! ```
//!
//! A driver of any product has one bound, [`ProductNode`](super::ProductNode): it starts the node, and has the owner of its store, its
//! sizes and its two halves.
//!
//! # With one thread
//!
//! A [`Driver`] of [`OneThread`] has a [`Node`](super::Node) and its controller. In a loop:
//!
//! 1. Pass each received frame to [`Driver::receive`], each frame that was sent to [`Driver::transmitted`], and every
//!    [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD) a reading to [`Driver::sample`].
//! 2. Call [`Driver::turn`] until it returns false. It requests bus changes, saves and other actions from the [`Platform`].
//! 3. Wait until the next input, at the latest until [`Driver::deadline`].
//!
//! This is the example `driver_one_thread`:
//!
#![doc = "```"]
#![doc = include_str!("../../../examples/driver_one_thread.rs")]
#![doc = "```"]
//!
//! # With two priorities
//!
//! The readings take long, and a frame must not wait for their calculation. So the interrupts of the CAN controller use the
//! [`Link`]: the communicating half of the node with its controller. The main loop has a [`Driver`] of [`TwoPriorities`] with the
//! measuring half. The driver implements [`Shared`]: the link in memory that both use, for example in a `Mutex` of the crate
//! `critical-section`. No use of the link is longer than a few microseconds.
//!
//! 1. The receive interrupt passes each frame to [`Link::receive`]. The answer is in a mailbox when it returns.
//! 2. The transmit interrupt calls [`Link::transmitted`] when a mailbox has become free.
//! 3. Both wake the main loop, which does the rest as with one thread.
//!
//! This is the example `driver_two_priorities`:
//!
#![doc = "```"]
#![doc = include_str!("../../../examples/driver_two_priorities.rs")]
#![doc = "```"]
//!
//! # What a driver must do
//!
//! | when | call | at which priority |
//! |---|---|---|
//! | a frame was received | [`Driver::receive`] or [`Link::receive`] | the loop, or the receive interrupt |
//! | a mailbox has become free | [`Driver::transmitted`] or [`Link::transmitted`] | the loop, or the transmit interrupt |
//! | every [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD) | [`Driver::sample`], and [`Driver::supply`] if the product measures it | the loop |
//! | readings were lost | [`Driver::interrupt`], before the next reading | the loop |
//! | a self-test or a save has ended | [`Driver::tested`], [`Driver::stored`] | the loop |
//! | after each of these, and at [`Driver::deadline`] | [`Driver::turn`] until it returns false | the loop |
//! | each millisecond while a change of the mode runs | [`Driver::turn`] | the loop |
//!
//! - **Start**: open the [store](super::StoreOf) of the [owner](super::ProductNode::owner), let it
//!   [erase in advance](crate::store::Store::prepare), start the node with its [`boot`](crate::store::Store::boot), then call
//!   [`Driver::turn`]. The controller is off the bus until the first [`Action::Bus`]. Readings begin within 89 ms: without one, the node
//!   reports a sensor error.
//! - **Waiting**: no method of [`Controller`] and no use of the link waits. With one thread, each wait in the loop delays the answers. With
//!   two priorities, the loop may wait between two readings, for example for a sector of the flash.
//! - **Change of the mode** ([`Action::Bus`]): [`Platform::perform`] notes it. The steps abort the frames in the mailboxes, discard the
//!   received frames and errors, and set bit timing and filters. Then the phase is [`Phase::Waiting`], until the controller has seen
//!   11 recessive bits. If the bus stays dominant, the change does not end, and the node can request another one.
//! - **Bus-off**: [`Platform::event`] returns each change of the fault confinement state once. The controller does not leave bus-off
//!   before [`Action::Recover`]. Then the driver reports [`BusState::Active`](super::BusState::Active).
//! - **Save**: [`Platform::save`] begins it ([`Store::save`](crate::store::Store::save)), and the loop performs its
//!   [steps](crate::store::Store::step) until the result, which it passes to [`Driver::stored`]. A board without memory reports an error at
//!   once. Without a report, the node waits for the end of the save forever, and takes no more frames that must wait for it.
//! - **Power cut**: the store has the earlier record until the new one is complete, so a driver does nothing. If the supply is too low
//!   to program the memory, report the save as failed.
//! - **Restart**: [`Platform::restart`] comes after the last frame. Switch off the heater, keep the word, and reset the chip. Pass the word to
//!   the next start ([`Boot::kept`](super::Boot::kept)), but 0 after power-up. If `restart` returns, the driver starts the node again, with
//!   a new [`Driver`].
//! - **Watchdog**: feed it once in each iteration of the loop. A turn performs at most eight actions.
//!
//! # What the order ensures
//!
//! - A frame is answered on reception, also during a calculation or a save. While the node cannot take it, because the parameters
//!   of an earlier frame are not applied yet or the bit rate changes, it waits in the [`Line`], and later frames wait behind it.
//! - The answer to a frame does not overtake an earlier frame of the node, and a newer frame does not overtake the answer.
//! - At a change of the bit rate, no frame of the old bit rate is received or sent. At a change of the filters only, received frames wait
//!   and none is lost, and no frame with an old address is sent.
//! - A bit rate is changed before the next event is read: an error at the old bit rate does not count at the new one.
//! - Parameters are applied before the next reading, and not during a save.
//! - A restart waits for the end of a save, then for the frames in the mailboxes, but not longer than 100 ms: another node may be
//!   missing that acknowledges them.

mod line;
mod order;
mod sides;

pub use line::{Exchange, Line, Link};
pub(super) use order::Reach;
pub use order::Round;
pub use sides::{LinkOf, OneThread, Shared, Side, TwoPriorities};

use super::{Action, BusEvent};
use crate::can::{BitRate, Filter, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::store::StoreError;
use crate::time::{Duration, Instant, after, earlier, millis, reached};

/// The maximum number of actions in one [`Driver::turn`]. The limit ensures that a watchdog is fed even if each frame causes an action.
const ROUNDS: u8 = 8;

/// The longest time that a restart waits for the last frames: four frames, one of them waiting for a mailbox, of 16 ms each at 10
/// kbit/s.
const RESTART_LIMIT: Duration = millis(100);

/// What a driver may do with frames.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phase {
    /// The controller is off the bus, or leaves it: received frames are discarded.
    Off,
    /// The controller joins the bus, or its filters change: received frames wait.
    Waiting,
    /// Listen-only: frames are received.
    Listening,
    /// Frames are received and sent.
    Normal,
}

impl Phase {
    /// Whether received frames are passed to the node.
    pub fn receives(self) -> bool {
        matches!(self, Self::Listening | Self::Normal)
    }
}

/// The transmit mailboxes of a CAN controller. On a driver with two priorities, its methods are called in the interrupts and in
/// [`Shared::with`].
pub trait Controller {
    /// The time of the call, from the clock of the driver.
    fn now(&self) -> Instant;

    /// What the driver may do with frames. The [`Platform`] sets the phase with its changes of the mode, this trait with
    /// [`pause`](Self::pause).
    fn phase(&self) -> Phase;

    /// Sets [`Phase::Off`] or [`Phase::Waiting`], until the platform has performed the requested change.
    fn pause(&mut self, phase: Phase);

    /// Whether the controller is in normal mode at this bit rate, no change is running, and it is not in bus-off. It does not depend on
    /// [`pause`](Self::pause). False, the default, for a driver that cannot [change the filters](Platform::refilter) on the bus: then
    /// such a change is an [`Action::Bus`].
    fn is_at(&self, rate: BitRate) -> bool {
        let _ = rate;
        false
    }

    /// Whether a frame can be put into a mailbox. Use at most two mailboxes: the second frame follows the first without a gap, and a
    /// newer cyclic value replaces one that does not wait in a mailbox yet.
    fn has_room(&self) -> bool;

    /// Whether all mailboxes are empty.
    fn is_idle(&self) -> bool;

    /// Puts a frame into a mailbox. The controller sends them in the order of the calls. If `once`, it does not repeat the frame
    /// after a bit error ([`Link::transmitted`] reports it). After a lost arbitration or without acknowledge it sends the frame
    /// again at once.
    fn put(&mut self, frame: &Frame, once: bool);

    /// Aborts the frames in the mailboxes. A frame on the bus is not aborted if its transmission succeeds.
    fn abort(&mut self);

    /// A received frame was lost. [`Platform::event`] reports [`BusEvent::Overrun`], once for several frames.
    fn lose(&mut self);
}

/// The hardware around a node, except the mailboxes: the mode of the CAN controller, LEDs, store, outputs.
pub trait Platform {
    /// Performs a step of a running change of the mode: see [`Action::Bus`]. `filters` passes the filters in force to its argument.
    /// Returns true if the change has ended with this step: then the phase is [`Phase::Listening`] or [`Phase::Normal`]. It is
    /// called in each turn and at once after an [`Action::Bus`].
    fn step(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool;

    /// The next event of the CAN controller, except [`BusEvent::Unsent`]; None if there is no more. Each event is returned once: a turn
    /// calls it until it returns None.
    fn event(&mut self) -> Option<BusEvent>;

    /// Discards the frames in the mailboxes, sets these filters and the phase [`Phase::Normal`]. The controller stays on the bus, and
    /// a filter that stays in its place receives without a gap. Only for a protocol that
    /// [changes its filters](super::Protocol::CHANGES_FILTERS), and a controller that [is at](Controller::is_at) the bit rate.
    fn refilter(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) {
        let _ = filters;
    }

    /// Performs or begins an action, except [`Action::Save`] and [`Action::Restart`]. The phase is [`Phase::Off`] at
    /// [`Action::Bus`].
    fn perform(&mut self, action: Action);

    /// Begins a save of the record that `image` writes into its argument, and of which it returns the length. [`Driver::stored`]
    /// must report its end: until then, the node waits for it.
    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>);

    /// Restarts the device as after power-up. Pass `kept` to the next start in [`Boot::kept`](super::Boot::kept), in memory that is
    /// not cleared. Outputs are off.
    fn restart(&mut self, kept: u32);
}

/// A restart of the device.
enum Restart {
    No,
    /// It waits for the end of a save.
    Requested,
    /// It waits for the end of the transmission, until this time at the latest.
    Until(Instant),
}

/// A node with the order in which it is driven: see the [module](self).
pub struct Driver<S> {
    side: S,
    restart: Restart,
    is_saving: bool,
}

impl<S: Side> Driver<S> {
    /// A driver of a node that is started, and not on the bus.
    pub fn new(side: S) -> Self {
        Self {
            side,
            restart: Restart::No,
            is_saving: false,
        }
    }

    /// The node, or its measuring half.
    pub fn side(&self) -> &S {
        &self.side
    }

    /// Handles a received frame.
    pub fn receive(&mut self, frame: &Frame) {
        self.side.link(|link| link.receive(frame));
    }

    /// A mailbox has become free: see [`Link::transmitted`].
    pub fn transmitted(&mut self, unsent: bool) {
        self.side.link(|link| link.transmitted(unsent));
    }

    /// Handles a reading of the accelerometer: see [`Node::sample`](super::Node::sample).
    pub fn sample(&mut self, reading: &Reading) {
        self.side.sample(reading);
    }

    /// Handles a gap before the next reading: values of the accelerometer or the gyroscope were lost.
    pub fn interrupt(&mut self) {
        self.side.interrupt();
    }

    /// Handles the result of the test that [`Action::SelfTest`] requested.
    pub fn tested(&mut self, result: Working) {
        self.side.tested(result);
    }

    /// Handles a measurement of the supply voltage in mV: see [`Node::supply`](super::Node::supply).
    pub fn supply(&mut self, millivolts: u16) {
        self.side.supply(millivolts);
    }

    /// Handles the end of a save.
    pub fn stored(&mut self, result: Result<(), StoreError>) {
        self.is_saving = false;
        self.side.stored(result);
    }

    /// Performs what is due: passes the events of the controller and the frames that waited to the node, performs the actions of the node,
    /// and sends its frames. Call it after each input and at the deadline. Returns true if there can be more to do at once.
    pub fn turn(&mut self, platform: &mut impl Platform) -> bool {
        self.step(platform);
        let has_measured = self.pass_events(platform);
        for _ in 0..ROUNDS {
            match self.side.round() {
                Round::Idle => {
                    self.leave(platform);
                    return has_measured;
                }
                Round::Again => {}
                Round::Perform(action) => self.perform(platform, action),
            }
        }
        true
    }

    /// Passes the events of the controller to the node, up to a measured bit time. It can end the bit rate, and a later error would
    /// count at the new one. Returns true if there can be more events.
    fn pass_events(&mut self, platform: &mut impl Platform) -> bool {
        while let Some(event) = platform.event() {
            self.side.link(|link| link.bus(event));
            self.side.settle();
            if matches!(event, BusEvent::BitTime(_)) {
                return true;
            }
        }
        false
    }

    /// The latest time for the next [turn](Self::turn); None: no turn is necessary before the next input.
    pub fn deadline(&self) -> Option<Instant> {
        let deadline = self.side.deadline();
        match self.restart {
            Restart::Until(limit) => earlier(deadline, Some(limit)),
            _ => deadline,
        }
    }

    /// Performs a step of a change of the bus mode.
    fn step(&mut self, platform: &mut impl Platform) {
        let side = &mut self.side;
        if platform.step(|accept| side.link(|link| link.node.filters(accept))) {
            // Handles the frames that waited for the change.
            side.settle();
        }
    }

    fn perform(&mut self, platform: &mut impl Platform, action: Action) {
        let side = &mut self.side;
        match action {
            Action::Bus(..) if side.link(|link| link.is_held()) => {
                platform.refilter(|accept| side.link(|link| link.node.filters(accept)));
                side.settle();
            }
            Action::Bus(..) => {
                platform.perform(action);
                // Without delay, so that the controller can join the bus at the end of the current frame.
                self.step(platform);
            }
            Action::Save => {
                self.is_saving = true;
                platform.save(|buffer| side.image(buffer));
            }
            Action::Restart => self.restart = Restart::Requested,
            _ => platform.perform(action),
        }
    }

    /// Restarts the device if a restart is requested and the last frame is sent.
    fn leave(&mut self, platform: &mut impl Platform) {
        let limit = match self.restart {
            Restart::No => return,
            Restart::Requested if self.is_saving => return,
            Restart::Requested => after(self.side.now(), RESTART_LIMIT),
            Restart::Until(limit) => limit,
        };
        self.restart = Restart::Until(limit);
        let now = self.side.now();
        // If all mailboxes are empty now, the node has no more frames.
        if self.side.link(|link| link.is_idle()) || reached(now, limit) {
            self.restart = Restart::No;
            platform.restart(self.side.kept());
        }
    }
}
