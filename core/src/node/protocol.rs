//! What a protocol is to a node: the trait that it implements, and what it sees of the node.

use super::Shell;
use crate::application::Application;
use crate::can::{Filter, Frame};
use crate::param::Parameters;
use crate::store::StoreError;
use crate::time::{Earliest, Instant};

/// What a protocol sees of its node.
pub struct Context<A: Application> {
    /// The protocol-neutral half of the node.
    pub shell: Shell,
    /// The parameters as they are.
    pub parameters: Parameters<A::Table>,
    /// The values that the application has published last.
    pub values: A::Values,
    /// The application has to take parameters over.
    pub(super) changed: bool,
    /// What the running save writes.
    pub(super) saving: Option<Parameters<A::Table>>,
}

impl<A: Application> Context<A> {
    /// Has the application take the parameters over before the next frame, sample or poll.
    pub fn apply(&mut self) {
        self.changed = true;
        self.shell.wake_up();
    }

    /// Begins a save of these parameters. [`Protocol::stored`] tells when it has ended.
    pub fn save(&mut self, parameters: Parameters<A::Table>) {
        self.saving = Some(parameters);
        self.shell.begin_save();
    }

    /// Whether a save is running.
    pub fn is_saving(&self) -> bool {
        self.saving.is_some()
    }
}

/// A change of how the node takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BusChange {
    /// It listens at another bit rate.
    Listening,
    /// The bit rate was detected: it takes part in the bus.
    Online,
    /// The fault confinement state has changed.
    State,
    /// It is no longer bus-off.
    Recovered,
    /// Received frames were lost.
    Overrun,
}

/// A protocol on top of the [`Shell`].
///
/// The node calls [`receive`](Self::receive) only while it is on the bus, and everything else at any time.
pub trait Protocol<A: Application>: Sized {
    /// A protocol that was not started. With all bits 0 it costs no flash: a node lies in static memory.
    const INITIAL: Self;
    /// The most frames that may come besides the replies to requests: cyclic values of different identifiers, and one event.
    const FRAMES: usize;
    /// The number of acceptance filters.
    const FILTERS: usize;
    /// Whether it ever [detects](Shell::detect) the bit rate.
    const DETECTS: bool = false;

    /// Starts after power-up: [detects](Shell::detect) the bit rate or [goes online](Shell::go_online).
    fn start(&mut self, cx: &mut Context<A>, now: Instant);

    /// A frame has come. What must wait for a running save is [deferred](Shell::defer).
    fn receive(&mut self, cx: &mut Context<A>, now: Instant, frame: &Frame);

    /// The application has published new values.
    fn published(&mut self, cx: &mut Context<A>, now: Instant);

    /// Something has changed about the bus.
    fn bus_changed(&mut self, cx: &mut Context<A>, now: Instant, change: BusChange);

    /// Whether the node leaves bus-off by itself.
    fn recovers(&self, parameters: &Parameters<A::Table>) -> bool;

    /// The save of these parameters has ended.
    fn stored(
        &mut self,
        cx: &mut Context<A>,
        now: Instant,
        saved: &Parameters<A::Table>,
        result: Result<(), StoreError>,
    );

    /// Does what the timers want done by now.
    fn tick(&mut self, cx: &mut Context<A>, now: Instant);

    /// Whether something waits for room in the transmit queue; [`tick`](Self::tick) is called when there may be some.
    fn waits_for_room(&self) -> bool {
        false
    }

    /// Takes the protocol's deadlines into account.
    fn deadlines(&self, earliest: &mut Earliest);

    /// Calls `accept` for each acceptance filter in force.
    fn filters(&self, cx: &Context<A>, accept: &mut dyn FnMut(Filter));
}
