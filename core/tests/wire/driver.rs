//! The driver with one thread: the order of the events of its controller.

use plumbline::can::{BitRate, Filter, Frame};
use plumbline::model::gemac::is2::{self, Is2};
use plumbline::node::driver::{Controller, Driver, OneThread, Phase, Platform};
use plumbline::node::{Action, BitTime, Boot, BusEvent};
use plumbline::time::Instant;

/// Mailboxes of a controller that only listens.
struct Mailboxes;

impl Controller for Mailboxes {
    fn now(&self) -> Instant {
        Instant::from_ticks(0)
    }
    fn phase(&self) -> Phase {
        Phase::Listening
    }
    fn pause(&mut self, _: Phase) {}
    fn is_at(&self, _: BitRate) -> bool {
        false
    }
    fn has_room(&self) -> bool {
        false
    }
    fn is_idle(&self) -> bool {
        true
    }
    fn put(&mut self, _: &Frame, _: bool) {}
    fn abort(&mut self) {}
    fn lose(&mut self) {}
}

/// A controller that discards its errors at a change of the bit rate.
#[derive(Default)]
struct Listener {
    bit_time: Option<BitTime>,
    has_error: bool,
    rates: Vec<BitRate>,
}

impl Platform for Listener {
    fn step(&mut self, _: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        false
    }
    fn event(&mut self) -> Option<BusEvent> {
        if let Some(time) = self.bit_time.take() {
            return Some(BusEvent::BitTime(time));
        }
        core::mem::take(&mut self.has_error).then_some(BusEvent::Error)
    }
    fn refilter(&mut self, _: impl FnOnce(&mut dyn FnMut(Filter))) {}
    fn perform(&mut self, action: Action) {
        if let Action::Bus(_, rate) = action {
            self.rates.push(rate);
            self.has_error = false;
        }
    }
    fn save(&mut self, _: impl FnOnce(&mut [u8]) -> Option<usize>) {}
    fn restart(&mut self, _: u32) {}
}

/// The error comes after the read of the bit time. The next frame has the same bit time. If the error counted at the new bit rate, the node
/// would leave this bit rate.
#[test]
fn error_at_old_bit_rate_does_not_count_at_measured_one() {
    let mut sensor = Is2::new(&is2::BP_CL, Instant::from_ticks(0), &Boot::default());
    let mut driver = Driver::new(OneThread::new(&mut sensor, Mailboxes));
    let mut listener = Listener::default();
    while driver.turn(&mut listener) {}
    for has_error in [true, false] {
        listener.bit_time = Some(BitTime::of(BitRate::K125));
        listener.has_error = has_error;
        while driver.turn(&mut listener) {}
    }
    assert_eq!(listener.rates, [BitRate::K250, BitRate::K125]);
}
