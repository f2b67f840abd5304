//! The driver of the ISM330DHCX: acceleration at +-8 g and temperature, and for products with a gyroscope the angular rate at +-1000
//! deg/s.
//!
//! The accelerometer runs at 833 Hz in high-performance mode without LPF2. Each value goes into its FIFO, so none is lost or read
//! twice, although its oscillator has an error of some per cent, and none is lost while the flash stalls the processor. Every 5 ms
//! the driver reads the FIFO, and a [`Resampler`] converts the values to readings at 200 Hz. It takes the data rate from
//! INTERNAL_FREQ_FINE, in which the accelerometer states the error of its oscillator.
//!
//! The number of words in the FIFO and each word are transfers of their own, a word in two halves ([`Imu::step`]). Between two
//! halves the main loop handles frames.
//!
//! The gyroscope has the same data rate, and its values are in the same FIFO. A reading has their mean since the last reading
//! ([`MeanRate`]). The FIFO holds values for 0.55 s, and with the gyroscope for 0.28 s. A longer stall loses the oldest values: while the
//! F446 erases a sector, which takes 0.25 s and at most 0.5 s. The rotation in these values is not known, so the driver reports the gap
//! ([`Imu::lost`]). If the gyroscope gives no values, there are no readings.
//!
//! During the self-test ([`self_test`](crate::self_test)) the last acceleration before it is used.
//!
//! If the accelerometer is missing or fails, there are no samples, and the driver tries to find it every second.

mod fifo;
mod registers;

use crate::board::ImuWires;
use crate::counts::{FRACTION, WORD};
use crate::self_test::{self, SelfTest};
use fifo::Step;
use plumbline::measure::Reading;
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::self_test::Working;
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

/// The time after a failed attempt until which the accelerometer can be in its boot of 10 ms, in ms. Then nothing is written to it.
const BOOT_MS: u32 = 15;

enum State {
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
struct Gyroscope {
    rate: MeanRate<FRACTION>,
    /// The number of samples without an angular rate.
    silent: u8,
    /// Values were lost before the next reading.
    lost: bool,
}

impl Gyroscope {
    const INITIAL: Self = Self {
        rate: MeanRate::new(),
        silent: 0,
        lost: false,
    };
}

/// The accelerometer. `TESTS` is 1 if the product has the self-test, otherwise 0, and `GYROSCOPES` is 1 if it has a gyroscope; an image
/// does not contain what its product does not have.
pub struct Imu<const TESTS: usize, const GYROSCOPES: usize> {
    wires: ImuWires,
    state: State,
    step: Step,
    /// The number of words to read, with the present one.
    words: u16,
    /// The present word: the bytes to send, replaced by the received ones.
    bytes: [u8; WORD],
    resampler: Resampler<i16, FRACTION>,
    gyroscope: [Gyroscope; GYROSCOPES],
    /// An axis was at the limit of its range since the last reading.
    clipped: bool,
    /// The last temperature in 0.01 degC; None before the first one.
    temperature: Option<i16>,
    /// The running self-test.
    test: [Option<SelfTest>; TESTS],
    /// The result of the last self-test, until it is read.
    tested: Option<Working>,
    /// The missing accelerometer is logged.
    reported: bool,
}

impl<const TESTS: usize, const GYROSCOPES: usize> Imu<TESTS, GYROSCOPES> {
    /// The driver for the accelerometer on this bus, before the first attempt to find it.
    pub fn new(wires: ImuWires) -> Self {
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

    /// Begins a self-test. [`tested`](Self::tested) returns the result after about 2 s. A running self-test begins again.
    pub fn test(&mut self) {
        self.test = [const { Some(SelfTest::begin()) }; TESTS];
    }

    /// The result of a finished self-test, once.
    pub fn tested(&mut self) -> Option<Working> {
        if TESTS == 0 {
            return None;
        }
        self.tested.take()
    }

    /// The running self-test.
    fn running_test(&mut self) -> Option<&mut SelfTest> {
        self.test.first_mut()?.as_mut()
    }

    /// Begins to read the FIFO, or tries to find a missing accelerometer. Call it every 5 ms.
    pub fn start(&mut self, now: Instant) {
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

    /// Performs one step of the self-test while no transfer is running. Returns the reading for the node.
    fn carry_test_on(&mut self, now: Instant, reading: Reading) -> Option<Reading> {
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
    fn absent(&mut self, now: Instant) {
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

/// The SPI (mode 0 or 3, at most 10 MHz) and the chip select of the accelerometer.
pub trait Wires {
    /// Begins or ends a transfer.
    fn select(&mut self, selected: bool);

    /// Sends `bytes` and replaces them by the received bytes.
    fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), SpiError>;
}

/// Error: a transfer has failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SpiError;
