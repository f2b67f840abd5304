//! The order in which the measuring half of a node uses the communicating half.

use super::super::{Acquisition, Action, Communication, Protocol};
use crate::application::Application;
use crate::measure::Reading;
use crate::store::StoreError;
use crate::time::{Deadline, Instant};

/// The way from the measuring half to the communicating half.
pub(in crate::node) trait Reach<A: Application, P: Protocol<A>> {
    /// The time of the call, from the clock of the driver.
    fn now(&self) -> Instant;

    /// Uses the communicating half. No frame is handled at the same time.
    fn with<R>(&mut self, f: impl FnOnce(&mut Communication<A, P>) -> R) -> R;

    /// Calls a method of the communicating half with the present time, then [settles](Self::settle).
    fn call<R>(&mut self, f: impl FnOnce(&mut Communication<A, P>, Instant) -> R) -> R;

    /// Handles the frames that waited for the node, and sends its frames.
    fn settle(&mut self);

    /// The next action of the communicating half. In the same use, pauses the frames for it.
    fn action(&mut self, now: Instant) -> Option<Action>;
}

/// The result of a round of work.
pub enum Round {
    /// There is nothing to do before the next input or the deadline.
    Idle,
    /// There can be more to do.
    Again,
    /// Perform this action. Then there can be more to do.
    Perform(Action),
}

impl<A: Application> Acquisition<A> {
    /// Performs the tasks of the measuring half.
    pub(in crate::node) fn obey<P: Protocol<A>>(&mut self, reach: &mut impl Reach<A, P>) {
        loop {
            let now = reach.now();
            let task = reach.with(|node| node.task(now));
            // Passed by reference, so that the parameters are not copied again.
            let Some(task) = &task else {
                return;
            };
            let values = self.perform(now, task);
            reach.call(|node, now| node.finish(now, task, &values));
        }
    }

    /// Processes a reading with the parameters of all earlier frames. During a restart it is discarded: the outputs are switched off, and stay
    /// off.
    pub(in crate::node) fn measure<P: Protocol<A>>(
        &mut self,
        reach: &mut impl Reach<A, P>,
        reading: &Reading,
    ) {
        self.obey(reach);
        if reach.with(|node| node.is_leaving()) {
            return;
        }
        let now = reach.now();
        let values = self.sample(now, reading);
        reach.with(|node| node.renew(&values));
        reach.with(|node| node.sampled(now));
    }

    /// Publishes values that have changed without a reading.
    pub(in crate::node) fn publish<P: Protocol<A>>(
        &mut self,
        reach: &mut impl Reach<A, P>,
        values: Option<A::Values>,
    ) {
        if let Some(values) = values {
            reach.call(|node, now| node.publish(now, &values));
        }
    }

    /// Handles the end of a save, then the frames that waited for it.
    pub(in crate::node) fn stored<P: Protocol<A>>(
        &mut self,
        reach: &mut impl Reach<A, P>,
        result: Result<(), StoreError>,
    ) {
        reach.call(|node, now| node.stored(now, result));
        loop {
            self.obey(reach);
            if !reach.call(|node, now| node.resume(now)) {
                return;
            }
        }
    }

    /// Performs the work that is due, up to the next action. Each use of the communicating half is short.
    pub(in crate::node) fn round<P: Protocol<A>>(&mut self, reach: &mut impl Reach<A, P>) -> Round {
        let now = reach.now();
        if let Some(leds) = self.indicator.poll(now) {
            return Round::Perform(Action::Leds(leds));
        }
        let values = self.tick(now);
        self.publish(reach, values);
        reach.settle();
        if reach.with(|node| node.is_idle(now)) {
            return Round::Idle;
        }
        loop {
            self.obey(reach);
            if !reach.with(|node| node.tick(now)) {
                break;
            }
        }
        if let Some(patterns) = reach.with(|node| node.patterns()) {
            self.indicator.show(now, patterns);
        }
        match reach.action(now) {
            Some(action) => Round::Perform(action),
            None => Round::Again,
        }
    }

    /// The latest time for the next round, with that of the communicating half.
    pub(in crate::node) fn earliest(&self, communication: Deadline) -> Deadline {
        let mut earliest = communication;
        earliest.consider(self.deadline());
        self.indicator.consider(&mut earliest);
        earliest
    }
}
