//! The state of the driver: finding the part, its reset, settling, and the self-test.

use super::counts::{FLOOR, VALUE, WIDTH};
use super::registers::{Shadows, reading};
use crate::board::ImuWires;
use crate::imu::Element;
use crate::imu::line::Line;
use crate::imu::testing::Testing;
use crate::imu::values::Values;
use crate::imu::words::Words;
use adi_adxl355::Register;
use plumbline::measure::calibration::Part;
use plumbline::measure::resampler::{Resampler, TAPS_1000};
use plumbline::measure::self_test::{Limits, Working};
use plumbline::measure::{ONE_G, Reading};
use plumbline::time::{Instant, after, millis, reached};

/// A missing part is not logged before this time, 100 ms after power-up: it does not answer during its boot of 10 ms.
const BOOT_END: Instant = Instant::from_ticks(100_000);

/// The time from a reset until the part is looked at again, in ms.
const RESET_MS: u32 = 5;

/// The number of resets after which the part has failed.
const RESETS: u8 = 5;

/// The number of values to skip after configuration: 16 ms. The part turns on within 10 ms.
const SETTLING_VALUES: u16 = 16;

/// The number of values to skip after errors on the line or a stuck axis, without another error in between: 0.5 s.
const CLEAN_VALUES: u16 = 500;

/// The number of values without an error after which an error on the line is a single one again: 1 s.
const MEMORY: u16 = 1000;

/// The number of consecutive readings of the FIFO without a value after which the part has failed: 50 ms.
const MISSES: u8 = 10;

/// The time in which the values are counted for the data rate, in us. An error of one value is 0.08 %.
pub(super) const MEASUREMENT_US: u32 = 1_280_000;

/// The nominal data rate in mHz.
const DATA_RATE: u32 = 1_000_000;

pub(super) enum State {
    /// The part was not found, or does not answer any more. The driver looks for it every 5 ms.
    Absent,
    /// After `resets` resets. It is looked at again at `ready`, and must have these shadow registers.
    Resetting {
        ready: Instant,
        shadows: Shadows,
        resets: u8,
    },
    /// Configured. `settling`: values still to skip; `misses`: consecutive readings of the FIFO without a value.
    Running { settling: u16, misses: u8 },
}

/// The part. `TESTS` is 1 if the product has the self-test, otherwise 0.
pub struct Adxl355<const TESTS: usize> {
    pub(super) wires: ImuWires,
    pub(super) state: State,
    pub(super) words: Words<VALUE>,
    /// The judgement of the line, and of the values.
    pub(super) line: Line<MEMORY>,
    pub(super) values: Values<FLOOR, WIDTH>,
    pub(super) resampler: Resampler<i32, 0, TAPS_1000>,
    /// The number of values since the start, modulo 2^32.
    pub(super) taken: u32,
    /// The begin of the measurement of the data rate, and the number of values then.
    pub(super) counted: Option<(Instant, u32)>,
    /// The data rate is measured.
    pub(super) is_timed: bool,
    /// Values were lost before the next reading.
    pub(super) lost: bool,
    /// An axis was beyond its range since the last reading.
    pub(super) clipped: bool,
    /// The counts of the last temperature, and the number of values since it has changed.
    pub(super) warmth: u16,
    pub(super) unchanged: u16,
    /// The last temperature in 0.01 degC; None before the first one.
    pub(super) temperature: Option<i16>,
    /// There were repeated errors on the line, or a stuck axis, since the last reading.
    pub(super) doubted: bool,
    /// SELF_TEST.
    pub(super) force: u8,
    pub(super) testing: Testing<TESTS>,
    /// The missing part is logged.
    reported: bool,
}

impl<const TESTS: usize> Element for Adxl355<TESTS> {
    const PART: Part = Part::Adxl355;
    const GYROSCOPE: bool = false;
    const SELF_TEST: bool = true;
    const RANGE: i32 = 8 * ONE_G;
    /// The datasheet (revision D), "self-test, output change".
    const LIMITS: Limits = Limits::milli_g([(100, 600), (100, 600), (500, 3000)]);

