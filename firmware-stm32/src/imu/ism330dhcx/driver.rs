//! The state of the driver: finding the part, settling, and the self-test.

use super::counts::{FLOOR, FRACTION, WIDTH, WORD};
use super::registers::READ;
use super::tags::Tags;
use crate::board::ImuWires;
use crate::imu::line::Line;
use crate::imu::rates::Rates;
use crate::imu::self_test::SetUp;
use crate::imu::testing::Testing;
use crate::imu::values::Values;
use crate::imu::words::Words;
use crate::imu::{Element, SpiError};
use ism330dhcx_rs::blocking::prelude::Reg;
use plumbline::measure::calibration::Part;
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::self_test::{Limits, Working};
use plumbline::measure::{ONE_G, Reading};
use plumbline::time::{Instant, after, millis, reached};

/// The time after which the accelerometer is configured again that answers, but not as expected, in ms.
const RETRY_MS: u32 = 100;

/// A failure before this time, 100 ms after power-up, is not logged: the accelerometer does not answer during its boot of 10 ms.
const BOOT_END: Instant = Instant::from_ticks(100_000);

/// The number of values to skip after configuration: 19 ms, in which the accelerometer turns on.
const SETTLING_VALUES: u16 = 16;

/// The number of values to skip after errors on the line or a stuck axis, without another error in between: 0.5 s.
const CLEAN_VALUES: u16 = 416;

/// The number of words without an error after which an error on the line is a single one again: 1 s without gyroscope, 0.5 s with it.
const MEMORY: u16 = 833;

/// The number of consecutive readings of the FIFO without a value after which the accelerometer has failed: 50 ms.
const MISSES: u8 = 10;

/// At +-4 g, the range of the self-test, a count is half the acceleration.
const HALVED: u32 = 1;

pub(super) enum State {
    /// There is no accelerometer, or it does not work. The next attempt to configure it is at `retry`.
    Absent { retry: Instant },
    /// Configured. `settling`: values still to skip; `misses`: consecutive readings of the FIFO without a value.
    Running { settling: u16, misses: u8 },
}

/// Why there are no readings.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Trouble {
    /// Nothing answers, or the SPI has failed.
    Silent,
    /// Another part: its identifier is wrong, or it has no gyroscope, as the IIS2ICLX.
    Identity,
    /// A register does not have the value that was written: the part was reset, or a disturbance has changed it.
    Settings,
    /// The FIFO stays empty.
    NoValues,
    /// The gyroscope has no values.
    NoRate,
    /// Repeated bit errors between accelerometer and microcontroller.
    Line,
    /// An axis has always the same value.
    Stuck,
}

impl Trouble {
    /// For the log.
    fn text(self) -> &'static str {
        match self {
            Self::Silent => "does not answer",
            Self::Identity => "is another part",
            Self::Settings => "has lost its configuration",
            Self::NoValues => "has no values",
            Self::NoRate => "has no angular rate",
            Self::Line => "has bit errors on its line",
            Self::Stuck => "has an axis that does not change",
        }
    }
}

impl From<SpiError> for Trouble {
    fn from(_: SpiError) -> Self {
        Self::Silent
    }
}

/// The gyroscope.
pub(super) struct Gyroscope {
    pub(super) rate: MeanRate<FRACTION>,
    pub(super) rates: Rates,
    /// The number of samples without an angular rate.
    pub(super) silent: u8,
    /// Values were lost before the next reading.
    pub(super) lost: bool,
}

impl Gyroscope {
    pub(super) const INITIAL: Self = Self {
        rate: MeanRate::new(),
        rates: Rates::INITIAL,
        silent: 0,
        lost: false,
    };
}

