//! The two users of the order: a driver with one thread, and one with two priorities.

use super::super::{AcquisitionOf, Action, CommunicationOf, Node, ProductNode};
use super::hardware::Accept;
use super::{Controller, Exchange, Filters, Line, Link, Mailboxes, Reach, Round};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::store::StoreError;
use crate::time::Instant;
use core::ops::DerefMut;

/// What a [`Driver`](super::Driver) drives: a node on [one thread](OneThread), or the measuring half of a node at the lower of
/// [two priorities](TwoPriorities). A driver only calls [`Driver`](super::Driver).
pub trait Side {
    /// The half of the node that handles the frames.
    type Exchange: Exchange + ?Sized;
    /// The transmit mailboxes of the CAN controller.
    type Mailboxes: Mailboxes;
    /// The rest of the CAN controller.
    type Controller: Controller;

    /// Calls a function with the link. With two priorities, no interrupt uses the link meanwhile.
    fn link<R>(&mut self, f: impl FnOnce(&mut Link<'_, Self::Exchange, Self::Mailboxes>) -> R)
    -> R;

    /// The CAN controller.
    fn controller(&self) -> &Self::Controller;

    /// The CAN controller.
    fn controller_mut(&mut self) -> &mut Self::Controller;

    /// Calls a function with the CAN controller and the filters in force.
    fn filter<R>(&mut self, f: impl FnOnce(&mut Self::Controller, Filters<'_>) -> R) -> R;

    /// The time of the call, from the clock of the driver.
    fn now(&self) -> Instant;

    /// Handles the frames that waited for the node, and sends its frames.
    fn settle(&mut self) {
        while self.link(|link| link.settle()) {}
    }

    /// Performs the work that is due, up to the next action.
    fn round(&mut self) -> Round;

    /// Handles a reading of the accelerometer, with the parameters of all earlier frames.
    fn sample(&mut self, reading: &Reading);

    /// Handles a gap before the next reading.
    fn interrupt(&mut self);

    /// Handles the result of the self-test.
    fn tested(&mut self, result: Working);

    /// Handles a measurement of the supply voltage.
    fn supply(&mut self, millivolts: u16);

    /// Handles the end of a save.
    fn stored(&mut self, result: Result<(), StoreError>);

    /// Writes the parameters to save into `buffer`. Returns their length.
    fn image(&mut self, buffer: &mut [u8]) -> Option<usize>;

    /// The state to keep over a restart.
    fn kept(&self) -> u32;

    /// The latest time for the next round.
    fn deadline(&self) -> Option<Instant>;
}

/// A node on one thread, with its controller. `B` is the owner of the node: `&mut Is2`, `Box<dyn Node>`.
pub struct OneThread<B, C> {
    node: B,
    line: Line<C>,
}

impl<B: DerefMut<Target: Node>, C: Mailboxes + Controller> OneThread<B, C> {
    /// A node that is started, and its controller, which is off the bus.
    pub fn new(node: B, controller: C) -> Self {
        Self {
            node,
            line: Line::new(controller),
        }
    }

    /// The node, for example to read its state.
    pub fn node(&self) -> &B::Target {
        &self.node
    }
}

impl<B: DerefMut<Target: Node>, C: Mailboxes + Controller> Side for OneThread<B, C> {
    type Exchange = B::Target;
    type Mailboxes = C;
    type Controller = C;

    fn link<R>(&mut self, f: impl FnOnce(&mut Link<'_, B::Target, C>) -> R) -> R {
        f(&mut Link::new(&mut *self.node, &mut self.line))
    }

    fn controller(&self) -> &C {
        &self.line.mailboxes
    }

    fn controller_mut(&mut self) -> &mut C {
        &mut self.line.mailboxes
    }

    fn filter<R>(&mut self, f: impl FnOnce(&mut C, Filters<'_>) -> R) -> R {
        let node = &*self.node;
        let filters = |accept: &mut Accept<'_>| Node::filters(node, accept);
        f(&mut self.line.mailboxes, Filters::new(&filters))
    }

    fn now(&self) -> Instant {
        self.line.mailboxes.now()
    }

    fn round(&mut self) -> Round {
        self.settle();
        let now = self.now();
        let action = self.node.poll(now);
        if let Some(action) = action {
            self.link(|link| link.pause_for(action));
            return Round::Perform(action);
        }
        // The protocol may have waited for room in its queue.
        if self.link(|link| link.settle()) {
            Round::Again
        } else {
            Round::Idle
        }
    }

    fn sample(&mut self, reading: &Reading) {
        let now = self.now();
        self.node.sample(now, reading);
    }

    fn interrupt(&mut self) {
        self.node.interrupt();
    }

    fn tested(&mut self, result: Working) {
        let now = self.now();
        self.node.tested(now, result);
    }

    fn supply(&mut self, millivolts: u16) {
        let now = self.now();
        self.node.supply(now, millivolts);
    }

    fn stored(&mut self, result: Result<(), StoreError>) {
        let now = self.now();
        self.node.stored(now, result);
    }

    fn image(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.node.image(buffer)
    }

    fn kept(&self) -> u32 {
        self.node.kept()
    }

    fn deadline(&self) -> Option<Instant> {
        self.node.deadline()
    }
}

/// The [`Link`] of a node in memory that the interrupts and the main loop share.
pub trait Shared {
    /// The node.
    type Node: ProductNode;
    /// The transmit mailboxes of the CAN controller.
    type Mailboxes: Mailboxes;

    /// Uses the link. Meanwhile no interrupt uses it. Calls are short and not nested.
    fn with<R>(&self, f: impl FnOnce(&mut LinkOf<'_, Self::Node, Self::Mailboxes>) -> R) -> R;

    /// The time of the call, from the clock of the driver. A driver that can read its clock without the link does so here.
    fn now(&self) -> Instant {
        self.with(|link| link.now())
    }
}

/// The link of node `N` with mailboxes `M`.
pub type LinkOf<'a, N, M> = Link<'a, CommunicationOf<N>, M>;

type NodeOf<S> = <S as Shared>::Node;
type ApplicationOf<S> = <NodeOf<S> as ProductNode>::Application;
type ProtocolOf<S> = <NodeOf<S> as ProductNode>::Protocol;

/// The measuring half of a node in a main loop, with the CAN controller except its mailboxes. The interrupts use the communicating half.
pub struct TwoPriorities<'a, S: Shared, C> {
    acquisition: &'a mut AcquisitionOf<S::Node>,
    shared: S,
    controller: C,
}

impl<'a, S: Shared, C: Controller> TwoPriorities<'a, S, C> {
    /// The measuring half of a node that is started. `shared` has the communicating half.
    pub fn new(acquisition: &'a mut AcquisitionOf<S::Node>, shared: S, controller: C) -> Self {
        Self {
            acquisition,
            shared,
            controller,
        }
    }
}

/// The way to the communicating half through the link.
struct Through<'s, S>(&'s S);

impl<S: Shared> Reach<ApplicationOf<S>, ProtocolOf<S>> for Through<'_, S> {
    fn now(&self) -> Instant {
        self.0.now()
    }

    fn with<R>(&mut self, f: impl FnOnce(&mut CommunicationOf<S::Node>) -> R) -> R {
        self.0.with(|link| f(link.node))
    }

    fn call<R>(&mut self, f: impl FnOnce(&mut CommunicationOf<S::Node>, Instant) -> R) -> R {
        let result = self.0.with(|link| {
            let now = link.now();
            f(link.node, now)
        });
        self.settle();
        result
    }

    fn settle(&mut self) {
        while self.0.with(|link| link.settle()) {}
    }

    fn action(&mut self, now: Instant) -> Option<Action> {
        self.0.with(|link| {
            let action = link.node.action(now);
            if let Some(action) = action {
                link.pause_for(action);
            }
            action
        })
    }
}

impl<S: Shared, C: Controller> Side for TwoPriorities<'_, S, C> {
    type Exchange = CommunicationOf<S::Node>;
    type Mailboxes = S::Mailboxes;
    type Controller = C;

    fn link<R>(&mut self, f: impl FnOnce(&mut LinkOf<'_, S::Node, S::Mailboxes>) -> R) -> R {
        self.shared.with(f)
    }

    fn controller(&self) -> &C {
        &self.controller
    }

    fn controller_mut(&mut self) -> &mut C {
        &mut self.controller
    }

    fn filter<R>(&mut self, f: impl FnOnce(&mut C, Filters<'_>) -> R) -> R {
        let shared = &self.shared;
        let filters = |accept: &mut Accept<'_>| {
            shared.with(|link| link.node.filters(accept));
        };
        f(&mut self.controller, Filters::new(&filters))
    }

    fn now(&self) -> Instant {
        self.shared.now()
    }

    fn round(&mut self) -> Round {
        self.acquisition.round(&mut Through(&self.shared))
    }

    fn sample(&mut self, reading: &Reading) {
        self.acquisition
            .measure(&mut Through(&self.shared), reading);
    }

    fn interrupt(&mut self) {
        self.acquisition.interrupt();
    }

    fn tested(&mut self, result: Working) {
        let values = self.acquisition.tested(result);
        self.acquisition.publish(&mut Through(&self.shared), values);
    }

    fn supply(&mut self, millivolts: u16) {
        let values = self.acquisition.supply(millivolts);
        self.acquisition.publish(&mut Through(&self.shared), values);
    }

    fn stored(&mut self, result: Result<(), StoreError>) {
        self.acquisition.stored(&mut Through(&self.shared), result);
    }

    fn image(&mut self, buffer: &mut [u8]) -> Option<usize> {
        // Copied, because encoding takes long.
        let parameters = self.shared.with(|link| *link.node.image());
        parameters.encode(buffer)
    }

    fn kept(&self) -> u32 {
        self.acquisition.kept()
    }

    fn deadline(&self) -> Option<Instant> {
        let communication = self.shared.with(|link| link.node.deadline());
        self.acquisition.earliest(communication).time()
    }
}
