//! The self-test of the accelerometer: the part applies a known force to its seismic mass, and the mean of some readings must change by
//! the amount in its datasheet ([`judge`]).
//!
//! ```text
//!  for the test  at rest       for the test  pushed        for measuring
//!  settling 40   mean of 128   settling 40   mean of 128   settling 40    readings of 5 ms: 1.9 s
//! ```
//!
//! The settling time is 200 ms. The datasheet of the ISM330DHCX specifies 100 ms, and the values of the last 24 ms are part of a reading.

use plumbline::measure::I32x3;
use plumbline::measure::self_test::{Limits, Working, judge};

/// The number of readings skipped after each change.
const SETTLING: u8 = 40;

/// The base-2 logarithm of the number of readings in a mean.
const MEAN: u32 = 7;

const ZERO: I32x3 = I32x3 { x: 0, y: 0, z: 0 };

/// The configuration of the accelerometer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SetUp {
    /// For measuring.
    Normal,
    /// For the test, without and with the test force.
    Test {
        /// The test force is on.
        pushed: bool,
    },
}

/// The result of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// Nothing yet.
    None,
    /// Configure the accelerometer like this.
    SetUp(SetUp),
    /// The end of the test: the accelerometer measures again, and these axes work.
    Done(Working),
}

/// The stage of a test.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Begin,
    AtRest,
    Pushed,
    Back,
}

/// A running test.
#[derive(Clone, Debug)]
pub struct SelfTest {
    limits: &'static Limits,
    /// The base-2 logarithm of the range for measuring, divided by the range for the test.
    narrowed: u32,
    stage: Stage,
    /// The number of readings in this stage.
    readings: u8,
    /// The partial mean: the sum of the readings, each divided by their number.
    mean: I32x3,
    at_rest: I32x3,
    working: Working,
    /// The last acceleration before the test, which is used during the test.
    held: I32x3,
}

impl SelfTest {
    /// A test of a part with these limits, which begins with the next reading. During the test the range is smaller by a factor of
    /// 2^`narrowed`.
    pub const fn begin(limits: &'static Limits, narrowed: u32) -> Self {
        Self {
            limits,
            narrowed,
            stage: Stage::Begin,
            readings: 0,
            mean: ZERO,
            at_rest: ZERO,
            working: Working {
                x: false,
                y: false,
                z: false,
            },
            held: ZERO,
        }
    }

    /// The last acceleration before the test.
    pub fn held(&self) -> I32x3 {
        self.held
    }

    /// Processes the acceleration of a reading. Its unit is that of the range for measuring, also in the
    /// range for the test.
    pub fn step(&mut self, acceleration: I32x3) -> Step {
        if self.stage != Stage::Begin {
            self.readings += 1;
            if self.readings <= SETTLING {
                return Step::None;
            }
            if self.stage == Stage::Back {
                return Step::Done(self.working);
            }
            let share = MEAN + self.narrowed;
            self.mean.x += acceleration.x >> share;
            self.mean.y += acceleration.y >> share;
            self.mean.z += acceleration.z >> share;
            if self.readings < SETTLING + (1 << MEAN) {
                return Step::None;
            }
        }
        let (next, set_up) = match self.stage {
            Stage::Begin => {
                self.held = acceleration;
                (Stage::AtRest, SetUp::Test { pushed: false })
            }
            Stage::AtRest => {
                self.at_rest = self.mean;
                (Stage::Pushed, SetUp::Test { pushed: true })
            }
            Stage::Pushed | Stage::Back => {
                self.working = judge(self.limits, self.at_rest, self.mean);
                (Stage::Back, SetUp::Normal)
            }
        };
        self.stage = next;
        self.readings = 0;
        self.mean = ZERO;
        Step::SetUp(set_up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::measure::ONE_G;

    /// The limits of the datasheets.
    const ISM330DHCX: Limits = Limits::milli_g([(90, 1700); 3]);

    /// Runs a test of an accelerometer with a test force of `push` mg on its axes. Returns the result and the number of readings.
    fn run(push: [i32; 3]) -> (Working, usize) {
        let mut test = SelfTest::begin(&ISM330DHCX, 1);
        let mut set_up = SetUp::Normal;
        let rest = [100, -200, 1000];
        for readings in 1..1000 {
            let milli_g = match set_up {
                SetUp::Normal => rest,
                // Twice the counts at +-4 g.
                SetUp::Test { pushed: false } => rest.map(|part| part * 2),
                SetUp::Test { pushed: true } => [0, 1, 2].map(|axis| (rest[axis] + push[axis]) * 2),
            };
            let [x, y, z] = milli_g.map(|part| ONE_G / 1000 * part);
            match test.step(I32x3 { x, y, z }) {
                Step::None => {}
                Step::SetUp(new) => {
                    assert_ne!(new, set_up);
                    set_up = new;
                }
                Step::Done(working) => {
                    assert_eq!(set_up, SetUp::Normal, "the configuration is restored");
                    assert_eq!(test.held().z, ONE_G / 1000 * 1000);
                    return (working, readings);
                }
            }
        }
        panic!("the test has no end");
    }

    #[test]
    fn axis_with_change_of_datasheet_works() {
        let cases = [
            ([500, 500, 500], [true, true, true]),
            ([0, 500, -500], [false, true, true]),
            ([80, 100, 1800], [false, true, false]),
            ([1600, 1000, 80], [true, true, false]),
        ];
        for (push, [x, y, z]) in cases {
            assert_eq!(run(push).0, Working { x, y, z }, "{push:?}");
        }
    }

    #[test]
    fn test_takes_about_two_seconds() {
        let milliseconds = run([500; 3]).1 * 5;
        assert!((1500..=2500).contains(&milliseconds), "{milliseconds} ms");
    }
}
