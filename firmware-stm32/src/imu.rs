//! The driver of the ISM330DHCX: acceleration at +-2 g and temperature, gyroscope powered down.
//!
//! The accelerometer runs at 833 Hz in high-performance mode without LPF2. Each value goes into its FIFO, so none is lost or read
//! twice, although its oscillator has an error of some per cent, and none is lost while the flash stalls the processor. Every 5 ms
//! the driver reads the FIFO, and a [`Resampler`] converts the values to readings at 200 Hz. It takes the data rate from
//! INTERNAL_FREQ_FINE, in which the accelerometer states the error of its oscillator.
//!
//! The number of words in the FIFO and each word are transfers of their own, a word in two halves ([`Imu::step`]). Between two
//! halves the main loop handles frames.
//!
//! During the self-test ([`self_test`](crate::self_test)) the last acceleration before it is used.
//!
//! If the accelerometer is missing or fails, there are no samples, and the driver tries to find it every second.

use crate::board::{Delay, ImuWires, MOUNTING};
use crate::counts::{self, FRACTION, WORD, Word};
use crate::self_test::{self, SelfTest, SetUp};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiBus;
use ism330dhcx_rs::blocking::prelude::{
    BdrXl, Ctrl1Xl, Ctrl3C, Ctrl5C, Ctrl9Xl, FifoCtrl3, FifoCtrl4, FifoMode, FsXl,
    InternalFreqFine, MainBank, MemBank, OdrTBatch, OdrXl, Reg, StXl,
};
use ism330dhcx_rs::blocking::{Error, ISM330DHCX_ID, Ism330dhcx};
use plumbline::measure::Reading;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::self_test::Working;
use plumbline::time::{Instant, after, millis, reached};
use st_mems_bus::blocking::{BusOperation, MemBankFunctions, RegisterOperation};

/// The time between attempts to find the accelerometer, in ms.
const RETRY_MS: u32 = 1000;

/// The time between attempts after power-up, in ms: the accelerometer does not answer during its boot of 10 ms.
const BOOT_RETRY_MS: u32 = 10;

/// The end of the shorter interval: 100 ms after power-up.
const BOOT_END: Instant = Instant::from_ticks(100_000);

/// The number of values to skip after configuration: 19 ms, in which the accelerometer turns on.
const SETTLING_VALUES: u8 = 16;

/// The number of consecutive readings of the FIFO without a value after which the accelerometer has failed: 50 ms.
const MISSES: u8 = 10;

enum State {
    /// Not found, or lost. The next attempt is at `retry`.
    Absent { retry: Instant },
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

/// The accelerometer. `TESTS` is 1 if the product has the self-test, otherwise 0; then the image does not contain it.
pub struct Imu<const TESTS: usize> {
    part: Ism330dhcx<ImuWires, Delay, MainBank>,
    state: State,
    step: Step,
    /// The number of words to read, with the present one.
    words: u16,
    /// The present word: the bytes to send, replaced by the received ones.
    bytes: [u8; WORD],
    resampler: Resampler<i16, FRACTION>,
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

impl<const TESTS: usize> Imu<TESTS> {
    /// The driver for the accelerometer on this bus, before the first attempt to find it.
    pub fn new(wires: ImuWires) -> Self {
        Self {
            part: Ism330dhcx::from_bus(wires, Delay),
            state: State::Absent {
                retry: Instant::from_ticks(0),
            },
            step: Step::None,
            words: 0,
            bytes: [0; WORD],
            resampler: Resampler::new(),
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
            State::Absent { retry } if reached(now, retry) => self.state = self.find(now),
            State::Absent { .. } => {}
            State::Running { misses, .. } if misses >= MISSES => self.state = self.absent(now),
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
                self.part.bus.begin();
                let sent = self.part.bus.exchange(first);
                self.step = Step::SecondHalf;
                return self.skip(sent.is_err());
            }
            Step::SecondHalf => {
                let sent = self.part.bus.exchange(second);
                self.part.bus.end();
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
            self.part.bus.end();
            self.step = Step::None;
        }
        None
    }

    /// The number of words in the FIFO.
    fn level(&mut self) -> u16 {
        let mut status = [0; 2];
        let address = Reg::FifoStatus1 as u8;
        match self.part.bus.write_byte_read_bytes(&[address], &mut status) {
            Ok(()) => counts::level(status),
            Err(_) => 0,
        }
    }

    /// Processes a word. Returns a reading if one is complete.
    fn take(&mut self, now: Instant, bytes: &[u8; WORD]) -> Option<Reading> {
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
        let reading = Reading {
            acceleration: counts::acceleration(output, MOUNTING),
            temperature: self.temperature?,
            clipped: core::mem::take(&mut self.clipped),
            ..Reading::default()
        };
        if self.running_test().is_some() {
            return self.carry_test_on(now, reading);
        }
        Some(reading)
    }

    /// Performs one step of the self-test while no transfer is running. Returns the reading for the node.
    #[inline(never)] // rarely called
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
            self_test::Step::SetUp(_) => self.state = self.absent(now),
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

    fn absent(&mut self, now: Instant) -> State {
        if !self.reported && reached(now, BOOT_END) {
            warn!("no accelerometer");
            self.reported = true;
        }
        let pause = if reached(now, BOOT_END) {
            RETRY_MS
        } else {
            BOOT_RETRY_MS
        };
        State::Absent {
            retry: after(now, millis(pause)),
        }
    }

