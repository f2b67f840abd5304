//! The driver of the ISM330DHCX: acceleration at +-2 g and temperature, gyroscope powered down.
//!
//! Output data rate 416 Hz in high-performance mode, low-pass filter LPF2 at 1/20 of it (20.8 Hz). The original sensors specify a
//! 20 Hz second-order characteristic without their digital filter. The microcontroller clock determines the sampling, because the
//! oscillator of the accelerometer has an error of some per cent.
//!
//! A reading is one transfer of 17 bytes, divided into pieces ([`Imu::step`]). Between two pieces the main loop handles frames.
//!
//! During the self-test ([`self_test`](crate::self_test)) the last acceleration before it is used.
//!
//! If the accelerometer is missing or fails, there are no samples, and the driver tries to find it every second.

use crate::board::{Delay, ImuWires, MOUNTING};
use crate::counts::{self, TRANSFER};
use crate::self_test::{SelfTest, SetUp, Step};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiBus;
use ism330dhcx_rs::blocking::prelude::{
    Ctrl1Xl, Ctrl3C, Ctrl5C, Ctrl8Xl, Ctrl9Xl, FsXl, HpSlopeXlEn, MainBank, MemBank, OdrXl, Reg,
    StXl,
};
use ism330dhcx_rs::blocking::{Error, ISM330DHCX_ID, Ism330dhcx};
use plumbline::measure::Reading;
use plumbline::measure::self_test::Working;
use plumbline::time::{Instant, after, millis, reached};
use st_mems_bus::blocking::{BusOperation, MemBankFunctions, RegisterOperation};

/// The time between attempts to find the accelerometer, in ms.
const RETRY_MS: u32 = 1000;

/// The time between attempts after power-up, in ms: the accelerometer does not answer during its boot of 10 ms.
const BOOT_RETRY_MS: u32 = 10;

/// The end of the shorter interval: 100 ms after power-up.
const BOOT_END: Instant = Instant::from_ticks(100_000);

/// The number of samples to skip after configuration: 100 ms, in which the accelerometer turns on and LPF2 settles.
const SETTLING_SAMPLES: u8 = 20;

/// The number of consecutive samples without new data after which the accelerometer has failed: 50 ms. It delivers two values per
/// sample.
const MISSES: u8 = 10;

/// The number of bytes exchanged in one step: 4 us.
const PIECE: usize = 4;

enum State {
    /// Not found, or lost. The next attempt is at `retry`.
    Absent { retry: Instant },
    /// Configured. `settling`: samples still to skip; `misses`: consecutive missed samples.
    Running { settling: u8, misses: u8 },
}

/// A running transfer.
struct Transfer {
    /// The bytes to send, replaced by the received ones.
    bytes: [u8; TRANSFER],
    /// The number of pieces exchanged.
    pieces: usize,
}

/// The accelerometer.
pub struct Imu {
    part: Ism330dhcx<ImuWires, Delay, MainBank>,
    state: State,
    transfer: Option<Transfer>,
    /// The running self-test.
    test: Option<SelfTest>,
    /// The result of the last self-test, until it is read.
    tested: Option<Working>,
    /// The missing accelerometer is logged.
    reported: bool,
}

impl Imu {
    /// The driver for the accelerometer on this bus, before the first attempt to find it.
    pub fn new(wires: ImuWires) -> Self {
        Self {
            part: Ism330dhcx::from_bus(wires, Delay),
            state: State::Absent {
                retry: Instant::from_ticks(0),
            },
            transfer: None,
            test: None,
            tested: None,
            reported: false,
        }
    }

    /// Begins a self-test. [`tested`](Self::tested) returns the result after about 2 s. A running self-test begins again.
    pub fn test(&mut self) {
        self.test = Some(SelfTest::begin());
    }

    /// The result of a finished self-test, once.
    pub fn tested(&mut self) -> Option<Working> {
        self.tested.take()
    }

    /// Begins a reading, or tries to find a missing accelerometer. Call it once per sample period.
    pub fn start(&mut self, now: Instant) {
        if matches!(self.state, State::Absent { .. }) && self.test.take().is_some() {
            self.tested = Some(Working::default());
        }
        match self.state {
            State::Absent { retry } if reached(now, retry) => self.state = self.find(now),
            State::Absent { .. } => {}
            State::Running { .. } => {
                self.part.bus.begin();
                let mut bytes = [0; TRANSFER];
                bytes[0] = Reg::StatusRegOrSpiaux as u8 | READ;
                self.transfer = Some(Transfer { bytes, pieces: 0 });
            }
        }
    }

    /// True while a reading is running.
    pub fn busy(&self) -> bool {
        self.transfer.is_some()
    }

    /// Performs one step of a reading: a piece of its transfer, or its evaluation. Returns the reading at the end, unless the
    /// accelerometer is missing or settling.
    pub fn step(&mut self, now: Instant) -> Option<Reading> {
        let transfer = self.transfer.as_mut()?;
        let reading = match transfer.bytes.chunks_mut(PIECE).nth(transfer.pieces) {
            Some(piece) => {
                if self.part.bus.exchange(piece).is_ok() {
                    transfer.pieces += 1;
                    return None;
                }
                None
            }
            None => counts::transferred(&transfer.bytes, MOUNTING),
        };
        self.part.bus.end();
        self.transfer = None;
        self.judge(now, reading)
    }

    /// Counts valid and missed readings. Returns the reading, unless the accelerometer is settling.
    fn judge(&mut self, now: Instant, reading: Option<Reading>) -> Option<Reading> {
        let State::Running { settling, misses } = self.state else {
            return None;
        };
        self.state = match reading {
            Some(_) => State::Running {
                settling: settling.saturating_sub(1),
                misses: 0,
            },
            None if misses < MISSES => State::Running {
                settling,
                misses: misses + 1,
            },
            None => self.absent(now),
        };
        let reading = reading.filter(|_| settling == 0)?;
        if self.test.is_some() {
            return self.carry_test_on(now, reading);
        }
        Some(reading)
    }

    /// Performs one step of the self-test while no transfer is running. Returns the reading for the node.
    #[inline(never)] // rarely called
    fn carry_test_on(&mut self, now: Instant, reading: Reading) -> Option<Reading> {
        let test = self.test.as_mut()?;
        let step = test.step(reading.acceleration);
        let reading = Reading {
            acceleration: test.held(),
            clipped: false,
            ..reading
        };
        match step {
            Step::None => {}
            Step::SetUp(set_up) if self.change(set_up).is_ok() => {}
            Step::SetUp(_) => self.state = self.absent(now),
            Step::Done(working) => {
                info!("self-test: {}", working);
                self.test = None;
                self.tested = Some(working);
            }
        }
        Some(reading)
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
                    settling: SETTLING_SAMPLES,
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
        Ctrl8Xl::new()
            .with_hpcf_xl(HpSlopeXlEn::LpOdrDiv20 as u8)
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
            .with_lpf2_xl_en(1)
            .with_fs_xl(range as u8)
            .with_odr_xl(OdrXl::_416hz as u8)
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
