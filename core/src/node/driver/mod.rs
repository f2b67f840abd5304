//! The order in which a driver drives a node. The boards, the simulated sensors and the examples use this code.
//!
//! A driver implements three traits and calls a [`Driver`]:
//!
//! ```text
//!   receive interrupt  --> Link::receive ----+        +--> Mailboxes::put, abort, is_idle, now
//!   transmit interrupt --> Link::transmitted-+-> node-+
//!   main loop          --> Driver::sample ---+        +--> Controller::open, recover, event
//!                          Driver::turn -----+        +--> Platform::perform, save, stored, restart
//! ```
//!
//! A driver of any product has one bound, [`ProductNode`](super::ProductNode): it starts the node, and has the owner of its store, its
//! sizes and its two halves.
//!
//! # With one thread
//!
//! A [`Driver`] of [`OneThread`] has a [`Node`](super::Node) and its CAN controller, which implements [`Mailboxes`] and [`Controller`]. In
//! a loop:
//!
//! 1. Pass each received frame to [`Driver::receive`], each frame that was sent to [`Driver::transmitted`], and every
//!    [`SAMPLE_PERIOD`](crate::measure::SAMPLE_PERIOD) a reading to [`Driver::sample`].
//! 2. Call [`Driver::turn`], again with step 1 while it returns true. It changes the mode of the controller, and requests saves and outputs
//!    from the [`Platform`].
//! 3. Wait until the next input, at the latest until [`Driver::deadline`].
//!
//! This is the example `driver_one_thread`. A real controller also needs a filter for each of [`Filters`], or must pass all frames: the
//! node ignores those that do not pass.
//!
#![doc = "```"]
#![doc = include_str!("../../../examples/driver_one_thread.rs")]
#![doc = "```"]
//!
//! The example `driver_mcp2515` is a driver for a controller on SPI, with its registers.
//!
//! # With two priorities
//!
//! The readings take long, and a frame must not wait for their calculation. So the interrupts of the CAN controller use the
//! [`Link`]: the communicating half of the node with its [`Mailboxes`]. The main loop has a [`Driver`] of [`TwoPriorities`] with the
//! measuring half and the [`Controller`]. The driver implements [`Shared`]: the link in memory that both use, for example in a `Mutex` of
//! the crate `critical-section`. No use of the link is longer than a few microseconds.
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
//! | a self-test has ended | [`Driver::tested`] | the loop |
//! | after each of these, and at [`Driver::deadline`] | [`Driver::turn`] while it returns true | the loop |
//! | each millisecond during a change of the mode ([`Change`]) | [`Driver::turn`] | the loop |
//! | without a pause while the store is [busy](crate::store::Store::busy) | [`Driver::turn`] | the loop |
//!
//! - **Start**: open the [store](super::StoreOf) of the [owner](super::ProductNode::owner), let it
//!   [erase in advance](crate::store::Store::prepare), start the node with its [`boot`](crate::store::Store::boot), then call
//!   [`Driver::turn`]. The controller is off the bus until the first [`Controller::open`]. Readings begin within 89 ms: without one, the node
//!   reports a sensor error.
//! - **Waiting**: no method of [`Mailboxes`] and no use of the link waits. With one thread, each wait in the loop delays the answers. With
//!   two priorities, the loop may wait between two readings, for example for a sector of the flash.
//! - **Change of the mode** ([`Controller::open`]): discard the received frames and errors, and set bit timing and filters. Then the
//!   controller joins the bus after 11 recessive bits. If the bus stays dominant, the change does not end, and the node can request another
//!   one. A controller that needs time for it returns [`Change::Leaving`], then [`Change::Joining`] from [`Controller::change`]. One that can
//!   wait for the end of the frame on the bus, at most 16 ms, performs it in `open`.
//! - **Bus-off**: [`Controller::event`] returns each change of the fault confinement state once. The controller does not leave bus-off
//!   before [`Controller::recover`]. Then it reports [`BusState::Active`](super::BusState::Active).
//! - **Save**: [`Platform::save`] begins it ([`Store::save`](crate::store::Store::save)), and [`Platform::stored`] performs a
//!   [step](crate::store::Store::step). A board without memory returns an error.
//! - **Power cut**: the store has the earlier record until the new one is complete, so a driver does nothing. If the supply is too low
//!   to program the memory, report the save as failed.
//! - **Restart**: [`Platform::restart`] comes after the last frame. Switch off the heater, keep the word, and reset the chip. Pass the word to
//!   the next start ([`Boot::kept`](super::Boot::kept)), but 0 after power-up. If `restart` returns, the driver starts the node again, with
//!   a new [`Driver`].
//! - **Update**: on a board with a [bootloader](crate::update), tell the node ([`Boot::program`](super::Boot::program)), and leave the contact
//!   data of [`Platform::update`] for the bootloader. On another board, the node refuses requests for an update.
//! - **Watchdog**: feed it once in each iteration of the loop. A turn performs at most eight actions.
//!
//! # What the compiler finds
//!
//! | mistake | message |
//! |---|---|
//! | no [`Controller::recover`], [`Controller::event`], [`Platform::stored`] or [`Platform::restart`] | E0046: not all trait items are implemented |
//! | a save without a result: [`Platform::stored`] ends without one | E0308: the types do not match |
//! | an [`Output`] without a branch | E0004: the patterns are not exhaustive |
//! | the result of [`Driver::turn`] or [`Node::poll`](super::Node::poll), a [`BusEvent`] or a [`Change`] that is not used | `unused_must_use` |
//! | interrupts and main loop with different nodes | E0271 at [`TwoPriorities::new`]: the types do not match |
//! | a link that threads share without a lock | E0277: it is not `Sync` |
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

