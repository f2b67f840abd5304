//! The [`Protocol`] trait, and the part of a node that a protocol can access.

use super::Shell;
use super::shell::cause;
use crate::application::{Application, Effect};
use crate::can::{Filter, Frame};
use crate::diagnosis::Diagnosis;
use crate::param::{ParameterId, Parameters, Refused, Table};
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant};
use crate::update::Contact;

/// The part of a node that its protocol can access.
pub struct Context<A: Application> {
    /// The protocol-neutral half of the node.
    pub shell: Shell,
    /// The parameters in RAM: those in force.
    pub parameters: Parameters<A::Table>,
    /// The last values of the application.
    pub values: A::Values,
    /// The parameters that the running save writes.
    pub(super) saving: Option<Parameters<A::Table>>,
    /// The diagnostic data. Not used if the product [has none](Application::HAS_DIAGNOSIS).
    pub(super) diagnosis: Diagnosis,
}

impl<A: Application> Context<A> {
    /// Requests that the application applies the parameters before the next frame or reading.
    pub fn apply(&mut self) {
        self.shell.block(cause::PARAMETERS, true);
        self.shell.wake_up();
    }

    /// Writes a parameter as the application does. If the value is not permitted, or contradicts another parameter, nothing
    /// changes.
    pub fn write(&mut self, id: ParameterId, value: u32) -> Result<Effect, Refused> {
        Parameters::<A::Table>::check(id, value)?;
        if const { A::Table::CONSTRAINTS.is_empty() } {
            return A::write(id, value, &self.values, &mut self.parameters);
        }
        let before = self.parameters;
        let written = A::write(id, value, &self.values, &mut self.parameters);
        if written.is_ok() && !self.parameters.is_consistent() {
            self.parameters = before;
            return Err(Refused::NotPermitted);
        }
        written
    }

    /// Whether a write would change a parameter.
    pub fn would_change(&self, id: ParameterId, value: u32) -> Result<bool, Refused> {
        Parameters::<A::Table>::check(id, value)?;
        let mut parameters = self.parameters;
        A::write(id, value, &self.values, &mut parameters)?;
        Ok(parameters != self.parameters)
    }

    /// Begins a save of these parameters. [`Protocol::stored`] is called when it has ended.
    pub fn save(&mut self, parameters: Parameters<A::Table>) {
        self.saving = Some(parameters);
        self.shell.begin_save();
    }

    /// The parameters that the running save writes.
    pub fn saving(&self) -> Option<&Parameters<A::Table>> {
        self.saving.as_ref()
    }

    /// The diagnostic data.
    pub fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }

    /// Whether a save is running.
    pub fn is_saving(&self) -> bool {
        self.saving.is_some()
    }
}

/// A change of the bus state of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BusChange {
    /// The bit rate is detected: the node is on the bus.
    Online,
    /// The fault confinement state has changed.
    State,
    /// The node has left bus-off.
    Recovered,
    /// The driver or the controller has lost received frames.
    Overrun,
    /// A frame that is [sent once](Protocol::sends_once) was not sent.
    Unsent,
}

