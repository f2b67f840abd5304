//! A node: an application, a protocol and the protocol-neutral shell.

use super::{Action, Boot, BusChange, BusEvent, Context, Node, NodeState, Protocol, Shell};
use crate::application::{Application, Readout, Values};
use crate::can::{Filter, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::param::{Parameters, Table};
use crate::store::{ImageId, Owner, StoreError, buffer_size};
use crate::time::{Deadline, Instant};

/// A node that consists of an application and a protocol.
pub struct CanNode<A: Application, P> {
    context: Context<A>,
    application: A,
    protocol: P,
}

impl<A: Application, P: Protocol<A>> CanNode<A, P> {
    /// The size, in bytes, of the buffer of a [`Store`](crate::store::Store) for its parameters.
    pub const STORE_BUFFER: usize = buffer_size(A::Table::STORED_SIZE);
    /// The number of acceptance filters.
    pub const FILTERS: usize = P::FILTERS;
    /// Whether it detects the bit rate.
    pub const DETECTS: bool = P::DETECTS;
    /// Whether it requests self-tests of the accelerometer.
    pub const HAS_SELF_TEST: bool = A::HAS_SELF_TEST;

    /// The owner of the records in its store.
    pub const fn owner(image: ImageId, serial: u32) -> Owner {
        const { assert!(A::Table::LAYOUT >= 1) };
        Owner {
            image,
            layout: A::Table::LAYOUT,
            serial,
        }
    }

    /// A node that is not started, for static memory. All bits are 0, so it needs no flash.
    pub const INITIAL: Self = Self {
        context: Context {
            shell: Shell::INITIAL,
            parameters: Parameters::INITIAL,
            values: A::Values::INITIAL,
            changed: false,
            saving: None,
        },
        application: A::INITIAL,
        protocol: P::INITIAL,
    };

    /// Restores the parameters and the calibration of `boot`. Calls `started` before it applies the parameters; the last argument
    /// of `started` is true if the memory is damaged.
    pub(crate) fn start_with(
        &mut self,
        now: Instant,
        boot: &Boot,
        started: impl FnOnce(&mut A, &mut P, &Parameters<A::Table>, bool),
    ) {
        const {
            assert!(
                P::FRAMES <= super::TransmitQueue::OTHERS,
                "the transmit queue must hold all frames besides replies"
            );
        }
        let Self {
            context,
            application,
            protocol,
        } = self;
        context.shell.start(now, boot.serial, P::FRAMES);
        let damaged = context.restore(boot);
        application.start(boot.calibration);
        started(application, protocol, &context.parameters, damaged);
        context.values = application.apply(now, &context.parameters);
        protocol.published(context, now);
        protocol.start(context, now);
    }

    /// Publishes new values.
    fn publish(&mut self, now: Instant, values: A::Values) {
        self.context.values = values;
        if A::HAS_OUTPUTS && !self.context.shell.has_reported(values.outputs()) {
            self.context.shell.wake_up();
        }
        self.protocol.published(&mut self.context, now);
    }

    /// Applies changed parameters to the application.
    #[inline(always)] // usually there is nothing to apply
    fn obey(&mut self, now: Instant) {
        if self.context.changed {
            self.take_over(now);
        }
    }

    #[inline(never)] // called from three places
    fn take_over(&mut self, now: Instant) {
        self.context.changed = false;
        let values = self.application.apply(now, &self.context.parameters);
        self.publish(now, values);
    }

    /// Passes a frame to the protocol.
    #[inline(always)] // measured: saves ten instructions for each frame
    fn dispatch(&mut self, now: Instant, frame: &Frame) {
        self.obey(now);
        self.protocol.receive(&mut self.context, now, frame);
    }
}

impl<A: Application, P: Protocol<A>> Node for CanNode<A, P> {
    fn ready(&self) -> bool {
        self.context.shell.ready()
    }

    #[inline(never)] // measured and budgeted as a function
    fn receive(&mut self, now: Instant, frame: &Frame) {
        match self.context.shell.state() {
            NodeState::Online => self.dispatch(now, frame),
            // The node does not answer the frame by which it detects the bit rate: it was in listen-only mode.
            NodeState::Detecting(search) if P::DETECTS => {
                self.context.shell.go_online(search.rate());
                let change = BusChange::Online;
                self.protocol.bus_changed(&mut self.context, now, change);
            }
            _ => {}
        }
    }

    #[inline(never)] // measured and budgeted as a function
    fn sample(&mut self, now: Instant, reading: &Reading) {
        if self.context.shell.is_leaving() {
            return;
        }
        self.obey(now);
        self.context.shell.sampled(now);
        let values = self.application.sample(now, reading);
        self.publish(now, values);
    }

    #[inline(never)] // measured and budgeted as a function
    fn bus(&mut self, now: Instant, event: BusEvent) {
        let shell = &mut self.context.shell;
        let change = match event {
            BusEvent::Error => {
                if P::DETECTS {
                    shell.error();
                }
                None
            }
            BusEvent::BitTime(time) => {
                if P::DETECTS {
                    shell.measured(time);
                }
                None
            }
            BusEvent::Overrun => Some(BusChange::Overrun),
            BusEvent::State(state) => {
                let recovers = self.protocol.recovers(&self.context.parameters);
                shell.confine(state, recovers)
            }
        };
        if let Some(change) = change {
            self.protocol.bus_changed(&mut self.context, now, change);
        }
    }

    #[inline(never)] // measured and budgeted as a function
    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        let Some(saved) = self.context.saving.take() else {
            return;
        };
        self.protocol.stored(&mut self.context, now, &saved, result);
        // A deferred frame can begin the next save. Then the other ones continue to wait.
        while P::DEFERS
            && !self.context.is_saving()
            && !self.context.shell.is_leaving()
            && let Some(frame) = self.context.shell.take_deferred()
        {
            self.dispatch(now, &frame);
        }
        self.context.shell.wake_up();
    }

    #[inline(never)] // measured and budgeted as a function
    fn tested(&mut self, now: Instant, result: Working) {
        if A::HAS_SELF_TEST
            && let Some(values) = self.application.tested(result)
        {
            self.publish(now, values);
            self.context.shell.wake_up();
        }
    }

    #[inline(never)] // measured and budgeted as a function
    fn poll(&mut self, now: Instant) -> Option<Action> {
        if self.context.shell.is_idle(now) {
            return None;
        }
        self.obey(now);
        self.tick(now);
        let outputs = A::HAS_OUTPUTS.then(|| self.context.values.outputs());
        let action = self.context.shell.next_action(now, outputs);
        let mut earliest = Deadline::NEVER;
        self.protocol.deadlines(&mut earliest);
        earliest.consider(self.application.deadline());
        self.context.shell.polled(action.is_some(), earliest);
        action
    }

    #[inline(never)] // measured and budgeted as a function
    fn transmit(&mut self, _now: Instant) -> Option<Frame> {
        let frame = self.context.shell.transmit();
        if self.protocol.waits_for_room() {
            self.context.shell.wake_up();
        }
        frame
    }

    fn deadline(&self) -> Option<Instant> {
        self.context.shell.deadline()
    }

    fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        self.protocol.filters(&self.context, accept);
    }

    #[inline(never)] // measured and budgeted as a function
    fn image(&self, buffer: &mut [u8]) -> Option<usize> {
        let parameters = match &self.context.saving {
            Some(saving) => saving,
            None => &self.context.parameters,
        };
        parameters.encode(buffer)
    }

    fn readout(&self) -> Readout {
        A::readout(&self.context.values, &self.context.parameters)
    }
}

impl<A: Application, P: Protocol<A>> CanNode<A, P> {
    /// Performs the actions of expired timers. Called only if the node is not idle.
    fn tick(&mut self, now: Instant) {
        if self.context.shell.becomes_stale(now) {
            let values = self.application.stale();
            self.publish(now, values);
        }
        if self.application.deadline().is_reached(now) {
            let values = self.application.tick(now);
            self.publish(now, values);
        }
        if self.context.shell.stops() {
            // Not published: a stopped application is no fault.
            self.context.values = self.application.stale();
        }
        self.protocol.tick(&mut self.context, now);
    }
}
