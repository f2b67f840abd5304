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

use crate::board::{ImuWires, MOUNTING, delay};
use crate::counts::{self, FRACTION, WORD, Word};
use crate::self_test::{self, SelfTest, SetUp};
use ism330dhcx_rs::blocking::ISM330DHCX_ID;
use ism330dhcx_rs::blocking::prelude::{
    BdrGy, BdrXl, Ctrl1Xl, Ctrl2G, Ctrl3C, Ctrl4C, Ctrl5C, Ctrl9Xl, FifoCtrl3, FifoCtrl4, FifoMode,
    FsGy, FsXl, OdrGy, OdrTBatch, OdrXl, Reg, StXl,
};
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::self_test::Working;
use plumbline::measure::{I32x3, Reading};
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

/// The number of consecutive samples without an angular rate after which the gyroscope has failed: 200 ms. It turns on within 35 ms.
const SILENT_SAMPLES: u8 = 40;

/// The time after a failed attempt until which the accelerometer can be in its boot of 10 ms, in ms. Then nothing is written to it.
const BOOT_MS: u32 = 15;

enum State {
    /// Not found, or lost. The next attempt is at `retry`. `failed` is the time of the first attempt that has failed.
    Absent {
        retry: Instant,
        failed: Option<Instant>,
    },
    /// Configured. `settling`: values still to skip; `misses`: consecutive readings of the FIFO without a value.
    Running { settling: u8, misses: u8 },
}

/// The next step of reading the FIFO.
#[derive(Clone, Copy)]
enum Step {
    /// Nothing: the FIFO is not read.
    None,
    /// Read the number of words.
    Level,
    /// Exchange the first half of a word: 4 us.
    FirstHalf,
    /// Exchange the second half.
    SecondHalf,
    /// Evaluate the word.
    Evaluate,
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

    /// True while the FIFO is read.
    pub fn busy(&self) -> bool {
        !matches!(self.step, Step::None)
    }

    /// Performs one step of reading the FIFO. Returns a reading if one is complete, unless the accelerometer is missing or
    /// settling.
    pub fn step(&mut self, now: Instant) -> Option<Reading> {
        let (first, second) = self.bytes.split_at_mut(WORD / 2);
        match self.step {
            Step::None => return None,
            Step::Level => self.words = self.level(),
            Step::FirstHalf => {
                self.wires.select(true);
                let sent = self.wires.exchange(first);
                self.step = Step::SecondHalf;
                return self.skip(sent.is_err());
            }
            Step::SecondHalf => {
                let sent = self.wires.exchange(second);
                self.wires.select(false);
                self.step = Step::Evaluate;
                return self.skip(sent.is_err());
            }
            Step::Evaluate => self.words -= 1,
        }
        let bytes = self.bytes;
        let evaluates = matches!(self.step, Step::Evaluate);
        self.bytes = [0; WORD];
        self.bytes[0] = Reg::FifoDataOutTag as u8 | READ;
        self.step = match self.words {
            0 => Step::None,
            _ => Step::FirstHalf,
        };
        if evaluates {
            self.take(now, &bytes)
        } else {
            None
        }
    }

    /// After a failure of the SPI: ends the transfer and the reading of the FIFO.
    fn skip(&mut self, failed: bool) -> Option<Reading> {
        if failed {
            self.wires.select(false);
            self.step = Step::None;
        }
        None
    }

    /// The number of words in the FIFO.
    fn level(&mut self) -> u16 {
        let mut bytes = [Reg::FifoStatus1 as u8 | READ, 0, 0];
        match self.transfer(&mut bytes) {
            Ok(()) => {
                let status = [bytes[1], bytes[2]];
                self.check_loss(status);
                counts::level(status)
            }
            Err(_) => 0,
        }
    }

    /// The rotation in lost values is not known, and a reading must not have values from before and after the gap.
    fn check_loss(&mut self, status: [u8; 2]) {
        if let Some(gyroscope) = self.gyroscope.first_mut()
            && counts::has_lost(status)
        {
            *gyroscope = Gyroscope {
                lost: true,
                ..Gyroscope::INITIAL
            };
            self.resampler.restart();
        }
    }

    /// Returns true once if values were lost before the last reading.
    pub fn lost(&mut self) -> bool {
        let gyroscope = self.gyroscope.first_mut();
        gyroscope.is_some_and(|gyroscope| core::mem::take(&mut gyroscope.lost))
    }

    /// Processes a word. Returns a reading if one is complete.
    fn take(&mut self, now: Instant, bytes: &[u8; WORD]) -> Option<Reading> {
        if let Some(gyroscope) = self.gyroscope.first_mut()
            && let Some(counts) = counts::rate_word(bytes)
        {
            gyroscope.rate.push(counts);
            return None;
        }
        let counts = match counts::word(bytes) {
            Word::Acceleration(counts) => counts,
            Word::Temperature(temperature) => {
                self.temperature = Some(temperature);
                return None;
            }
            Word::Other => return None,
        };
        let State::Running { settling, misses } = &mut self.state else {
            return None;
        };
        *misses = 0;
        if *settling > 0 {
            *settling -= 1;
            return None;
        }
        self.clipped |= counts::is_clipped(counts);
        let output = self.resampler.push(counts)?;
        let rate = self.angular_rate(now);
        let mut reading = Reading {
            acceleration: counts::acceleration(output, MOUNTING),
            temperature: self.temperature?,
            clipped: core::mem::take(&mut self.clipped),
            ..Reading::default()
        };
        if GYROSCOPES > 0 {
            reading.angular_rate = rate?;
        }
        if self.running_test().is_some() {
            return self.carry_test_on(now, reading);
        }
        Some(reading)
    }

