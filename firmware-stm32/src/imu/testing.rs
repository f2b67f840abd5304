//! The self-test of a driver.

use super::self_test::{SelfTest, SetUp, Step};
use plumbline::measure::Reading;
use plumbline::measure::self_test::{Limits, Working};

/// The running self-test, and the result of the last one. `TESTS` is 1 if the product has the self-test, otherwise 0: then an image does not
/// contain it.
pub struct Testing<const TESTS: usize> {
    running: [Option<SelfTest>; TESTS],
    /// The result, until it is read.
    result: Option<Working>,
}

impl<const TESTS: usize> Testing<TESTS> {
    pub const NONE: Self = Self {
        running: [const { None }; TESTS],
        result: None,
    };

    /// Begins a self-test ([`SelfTest::begin`]).
    pub fn begin(&mut self, limits: &'static Limits, narrowed: u32) {
        self.running = [const { None }; TESTS];
        if let Some(running) = self.running.first_mut() {
            *running = Some(SelfTest::begin(limits, narrowed));
        }
    }

    /// The part is missing: no axis works.
    pub fn abort(&mut self) {
        if self.running.iter().any(Option::is_some) {
            self.end(Working::default());
        }
    }

    /// Performs one step while no transfer is running. Returns the reading for the node, and the configuration that the part needs from now
    /// on. During the test the reading has the last acceleration before it.
    pub fn step(&mut self, reading: Reading) -> (Reading, Option<SetUp>) {
        let Some(test) = self.running.first_mut().and_then(Option::as_mut) else {
            return (reading, None);
        };
        let step = test.step(reading.acceleration);
        let reading = Reading {
            acceleration: test.held(),
            clipped: false,
            ..reading
        };
        let set_up = match step {
            Step::None => None,
            Step::SetUp(set_up) => Some(set_up),
            Step::Done(working) => {
                info!("self-test: {}", working);
                self.end(working);
                None
            }
        };
        (reading, set_up)
    }

    fn end(&mut self, working: Working) {
        self.running = [const { None }; TESTS];
        self.result = Some(working);
    }

    /// The result of a finished self-test, once.
    pub fn result(&mut self) -> Option<Working> {
        if TESTS == 0 {
            return None;
        }
        self.result.take()
    }
}
