//! The state of the driver: finding the part, settling, and the self-test.

use super::counts::{FRACTION, WORD};
use super::fifo::Step;
use crate::board::ImuWires;
use crate::imu::Element;
use crate::imu::self_test::{self, SelfTest};
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::self_test::{Limits, Working};
use plumbline::measure::{ONE_G, Reading};
use plumbline::time::{Instant, after, millis, reached};

/// The time between attempts to find the accelerometer, in ms.
const RETRY_MS: u32 = 1000;

/// The time between attempts after power-up, in ms: the accelerometer does not answer during its boot of 10 ms.
const BOOT_RETRY_MS: u32 = 2;

/// The end of the shorter interval: 100 ms after power-up.
const BOOT_END: Instant = Instant::from_ticks(100_000);

/// The number of values to skip after configuration: 19 ms, in which the accelerometer turns on.
const SETTLING_VALUES: u8 = 16;

/// The number of consecutive readings of the FIFO without a value after which the accelerometer has failed: 50 ms.
const MISSES: u8 = 10;

/// At +-4 g, the range of the self-test, a count is half the acceleration.
const HALVED: u32 = 1;

/// The time after a failed attempt until which the accelerometer can be in its boot of 10 ms, in ms. Then nothing is written to it.
const BOOT_MS: u32 = 15;

pub(super) enum State {
    /// The accelerometer was not found, or does not answer any more. The next attempt is at `retry`. `failed` is the time of the first
    /// attempt that has failed.
    Absent {
        retry: Instant,
        failed: Option<Instant>,
    },
    /// Configured. `settling`: values still to skip; `misses`: consecutive readings of the FIFO without a value.
    Running { settling: u8, misses: u8 },
}

/// The gyroscope.
pub(super) struct Gyroscope {
    pub(super) rate: MeanRate<FRACTION>,
    /// The number of samples without an angular rate.
    pub(super) silent: u8,
    /// Values were lost before the next reading.
    pub(super) lost: bool,
}

impl Gyroscope {
    pub(super) const INITIAL: Self = Self {
        rate: MeanRate::new(),
        silent: 0,
        lost: false,
    };
}

/// The accelerometer. `TESTS` is 1 if the product has the self-test, otherwise 0, and `GYROSCOPES` is 1 if it has a gyroscope; an image
/// does not contain what its product does not have.
pub struct Ism330dhcx<const TESTS: usize, const GYROSCOPES: usize> {
    pub(super) wires: ImuWires,
    pub(super) state: State,
    pub(super) step: Step,
    /// The number of words to read, with the present one.
    pub(super) words: u16,
    /// The present word: the bytes to send, replaced by the received ones.
    pub(super) bytes: [u8; WORD],
    pub(super) resampler: Resampler<i16, FRACTION>,
    pub(super) gyroscope: [Gyroscope; GYROSCOPES],
    /// An axis was at the limit of its range since the last reading.
    pub(super) clipped: bool,
    /// The last temperature in 0.01 degC; None before the first one.
    pub(super) temperature: Option<i16>,
    /// The running self-test.
    test: [Option<SelfTest>; TESTS],
    /// The result of the last self-test, until it is read.
    tested: Option<Working>,
    /// The missing accelerometer is logged.
    reported: bool,
}

impl<const TESTS: usize, const GYROSCOPES: usize> Element for Ism330dhcx<TESTS, GYROSCOPES> {
    const GYROSCOPE: bool = true;
    const SELF_TEST: bool = true;
    const RANGE: i32 = 8 * ONE_G;
    /// The datasheet, "linear acceleration self-test output change".
    const LIMITS: Limits = Limits::milli_g([(90, 1700); 3]);

    fn new(wires: ImuWires) -> Self {
        Self {
            wires,
            state: State::Absent {
                retry: Instant::from_ticks(0),
                failed: None,
            },
            step: Step::None,
            words: 0,
            bytes: [0; WORD],
            resampler: const { Resampler::new() }, // as a constant, its values are cleared without a loop
            gyroscope: [Gyroscope::INITIAL; GYROSCOPES],
            clipped: false,
            temperature: None,
            test: [const { None }; TESTS],
            tested: None,
            reported: false,
        }
    }

    fn start(&mut self, now: Instant) {
        if matches!(self.state, State::Absent { .. }) && self.running_test().is_some() {
            self.end_test(Working::default());
        }
        match self.state {
            State::Absent { retry, failed } if reached(now, retry) => self.find(now, failed),
            State::Absent { .. } => {}
            State::Running { misses, .. } if misses >= MISSES => self.absent(now),
            State::Running { ref mut misses, .. } => {
                *misses += 1;
                self.step = Step::Level;
                self.resampler.follow();
            }
        }
    }

    fn busy(&self) -> bool {
        !matches!(self.step, Step::None)
    }

    fn step(&mut self, now: Instant) -> Option<Reading> {
        self.read_on(now)
    }

    fn lost(&mut self) -> bool {
        let gyroscope = self.gyroscope.first_mut();
        gyroscope.is_some_and(|gyroscope| core::mem::take(&mut gyroscope.lost))
    }

    fn test(&mut self) {
        self.test = [const { Some(SelfTest::begin(&Self::LIMITS, HALVED)) }; TESTS];
    }

    fn tested(&mut self) -> Option<Working> {
        if TESTS == 0 {
            return None;
        }
        self.tested.take()
    }
}

impl<const TESTS: usize, const GYROSCOPES: usize> Ism330dhcx<TESTS, GYROSCOPES> {
    /// The running self-test.
    pub(super) fn running_test(&mut self) -> Option<&mut SelfTest> {
        self.test.first_mut()?.as_mut()
    }

    /// Performs one step of the self-test while no transfer is running. Returns the reading for the node.
    pub(super) fn carry_test_on(&mut self, now: Instant, reading: Reading) -> Option<Reading> {
        let test = self.running_test()?;
        let step = test.step(reading.acceleration);
        let reading = Reading {
            acceleration: test.held(),
            clipped: false,
            ..reading
        };
        match step {
            self_test::Step::None => {}
            self_test::Step::SetUp(set_up) if self.change(set_up).is_ok() => {}
            self_test::Step::SetUp(_) => self.absent(now),
            self_test::Step::Done(working) => {
                info!("self-test: {}", working);
                self.end_test(working);
            }
        }
        Some(reading)
    }

    fn end_test(&mut self, working: Working) {
        self.test = [const { None }; TESTS];
        self.tested = Some(working);
    }

    /// The accelerometer is missing.
    pub(super) fn absent(&mut self, now: Instant) {
        if !self.reported && reached(now, BOOT_END) {
            warn!("no accelerometer");
            self.reported = true;
        }
        let pause = if reached(now, BOOT_END) {
            RETRY_MS
        } else {
            BOOT_RETRY_MS
        };
        self.state = State::Absent {
            retry: after(now, millis(pause)),
            failed: None,
        };
    }

    /// Tries to find the accelerometer and configures it.
    fn find(&mut self, now: Instant, failed: Option<Instant>) {
        let first = failed.unwrap_or(now);
        match self.set_up(reached(now, after(first, millis(BOOT_MS)))) {
            Ok(true) => {
                info!("accelerometer found");
                self.reported = false;
                self.state = State::Running {
                    settling: SETTLING_VALUES,
                    misses: 0,
                };
            }
            _ => {
                self.absent(now);
                if let State::Absent { failed, .. } = &mut self.state {
                    *failed = Some(first);
                }
            }
        }
    }
}