mod hardware;
mod line;
mod order;
mod sides;
mod watch;

pub use hardware::{Change, Controller, Filters, Mailboxes, Output, Platform};
pub use line::{Exchange, Line, Link};
pub(super) use order::Reach;
pub use order::Round;
pub use sides::{LinkOf, OneThread, Shared, Side, TwoPriorities};

use super::{Action, BusEvent, BusMode};
use crate::can::{BitRate, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::time::{Duration, Instant, after, earlier, millis, reached};
use watch::Watch;

/// The maximum number of actions in one [`Driver::turn`]. The limit ensures that a watchdog is fed even if each frame causes an action.
const ROUNDS: u8 = 8;

/// The longest time that a restart waits for the last frames: four frames, one of them waiting for a mailbox, of 16 ms each at 10
/// kbit/s.
const RESTART_LIMIT: Duration = millis(100);

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
    /// The usage is being kept.
    is_keeping: bool,
    /// A change of the mode is running.
    is_changing: bool,
    watch: Watch,
}

impl<S: Side> Driver<S> {
    /// A driver of a node that is started, and not on the bus.
    pub fn new(side: S) -> Self {
        Self {
            side,
            restart: Restart::No,
            is_saving: false,
            is_keeping: false,
            is_changing: false,
            watch: Watch::START,
        }
    }

    /// The node, or its measuring half.
    pub fn side(&self) -> &S {
        &self.side
    }

    /// The CAN controller.
    pub fn controller(&self) -> &S::Controller {
        self.side.controller()
    }