    fn new(wires: ImuWires) -> Self {
        Self {
            wires,
            state: State::Absent,
            words: Words::new(reading(Register::FIFO_DATA)),
            line: Line::INITIAL,
            values: Values::INITIAL,
            resampler: const { Resampler::new() }, // as a constant, its values are cleared without a loop
            taken: 0,
            counted: None,
            is_timed: false,
            lost: false,
            clipped: false,
            warmth: 0,
            unchanged: 0,
            temperature: None,
            doubted: false,
            force: 0,
            testing: Testing::NONE,
            reported: false,
        }
    }

    fn start(&mut self, now: Instant) {
        if !matches!(self.state, State::Running { .. }) {
            self.testing.abort();
        }
        match self.state {
            State::Absent => self.find(now),
            State::Resetting {
                ready,
                shadows,
                resets,
            } if reached(now, ready) => self.set_up(now, shadows, resets),
            State::Resetting { .. } => {}
            State::Running { misses, .. } if misses >= MISSES => self.begin_again(),
            State::Running { ref mut misses, .. } => {
                *misses += 1;
                self.words.begin();
                if self.is_timed {
                    self.resampler.follow();
                }
            }
        }
    }

    fn busy(&self) -> bool {
        self.words.is_busy()
    }

    fn step(&mut self, now: Instant) -> Option<Reading> {
        self.read_on(now)
    }

    fn lost(&mut self) -> bool {
        core::mem::take(&mut self.lost)
    }

    fn test(&mut self) {
        self.testing.begin(const { &Self::LIMITS }, 0);
    }

    fn tested(&mut self) -> Option<Working> {
        self.testing.result()
    }
}

impl<const TESTS: usize> Adxl355<TESTS> {
    /// Performs one step of the self-test, if it runs, while no transfer is running. Returns the reading for the node.
    pub(super) fn carry_test_on(&mut self, now: Instant, reading: Reading) -> Reading {
        let (reading, set_up) = self.testing.step(reading);
        if let Some(set_up) = set_up
            && self.change(set_up).is_err()
        {
            self.absent(now);
        }
        reading
    }

    /// The part is missing.
    fn absent(&mut self, now: Instant) {
        if !self.reported && reached(now, BOOT_END) {
            warn!("no accelerometer");
            self.reported = true;
        }
        self.begin_again();
    }

    /// The part is to be configured again, if it answers.
    pub(super) fn begin_again(&mut self) {
        self.words.stop();
        self.state = State::Absent;
    }

    /// Tries to find the part, and resets it.
    fn find(&mut self, now: Instant) {
        match self.identifies() {
            Ok(true) => self.reset_again(now, 1),
            _ => self.absent(now),
        }
    }

    /// Resets the part for this time.
    fn reset_again(&mut self, now: Instant, resets: u8) {
        match self.reset() {
            Ok(shadows) if resets <= RESETS => {
                self.state = State::Resetting {
                    ready: after(now, millis(RESET_MS)),
                    shadows,
                    resets,
                }
            }
            _ => self.absent(now),
        }
    }

    /// Configures the part after its reset.
    fn set_up(&mut self, now: Instant, shadows: Shadows, resets: u8) {
        if self.has_started(shadows) != Ok(true) {
            return self.reset_again(now, resets + 1);
        }
        if self.configure() != Ok(true) {
            return self.absent(now);
        }
        info!("accelerometer found");
        self.reported = false;
        self.resampler.start(DATA_RATE);
        self.counted = None;
        self.is_timed = false;
        self.clipped = false;
        self.temperature = None;
        self.values = Values::INITIAL;
        self.state = State::Running {
            settling: self.settling_values(),
            misses: 0,
        };
    }

    /// The number of values to skip.
    pub(super) fn settling_values(&self) -> u16 {
        if self.doubted {
            CLEAN_VALUES
        } else {
            SETTLING_VALUES
        }
    }
}