/// A protocol on top of the [`Shell`].
///
/// The node calls [`start`](Self::start) with the first reading, or when it has not come in time. Until then it calls only
/// [`detects`](Self::detects), [`recovers`](Self::recovers), [`filters`](Self::filters) and [`deadlines`](Self::deadlines). It calls
/// [`receive`](Self::receive) only while it is on the bus.
pub trait Protocol<A: Application>: Sized + Send + 'static {
    /// A protocol that is not started. If all its bits are 0, it needs no flash: a node is in static memory.
    const INITIAL: Self;
    /// The maximum number of queued frames that are not replies: cyclic values of different identifiers, and one event.
    const FRAMES: usize;
    /// The number of acceptance filters.
    const FILTERS: usize;
    /// Whether it can [detect](Self::detects) the bit rate.
    const DETECTS: bool = false;

    /// Whether it [defers](Shell::defer) requests during a save.
    const DEFERS: bool = false;

    /// Whether it is told when its frames are [sent](Self::sent).
    const USES_SENT: bool = false;

    /// Whether its filters change on the bus, with [`go_online`](Shell::go_online) at the same bit rate. If so, that change loses no
    /// received frame ([`Node::changes_filters`](super::Node::changes_filters)).
    const CHANGES_FILTERS: bool = false;

    /// Whether it detects the bit rate: the node listens from power-up, and goes online itself when it has found the bit rate
    /// ([`BusChange::Online`]).
    fn detects(&self, parameters: &Parameters<A::Table>) -> bool {
        let _ = parameters;
        false
    }

    /// The address of the node, or its identifiers as one number; None while it has no address. It only changes to another one together with
    /// the [filters](Self::filters), so a driver finds a change by a disturbance.
    fn address(&self) -> Option<u32>;

    /// Starts with the first published values: [goes online](Shell::go_online), unless it detects the bit rate.
    fn start(&mut self, cx: &mut Context<A>, now: Instant);

    /// Handles a received frame. A request that must wait for a running save is [deferred](Shell::defer).
    fn receive(&mut self, cx: &mut Context<A>, now: Instant, frame: &Frame);

    /// The application has published new values.
    fn published(&mut self, cx: &mut Context<A>, now: Instant);

    /// The bus state of the node has changed.
    fn bus_changed(&mut self, cx: &mut Context<A>, now: Instant, change: BusChange);

    /// Whether the node leaves bus-off automatically.
    fn recovers(&self, parameters: &Parameters<A::Table>) -> bool;

    /// The save of these parameters has ended.
    fn stored(
        &mut self,
        cx: &mut Context<A>,
        now: Instant,
        saved: &Parameters<A::Table>,
        result: Result<(), StoreError>,
    );

    /// All queued frames have been sent, and acknowledged by another node.
    fn sent(&mut self, cx: &mut Context<A>, now: Instant) {
        let _ = (cx, now);
    }

    /// Whether the controller must not repeat the next frame after a bit error. Only a protocol that is told when its frames are
    /// [sent](Self::sent) can have such frames.
    fn sends_once(&self) -> bool {
        false
    }

    /// Performs a step of the actions of expired timers. Returns true if there is another step; steps count from 0. A step
    /// normally builds at most one frame.
    fn tick(&mut self, cx: &mut Context<A>, now: Instant, step: u8) -> bool;

    /// Continues the answer to a received frame that consists of several frames. Returns false if it is complete.
    fn proceed(&mut self, cx: &mut Context<A>) -> bool {
        let _ = cx;
        false
    }

    /// Whether the protocol waits for room in the transmit queue. If so, [`tick`](Self::tick) is called after each transmitted
    /// frame.
    fn waits_for_room(&self) -> bool {
        false
    }

    /// Adds the deadlines of the protocol.
    fn deadlines(&self, earliest: &mut Deadline);

    /// What the bootloader must know, when the protocol has requested an update ([`Shell::enter_bootloader`]); None: it has none.
    fn contact(&self, cx: &Context<A>) -> Option<Contact> {
        let _ = cx;
        None
    }

    /// Calls `accept` for each acceptance filter in force.
    fn filters(&self, cx: &Context<A>, accept: &mut dyn FnMut(Filter));
}

/// A protocol that starts with the stored parameters alone. Its node has [`CanNode::new`](super::CanNode::new) and
/// [`CanNode::start`](super::CanNode::start).
pub trait Restore: Protocol<<Self as Restore>::Application> {
    /// The application of its product.
    type Application: Application;
    /// The identification of the stored images of its product.
    const IMAGE: ImageId;

    /// Takes the stored parameters. `damaged`: the stored record is damaged or not usable, so they have their factory values.
    fn restored(
        &mut self,
        parameters: &mut Parameters<<Self::Application as Application>::Table>,
        damaged: bool,
    );
}