    /// The mean angular rate up to the last output of the resampler. None if there is none yet, or no gyroscope.
    fn angular_rate(&mut self, now: Instant) -> Option<I32x3> {
        let gyroscope = self.gyroscope.first_mut()?;
        let Some(mean) = gyroscope.rate.take(&self.resampler) else {
            gyroscope.silent += 1;
            if gyroscope.silent >= SILENT_SAMPLES {
                self.absent(now);
            }
            return None;
        };
        gyroscope.silent = 0;
        Some(counts::angular_rate(mean, MOUNTING))
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

    /// Resets the accelerometer and configures it. Returns false if it does not answer with its identifier. `booted` is true if it is not
    /// in its boot.
    ///
    /// The registers have their reset values, so each is written completely, with the register types of the driver crate. The
    /// functions of the crate would read, modify and write, and also handle the state machine and the machine learning core,
    /// which are off.
    fn set_up(&mut self, booted: bool) -> Result<bool, SpiError> {
        if self.read(Reg::WhoAmI)? != ISM330DHCX_ID {
            if !booted {
                return Ok(false);
            }
            // After a disturbance another register bank can be selected, in which the identifier cannot be read.
            self.write(Reg::FuncCfgAccess, 0)?;
            if self.read(Reg::WhoAmI)? != ISM330DHCX_ID {
                return Ok(false);
            }
        }
        let reset = Ctrl3C::new().with_sw_reset(1);
        self.write(Reg::Ctrl3C, reset.into_bits())?;
        let mut attempts = 0;
        while Ctrl3C::from_bits(self.read(Reg::Ctrl3C)?).sw_reset() != 0 {
            // The datasheet specifies 50 us.
            delay(50);
            attempts += 1;
            if attempts > 20 {
                return Ok(false);
            }
        }
        for (register, value) in const { settings(GYROSCOPES) } {
            self.write(register, value)?;
        }
        if let Some(gyroscope) = self.gyroscope.first_mut() {
            *gyroscope = Gyroscope::INITIAL;
            self.write(Reg::Ctrl2G, GYROSCOPE_ON)?;
        }
        let fine = self.read(Reg::InternalFreqFine)? as i8;
        self.resampler.start(counts::data_rate(fine));
        self.clipped = false;
        self.temperature = None;
        self.change(SetUp::Normal)?;
        Ok(true)
    }

    /// Sets range and self-test.
    fn change(&mut self, set_up: SetUp) -> Result<(), SpiError> {
        let (range, push) = match set_up {
            SetUp::Normal => (FsXl::_8g, StXl::Disable),
            SetUp::Test { pushed: false } => (FsXl::_4g, StXl::Disable),
            SetUp::Test { pushed: true } => (FsXl::_4g, StXl::Positive),
        };
        let push = Ctrl5C::new().with_st_xl(push as u8);
        self.write(Reg::Ctrl5C, push.into_bits())?;
        let range = Ctrl1Xl::new()
            .with_fs_xl(range as u8)
            .with_odr_xl(OdrXl::_833hz as u8);
        self.write(Reg::Ctrl1Xl, range.into_bits())
    }

    /// A complete transfer.
    fn transfer(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
        self.wires.select(true);
        let result = self.wires.exchange(bytes);
        self.wires.select(false);
        result
    }

    fn read(&mut self, register: Reg) -> Result<u8, SpiError> {
        let mut bytes = [register as u8 | READ, 0];
        self.transfer(&mut bytes)?;
        Ok(bytes[1])
    }

    fn write(&mut self, register: Reg, value: u8) -> Result<(), SpiError> {
        self.transfer(&mut [register as u8, value])
    }
}

/// The registers that never change after a reset of the accelerometer.
const fn settings(gyroscopes: usize) -> [(Reg, u8); 5] {
    let rate = match gyroscopes {
        0 => BdrGy::NotBatched,
        _ => BdrGy::_833hz,
    };
    [
        (Reg::Ctrl9Xl, Ctrl9Xl::new().with_device_conf(1).into_bits()),
        // A disturbance on the lines of the SPI must not look like a start condition of I2C.
        (Reg::Ctrl4C, Ctrl4C::new().with_i2c_disable(1).into_bits()),
        // Block data update: the two bytes of a value are consistent.
        (Reg::Ctrl3C, Ctrl3C::new().with_bdu(1).into_bits()),
        (
            Reg::FifoCtrl3,
            FifoCtrl3::new()
                .with_bdr_xl(BdrXl::_833hz as u8)
                .with_bdr_gy(rate as u8)
                .into_bits(),
        ),
        (
            Reg::FifoCtrl4,
            FifoCtrl4::new()
                .with_fifo_mode(FifoMode::StreamMode as u8)
                .with_odr_t_batch(OdrTBatch::_52hz as u8)
                .into_bits(),
        ),
    ]
}

/// CTRL2_G: 833 Hz, +-1000 deg/s.
const GYROSCOPE_ON: u8 = Ctrl2G::new()
    .with_fs_g(FsGy::_1000dps as u8)
    .with_odr_g(OdrGy::_833hz as u8)
    .into_bits();

/// Bit of the address byte: read.
const READ: u8 = 0x80;

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