    /// The CAN controller, for example to take the received frames from it.
    pub fn controller_mut(&mut self) -> &mut S::Controller {
        self.side.controller_mut()
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
        if S::Exchange::HAS_DIAGNOSIS {
            self.watch.note(reading);
        }
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

    /// Performs what is due: passes the events of the controller and the frames that waited to the node, performs the actions of the node,
    /// and sends its frames. Call it after each input and at the deadline. Returns true if there can be more to do at once.
    #[must_use]
    pub fn turn(&mut self, platform: &mut impl Platform) -> bool {
        self.change();
        let has_measured = self.pass_events();
        let works = self.work(platform);
        if S::Exchange::HAS_DIAGNOSIS && self.watch.is_due() {
            self.keep(platform);
        }
        has_measured | works | self.store(platform)
    }

    /// Adds the readings of the last second to the usage, and begins to store it when it is due. A save has priority.
    #[cold]
    #[inline(never)]
    fn keep(&mut self, platform: &mut impl Platform) {
        let watch = &mut self.watch;
        let result = self.side.link(|link| link.watch(|usage| watch.take(usage)));
        let Some((usage, due)) = result else {
            self.watch = Watch::START;
            return;
        };
        if let Some(hour) = due
            && !self.is_saving
            && !self.is_keeping
        {
            self.watch.done();
            self.is_keeping = platform.keep(&usage, hour);
        }
    }

    /// Performs the work that is due. Returns true if there can be more.
    fn work(&mut self, platform: &mut impl Platform) -> bool {
        for _ in 0..ROUNDS {
            match self.side.round() {
                Round::Idle => {
                    self.leave(platform);
                    return false;
                }
                Round::Again => {}
                Round::Perform(action) => self.perform(platform, action),
            }
        }
        true
    }

    /// Performs a step of a save. Returns true if it has ended with it.
    fn store(&mut self, platform: &mut impl Platform) -> bool {
        let is_running = self.is_saving || S::Exchange::HAS_DIAGNOSIS && self.is_keeping;
        let Some(result) = is_running.then(|| platform.stored()).flatten() else {
            return false;
        };
        self.is_keeping = false;
        if core::mem::take(&mut self.is_saving) {
            self.side.stored(result);
        }
        true
    }

    /// Passes the events of the controller to the node, up to a measured bit time. It can end the bit rate, and a later error would
    /// count at the new one. Returns true if there can be more events.
    fn pass_events(&mut self) -> bool {
        while let Some(event) = self.side.controller_mut().event() {
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

    /// Follows a change of the mode. The controller can also begin one itself.
    fn change(&mut self) {
        let change = self.side.controller_mut().change();
        if !self.is_changing && change == Change::Done {
            return;
        }
        self.is_changing = change != Change::Done;
        self.side.link(|link| link.follow(change));
        if change == Change::Done {
            // Handles the frames that waited for the change.
            self.side.settle();
        }
    }

    fn perform(&mut self, platform: &mut impl Platform, action: Action) {
        match action {
            Action::Bus(mode, rate) => self.open(mode, rate),
            Action::Recover => {
                self.side.controller_mut().recover();
                self.change();
            }
            Action::Save => {
                self.is_saving = true;
                // The save of the usage is aborted.
                self.is_keeping = false;
                let side = &mut self.side;
                platform.save(|buffer| side.image(buffer));
            }
            Action::Restart => self.restart = Restart::Requested,
            Action::Leds(leds) => platform.perform(Output::Leds(leds)),
            Action::Termination(on) => platform.perform(Output::Termination(on)),
            Action::Heater(permille) => platform.perform(Output::Heater(permille)),
            Action::SelfTest => platform.perform(Output::SelfTest),
        }
    }

    /// Changes the mode, or only the filters. The link is paused already.
    fn open(&mut self, mode: BusMode, rate: BitRate) {
        self.is_changing = true;
        let side = &mut self.side;
        if side.link(|link| link.is_held()) {
            if side.filter(|controller, filters| controller.refilter(filters)) {
                return self.change();
            }
            side.link(|link| link.discard());
        }
        side.filter(|controller, filters| controller.open(mode, rate, filters));
        // Without delay, so that the controller can join the bus at the end of the current frame.
        self.change();
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
            tell_bootloader(&mut self.side, platform);
            platform.restart(self.side.kept());
        }
    }
}

/// Leaves the contact data for the bootloader, if the restart is that into it.
#[cold]
#[inline(never)]
fn tell_bootloader<S: Side, P: Platform>(side: &mut S, platform: &mut P) {
    if P::HAS_BOOTLOADER
        && let Some(contact) = side.link(|link| link.contact())
    {
        platform.update(&contact);
    }
}
