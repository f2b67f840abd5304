//! A node: an application, a protocol and the protocol-neutral shell.

use super::driver::{Reach, Round};
use super::shell::cause;
use super::{Acquisition, Action, Boot, BusEvent, Communication, Node, Protocol, Restore};
use crate::application::{Application, Readout};
use crate::can::{Filter, Frame};
use crate::diagnosis::Diagnosis;
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::param::Parameters;
use crate::store::{ImageId, StoreError, Usage};
use crate::time::Instant;
use crate::update::Contact;

/// A node that consists of an application and a protocol.
///
/// As a [`Node`] it is for a driver with one thread of execution. [`ProductNode::halves`](super::ProductNode::halves) is for a driver that
/// handles frames at a higher priority than readings.
pub struct CanNode<A: Application, P> {
    communication: Communication<A, P>,
    acquisition: Acquisition<A>,
}

impl<A: Application, P: Protocol<A>> CanNode<A, P> {
    /// A node that is not started, for static memory. All bits are 0, so it needs no flash.
    pub const INITIAL: Self = Self {
        communication: Communication::INITIAL,
        acquisition: Acquisition::INITIAL,
    };

    /// The communicating and the measuring half.
    pub(crate) fn split(&mut self) -> (&mut Communication<A, P>, &mut Acquisition<A>) {
        (&mut self.communication, &mut self.acquisition)
    }

    /// Restores the parameters, the calibration and the identity of `boot`. Calls `started` before it applies the parameters; the last argument
    /// of `started` is true if the memory is damaged.
    pub(crate) fn start_with(
        &mut self,
        now: Instant,
        boot: &Boot,
        started: impl FnOnce(&mut A, &mut P, &mut Parameters<A::Table>, bool),
    ) {
        const {
            assert!(
                P::FRAMES <= super::TransmitQueue::OTHERS,
                "the transmit queue must hold all frames besides replies"
            );
        }
        let Communication {
            context, protocol, ..
        } = &mut self.communication;
        let application = self.acquisition.application();
        context.shell.start(now, boot, P::FRAMES);
        if A::HAS_DIAGNOSIS {
            context.diagnosis = Diagnosis::of(boot);
        }
        let damaged = context.restore(boot);
        application.start(boot.calibration);
        application.resume(boot.kept);
        started(application, protocol, &mut context.parameters, damaged);
        context.values = application.apply(now, &context.parameters);
        // The protocol starts with the first reading.
        if P::DETECTS && protocol.detects(&context.parameters) {
            context.shell.detect();
        }
    }
}

impl<P: Restore> CanNode<P::Application, P> {
    /// The identification of the stored images of its product.
    pub const IMAGE: ImageId = P::IMAGE;

    /// A node after power-up or a restart. If the stored parameters are not usable, it has the factory values and the memory
    /// fault is active.
    pub fn new(now: Instant, boot: &Boot) -> Self {
        let mut node = Self::INITIAL;
        node.start(now, boot);
        node
    }

    /// Starts an [`INITIAL`](Self::INITIAL) node in place.
    pub fn start(&mut self, now: Instant, boot: &Boot) {
        self.start_with(now, boot, |_, protocol, parameters, damaged| {
            protocol.restored(parameters, damaged);
        });
    }
}

/// The way from the measuring half to the communicating half on one thread, without a link: the driver passes the frames.
struct Direct<'a, A: Application, P> {
    communication: &'a mut Communication<A, P>,
    now: Instant,
}

impl<A: Application, P: Protocol<A>> Reach<A, P> for Direct<'_, A, P> {
    fn now(&self) -> Instant {
        self.now
    }

    fn with<R>(&mut self, f: impl FnOnce(&mut Communication<A, P>) -> R) -> R {
        f(self.communication)
    }

    fn call<R>(&mut self, f: impl FnOnce(&mut Communication<A, P>, Instant) -> R) -> R {
        f(self.communication, self.now)
    }

    fn settle(&mut self) {}

    fn action(&mut self, now: Instant) -> Option<Action> {
        self.communication.action(now)
    }
}

impl<A: Application, P: Protocol<A>> CanNode<A, P> {
    /// The measuring half, and its way to the communicating half.
    fn parts(&mut self, now: Instant) -> (&mut Acquisition<A>, Direct<'_, A, P>) {
        let communication = &mut self.communication;
        (&mut self.acquisition, Direct { communication, now })
    }
}

impl<A: Application, P: Protocol<A>> Node for CanNode<A, P> {
    fn ready(&self) -> bool {
        // PARAMETERS is ignored, because `receive` applies the parameters.
        let shell = &self.communication.context.shell;
        shell.ready(cause::PARAMETERS)
    }

    fn receive(&mut self, now: Instant, frame: &Frame) {
        let (acquisition, mut direct) = self.parts(now);
        acquisition.obey(&mut direct);
        self.communication.receive(now, frame);
        while self.communication.proceed() {}
    }

    fn sample(&mut self, now: Instant, reading: &Reading) {
        let (acquisition, mut direct) = self.parts(now);
        acquisition.measure(&mut direct, reading);
    }

    fn interrupt(&mut self) {
        self.acquisition.interrupt();
    }

    fn bus(&mut self, now: Instant, event: BusEvent) {
        self.communication.bus(now, event);
    }

    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        let (acquisition, mut direct) = self.parts(now);
        acquisition.stored(&mut direct, result);
    }

    fn tested(&mut self, now: Instant, result: Working) {
        let (acquisition, mut direct) = self.parts(now);
        let values = acquisition.tested(result);
        acquisition.publish(&mut direct, values);
    }

    fn supply(&mut self, now: Instant, millivolts: u16) {
        let (acquisition, mut direct) = self.parts(now);
        let values = acquisition.supply(millivolts);
        acquisition.publish(&mut direct, values);
    }

    fn poll(&mut self, now: Instant) -> Option<Action> {
        let (acquisition, mut direct) = self.parts(now);
        loop {
            match acquisition.round(&mut direct) {
                Round::Idle => return None,
                Round::Again => {}
                Round::Perform(action) => return Some(action),
            }
        }
    }

    fn sends_once(&self) -> bool {
        self.communication.sends_once()
    }

    fn transmit(&mut self, _now: Instant) -> Option<Frame> {
        self.communication.transmit()
    }

    fn sent(&mut self, now: Instant) {
        self.communication.sent(now);
    }

    fn deadline(&self) -> Option<Instant> {
        let communication = self.communication.deadline();
        self.acquisition.earliest(communication).time()
    }

    fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        self.communication.filters(accept);
    }

    fn changes_filters(&self) -> bool {
        P::CHANGES_FILTERS
    }

    fn image(&self, buffer: &mut [u8]) -> Option<usize> {
        self.communication.image().encode(buffer)
    }

    fn kept(&self) -> u32 {
        self.acquisition.kept()
    }

    fn contact(&self) -> Option<Contact> {
        self.communication.contact()
    }

    fn usage(&self) -> Option<Usage> {
        self.communication.usage()
    }

    fn set_usage(&mut self, usage: &Usage) {
        self.communication.set_usage(usage);
    }

    fn readout(&self) -> Readout {
        let context = &self.communication.context;
        A::readout(&context.values, &context.parameters)
    }
}