/// The accelerometer. `TESTS` is 1 if the product has the self-test, otherwise 0, and `GYROSCOPES` is 1 if it has a gyroscope; an image
/// does not contain what its product does not have.
pub struct Ism330dhcx<const TESTS: usize, const GYROSCOPES: usize> {
    pub(super) wires: ImuWires,
    pub(super) state: State,
    pub(super) words: Words<WORD>,
    /// The judgement of the tags, of the line, and of the values.
    pub(super) tags: Tags,
    pub(super) line: Line<MEMORY>,
    pub(super) values: Values<FLOOR, WIDTH>,
    /// The number of the register to compare next.
    pub(super) next: usize,
    /// The present range and self-test.
    pub(super) set_up: SetUp,
    pub(super) resampler: Resampler<i16, FRACTION>,
    pub(super) gyroscope: [Gyroscope; GYROSCOPES],
    /// An axis was at the limit of its range since the last reading.
    pub(super) clipped: bool,
    /// The last temperature in 0.01 degC; None before the first one.
    pub(super) temperature: Option<i16>,
    /// The counts of the last temperature, also if it was not used, and the number of accelerations since it has changed.
    pub(super) warmth: i16,
    pub(super) unchanged: u16,
    pub(super) testing: Testing<TESTS>,
    /// The number of attempts in a row in which the identifier was 0.
    pub(super) zeros: u8,
    /// The failure that is logged.
    reported: Option<Trouble>,
    /// There were repeated errors on the line, or a stuck axis, since the last reading.
    pub(super) doubted: bool,
}

impl<const TESTS: usize, const GYROSCOPES: usize> Element for Ism330dhcx<TESTS, GYROSCOPES> {
    const PART: Part = Part::Ism330dhcx;
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
            },
            words: Words::new(Reg::FifoDataOutTag as u8 | READ),
            tags: Tags::INITIAL,
            line: Line::INITIAL,
            values: Values::INITIAL,
            next: 0,
            set_up: SetUp::Normal,
            resampler: const { Resampler::new() }, // as a constant, its values are cleared without a loop
            gyroscope: [Gyroscope::INITIAL; GYROSCOPES],
            clipped: false,
            temperature: None,
            warmth: 0,
            unchanged: 0,
            testing: Testing::NONE,
            zeros: 0,
            reported: None,
            doubted: false,
        }
    }

    fn start(&mut self, now: Instant) {
        if matches!(self.state, State::Absent { .. }) {
            self.testing.abort();
        }
        match self.state {
            State::Absent { retry } if reached(now, retry) => self.find(now),
            State::Absent { .. } => {}
            State::Running { misses, .. } if misses >= MISSES => self.fail(now, Trouble::NoValues),
            State::Running { ref mut misses, .. } => {
                *misses += 1;
                self.words.begin();
                self.resampler.follow();
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
        let gyroscope = self.gyroscope.first_mut();
        gyroscope.is_some_and(|gyroscope| core::mem::take(&mut gyroscope.lost))
    }

    fn test(&mut self) {
        self.testing.begin(const { &Self::LIMITS }, HALVED);
    }

    fn tested(&mut self) -> Option<Working> {
        self.testing.result()
    }
}

impl<const TESTS: usize, const GYROSCOPES: usize> Ism330dhcx<TESTS, GYROSCOPES> {
    /// Performs one step of the self-test, if it runs, while no transfer is running. Returns the reading for the node.
    pub(super) fn carry_test_on(&mut self, now: Instant, reading: Reading) -> Reading {
        let (reading, set_up) = self.testing.step(reading);
        if let Some(set_up) = set_up
            && self.change(set_up).is_err()
        {
            self.fail(now, Trouble::Silent);
        }
        reading
    }

    /// There are no readings until the accelerometer is configured again, which is tried at once.
    pub(super) fn fail(&mut self, now: Instant, trouble: Trouble) {
        if self.reported != Some(trouble) && reached(now, BOOT_END) {
            warn!("the accelerometer {=str}", trouble.text());
            self.reported = Some(trouble);
        }
        self.doubted |= matches!(trouble, Trouble::Line | Trouble::Stuck);
        self.words.stop();
        self.state = State::Absent { retry: now };
    }

    /// Tries to configure the accelerometer.
    fn find(&mut self, now: Instant) {
        match self.configure() {
            Ok(()) => {
                self.state = State::Running {
                    settling: self.settling_values(),
                    misses: 0,
                };
            }
            Err(trouble) => {
                self.fail(now, trouble);
                if trouble != Trouble::Silent {
                    let retry = after(now, millis(RETRY_MS));
                    self.state = State::Absent { retry };
                }
            }
        }
    }

    /// The number of values to skip.
    pub(super) fn settling_values(&self) -> u16 {
        if self.doubted {
            CLEAN_VALUES
        } else {
            SETTLING_VALUES
        }
    }

    /// The accelerometer has settled.
    pub(super) fn settled(&mut self) {
        // They differ in a register that is reserved in the ASM330LHH, so it is not tried which one it is.
        info!("accelerometer found: ISM330DHCX or ASM330LHH");
        self.reported = None;
        self.doubted = false;
    }
}
