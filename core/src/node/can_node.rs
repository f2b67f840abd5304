//! A node: an application, a protocol and the protocol-neutral shell.

use super::shell::cause;
use super::{Acquisition, Action, Boot, BusEvent, Communication, Indicator, Node, Protocol};
use crate::application::{Application, Readout};
use crate::can::{Filter, Frame};
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::param::{Parameters, Table};
use crate::store::{ImageId, Owner, StoreError, buffer_size};
use crate::time::Instant;

/// A node that consists of an application and a protocol.
///
/// As a [`Node`] it is for a driver with one thread of execution. [`Divided::halves`] is for a driver that handles frames at a
/// higher priority than readings.
pub struct CanNode<A: Application, P> {
    communication: Communication<A, P>,
    acquisition: Acquisition<A>,
    indicator: Indicator,
}

/// The types of a node that consists of two halves.
pub trait Divided {
    /// The application, in the measuring half.
    type Application: Application + 'static;
    /// The protocol, in the communicating half.
    type Protocol: Protocol<Self::Application> + 'static;

    /// The communicating and the measuring half, for a driver that handles frames at a higher priority than readings.
    fn halves(&mut self) -> Halves<'_, Self::Application, Self::Protocol>;
}

/// The communicating and the measuring half of a node.
pub type Halves<'a, A, P> = (&'a mut Communication<A, P>, &'a mut Acquisition<A>);

impl<A: Application + 'static, P: Protocol<A> + 'static> Divided for CanNode<A, P> {
    type Application = A;
    type Protocol = P;

    fn halves(&mut self) -> Halves<'_, A, P> {
        (&mut self.communication, &mut self.acquisition)
    }
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
    /// Whether it needs the angular rate.
    pub const HAS_GYROSCOPE: bool = A::HAS_GYROSCOPE;

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
        communication: Communication::INITIAL,
        acquisition: Acquisition::INITIAL,
        indicator: Indicator::DARK,
    };

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

    /// Performs the tasks of the measuring half.
    fn measure(&mut self, now: Instant) {
        while let Some(task) = self.communication.task(now) {
            let values = self.acquisition.perform(now, &task);
            self.communication.finish(now, &task, values);
        }
    }
}

impl<A: Application, P: Protocol<A>> Node for CanNode<A, P> {
    fn ready(&self) -> bool {
        // PARAMETERS is ignored, because `receive` applies the parameters. BUS is ignored, because the driver performs the action
        // before it passes frames.
        let shell = &self.communication.context.shell;
        shell.ready(cause::PARAMETERS | cause::BUS)
    }

    fn receive(&mut self, now: Instant, frame: &Frame) {
        self.measure(now);
        self.communication.receive(now, frame);
        while self.communication.proceed() {}
    }

    fn sample(&mut self, now: Instant, reading: &Reading) {
        self.measure(now);
        if !self.communication.context.shell.is_leaving() {
            let values = self.acquisition.sample(now, reading);
            self.communication.sampled(now, values);
        }
    }

    fn bus(&mut self, now: Instant, event: BusEvent) {
        self.communication.bus(now, event);
    }

    fn stored(&mut self, now: Instant, result: Result<(), StoreError>) {
        self.communication.stored(now, result);
        self.measure(now);
        while self.communication.resume(now) {
            self.measure(now);
        }
    }

    fn tested(&mut self, now: Instant, result: Working) {
        if let Some(values) = self.acquisition.tested(result) {
            self.communication.publish(now, values);
        }
    }

    fn supply(&mut self, now: Instant, millivolts: u16) {
        if let Some(values) = self.acquisition.supply(millivolts) {
            self.communication.publish(now, values);
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action> {
        self.measure(now);
        if let Some(values) = self.acquisition.tick(now) {
            self.communication.publish(now, values);
        }
        loop {
            if let Some(leds) = self.indicator.poll(now) {
                return Some(Action::Leds(leds));
            }
            if self.communication.is_idle(now) {
                return None;
            }
            while self.communication.tick(now) {}
            if let Some(patterns) = self.communication.patterns() {
                self.indicator.show(now, patterns);
            }
            if let Some(action) = self.communication.action(now) {
                return Some(action);
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
        let mut earliest = self.communication.deadline();
        earliest.consider(self.acquisition.deadline());
        self.indicator.consider(&mut earliest);
        earliest.time()
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

    fn readout(&self) -> Readout {
        let context = &self.communication.context;
        A::readout(&context.values, &context.parameters)
    }
}