    /// Tries to find the accelerometer and configures it.
    #[inline(never)] // rarely called, and its stack frame would be part of that of the main loop
    fn find(&mut self, now: Instant) -> State {
        match self.set_up() {
            Ok(true) => {
                info!("accelerometer found");
                self.reported = false;
                State::Running {
                    settling: SETTLING_VALUES,
                    misses: 0,
                }
            }
            _ => self.absent(now),
        }
    }

    /// Resets the accelerometer and configures it. Returns false if it does not answer with its identifier.
    ///
    /// The registers have their reset values, so each is written completely with the register types of the driver crate. The
    /// setters of the crate would read, modify and write, and also handle the state machine and the machine learning core, which
    /// are off.
    fn set_up(&mut self) -> Result<bool, Error<<ImuWires as BusOperation>::Error>> {
        let part = &mut self.part;
        // After a disturbance another register bank can be selected, in which the identifier cannot be read.
        part.mem_bank_set(MemBank::UserBank)?;
        if part.device_id_get()? != ISM330DHCX_ID {
            return Ok(false);
        }
        Ctrl3C::new().with_sw_reset(1).write(part)?;
        let mut attempts = 0;
        while Ctrl3C::read(part)?.sw_reset() != 0 {
            // The datasheet specifies 50 us.
            Delay.delay_us(50);
            attempts += 1;
            if attempts > 20 {
                return Ok(false);
            }
        }
        Ctrl9Xl::new().with_device_conf(1).write(part)?;
        // Block data update: the two bytes of a value are consistent.
        Ctrl3C::new().with_bdu(1).write(part)?;
        let fine = InternalFreqFine::read(part)?.freq_fine();
        self.resampler.start(counts::data_rate(fine));
        self.clipped = false;
        self.temperature = None;
        FifoCtrl3::new()
            .with_bdr_xl(BdrXl::_833hz as u8)
            .write(part)?;
        FifoCtrl4::new()
            .with_fifo_mode(FifoMode::StreamMode as u8)
            .with_odr_t_batch(OdrTBatch::_52hz as u8)
            .write(part)?;
        self.change(SetUp::Normal)?;
        Ok(true)
    }

    /// Sets range and self-test.
    fn change(&mut self, set_up: SetUp) -> Result<(), Error<<ImuWires as BusOperation>::Error>> {
        let (range, push) = match set_up {
            SetUp::Normal => (FsXl::_2g, StXl::Disable),
            SetUp::Test { pushed: false } => (FsXl::_4g, StXl::Disable),
            SetUp::Test { pushed: true } => (FsXl::_4g, StXl::Positive),
        };
        Ctrl5C::new().with_st_xl(push as u8).write(&mut self.part)?;
        Ctrl1Xl::new()
            .with_fs_xl(range as u8)
            .with_odr_xl(OdrXl::_833hz as u8)
            .write(&mut self.part)
    }
}

/// Bit of the address byte: read.
const READ: u8 = 0x80;

/// The SPI (mode 0 or 3, at most 10 MHz) and the chip select of the accelerometer.
pub struct Wires<S, C> {
    spi: S,
    select: C,
}

impl<S: SpiBus, C: OutputPin<Error = Infallible>> Wires<S, C> {
    /// The SPI and the chip select, which must be high.
    pub fn new(spi: S, select: C) -> Self {
        Self { spi, select }
    }

    /// Begins a transfer.
    fn begin(&mut self) {
        let Ok(()) = self.select.set_low();
    }

    /// Sends `bytes` and replaces them by the received bytes.
    fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), S::Error> {
        self.spi.transfer_in_place(bytes)?;
        self.spi.flush()
    }

    /// Sends `bytes` with the same operation as a read.
    fn write(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        bytes
            .iter()
            .try_for_each(|&byte| self.exchange(&mut [byte]))
    }

    /// Ends the transfer.
    fn end(&mut self) {
        let Ok(()) = self.select.set_high();
    }

    /// A complete transfer.
    fn transfer(
        &mut self,
        f: impl FnOnce(&mut Self) -> Result<(), S::Error>,
    ) -> Result<(), S::Error> {
        self.begin();
        let result = f(self);
        self.end();
        result
    }
}

impl<S: SpiBus, C: OutputPin<Error = Infallible>> BusOperation for Wires<S, C> {
    type Error = S::Error;

    fn read_bytes(&mut self, bytes: &mut [u8]) -> Result<(), S::Error> {
        self.transfer(|wires| wires.exchange(bytes))
    }

    fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        self.transfer(|wires| wires.write(bytes))
    }

    fn write_byte_read_bytes(&mut self, byte: &[u8; 1], bytes: &mut [u8]) -> Result<(), S::Error> {
        let [register] = byte;
        self.transfer(|wires| {
            wires.exchange(&mut [register | READ])?;
            wires.exchange(bytes)
        })
    }

    // The default copies into a buffer of 257 bytes on the stack.
    fn write_to_register(&mut self, register: u8, bytes: &[u8]) -> Result<(), S::Error> {
        self.transfer(|wires| {
            wires.exchange(&mut [register])?;
            wires.write(bytes)
        })
    }
}
