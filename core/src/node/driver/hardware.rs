//! What a driver implements: the mailboxes and the rest of the CAN controller, and the rest of the hardware.

#[cfg(doc)]
use super::super::Action;
use super::super::{BusEvent, BusMode, Leds};
#[cfg(doc)]
use super::{Driver, Link, Shared};
use crate::can::{BitRate, Filter, Frame};
use crate::store::{StoreError, Usage};
use crate::time::Instant;
use crate::update::Contact;

/// The clock, and the transmit mailboxes of a CAN controller. On a driver with two priorities, the methods are called in the interrupts
/// and in [`Shared::with`].
pub trait Mailboxes {
    /// The time of the call, from the clock of the driver.
    fn now(&self) -> Instant;

    /// Whether all mailboxes are empty.
    fn is_idle(&self) -> bool;

    /// Whether a frame can be put into a mailbox. The default uses one mailbox. Use at most two: the second frame follows the first without
    /// a gap, and a newer cyclic value replaces one that does not wait in a mailbox yet.
    fn has_room(&self) -> bool {
        self.is_idle()
    }

    /// Puts a frame into a mailbox. The controller sends them in the order of the calls. If `once`, it does not repeat the frame
    /// after a bit error ([`Link::transmitted`] reports it). After a lost arbitration or without acknowledge it sends the frame
    /// again at once. Only a product whose [protocol](super::super::Protocol::sends_once) detects a second node with its address has such frames.
    fn put(&mut self, frame: &Frame, once: bool);

    /// Aborts the frames in the mailboxes. A frame on the bus is not aborted if its transmission succeeds.
    fn abort(&mut self);
}

/// The progress of a change of the mode.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[must_use]
pub enum Change {
    /// The controller leaves the bus: received frames belong to the previous mode, and are discarded.
    Leaving,
    /// The controller has left the bus and waits for 11 recessive bits: received frames wait.
    Joining,
    /// The controller is on the bus. This is also the state without a change.
    Done,
}

/// The rest of a CAN controller, used by the main loop: its mode, its filters and its events.
pub trait Controller {
    /// Changes to this mode and bit rate, or begins the change: see [`Action::Bus`]. The frames in the mailboxes are aborted already.
    /// [`change`](Self::change) follows at once.
    fn open(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>);

    /// Performs a step of a running change of the mode, or of a [recovery](Self::recover) that leaves the bus. It is called in each
    /// [turn](Driver::turn). The default is for a controller that performs the whole change in [`open`](Self::open).
    fn change(&mut self) -> Change {
        Change::Done
    }

    /// Sets these filters at the mode and bit rate in force. The controller stays on the bus, and a filter that stays in its place
    /// receives without a gap. Returns false, the default, if that is not possible: then [`open`](Self::open) follows. Only a protocol
    /// that [changes its filters](super::super::Protocol::CHANGES_FILTERS) uses it.
    fn refilter(&mut self, filters: Filters<'_>) -> bool {
        let _ = filters;
        false
    }

    /// Leaves bus-off: starts the recovery sequence of 128 times 11 recessive bits.
    fn recover(&mut self);

    /// The next event, except [`BusEvent::Unsent`]; None if there is no more. Each event is returned once, and each change of the fault
    /// confinement state is one. A turn calls it until it returns None.
    fn event(&mut self) -> Option<BusEvent>;
}

/// Takes a filter.
pub(super) type Accept<'a> = dyn FnMut(Filter) + 'a;

/// The acceptance filters of a node in force.
#[derive(Clone, Copy)]
pub struct Filters<'a>(&'a dyn Fn(&mut Accept<'_>));

impl<'a> Filters<'a> {
    pub(super) fn new(filters: &'a dyn Fn(&mut Accept<'_>)) -> Self {
        Self(filters)
    }

    /// Calls `accept` for each filter.
    pub fn for_each(self, mut accept: impl FnMut(Filter)) {
        (self.0)(&mut accept);
    }
}

/// What the node requests from the rest of the hardware.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Output {
    /// [`Action::Leds`].
    Leds(Leds),
    /// [`Action::Termination`].
    Termination(bool),
    /// [`Action::Heater`].
    Heater(u16),
    /// [`Action::SelfTest`]: [`Driver::tested`] reports its result.
    SelfTest,
}

/// The hardware around a node, except the CAN controller: LEDs, store, outputs.
pub trait Platform {
    /// Whether the board has a bootloader. Its driver starts the node with [`Boot::program`](super::super::Boot::program), and implements
    /// [`update`](Self::update).
    const HAS_BOOTLOADER: bool = false;

    /// Sets an output, or begins a self-test.
    fn perform(&mut self, output: Output);

    /// Begins a save of the record that `image` writes into its argument, and of which it returns the length:
    /// [`Store::save`](crate::store::Store::save).
    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>);

    /// Performs a step of the save ([`Store::step`](crate::store::Store::step)). Returns the result when it has ended, at once an error
    /// if there is no memory. It is called in each [turn](Driver::turn) until then.
    fn stored(&mut self) -> Option<Result<(), StoreError>>;

    /// Begins to store the usage: [`Store::keep`](crate::store::Store::keep). `hour` is the number of full hours since
    /// the start. Returns whether a save has begun, whose steps [`stored`](Self::stored) performs. The default is for a board without memory.
    fn keep(&mut self, usage: &Usage, hour: u32) -> bool {
        let _ = (usage, hour);
        false
    }

    /// Restarts the device as after power-up. Pass `kept` to the next start in [`Boot::kept`](super::super::Boot::kept), in memory that is
    /// not cleared. Outputs are off.
    fn restart(&mut self, kept: u32);

    /// The [restart](Self::restart) that follows is that into the bootloader: leave these contact data for it, in memory that is not cleared.
    fn update(&mut self, contact: &Contact) {
        let _ = contact;
    }
}
