//! The ISM330DHCX: acceleration at +-2 g and temperature, gyroscope powered down.
//!
//! Output data rate 416 Hz in high-performance mode, low-pass filter LPF2 at a twentieth of it (20.8 Hz), like the 20 Hz second-order
//! characteristic that the replaced sensors state without their digital filter. The part is sampled by the microcontroller's clock;
//! its own oscillator is a few per cent off.
//!
//! A part that is missing or fails costs nothing but samples: it is tried again every second.

use crate::board::{Delay, MOUNTING};
use crate::counts;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiBus;
use ism330dhcx_rs::blocking::prelude::{
    Ctrl1Xl, Ctrl3C, Ctrl8Xl, Ctrl9Xl, FsXl, HpSlopeXlEn, MainBank, MemBank, OdrXl,
};
use ism330dhcx_rs::blocking::{Error, ISM330DHCX_ID, Ism330dhcx};
use plumbline::measure::Reading;
use plumbline::time::{Instant, after, millis, reached};
use st_mems_bus::blocking::{BusOperation, MemBankFunctions, RegisterOperation};

/// Between attempts to find the part.
const RETRY_MS: u32 = 1000;

/// Samples left out after the part was set up: 100 ms, in which it turns on and LPF2 settles.
const SETTLING_SAMPLES: u8 = 20;

/// Samples in a row without new data after which the part counts as failed: 50 ms. It delivers two per sample.
const MISSES: u8 = 10;

/// STATUS_REG of a part that is alive: new acceleration, gyroscope off, the upper bits always 0. The temperature bit may be
/// either. A bus that is stuck reads as 00h or FFh and a part that lost power as 00h.
const ALIVE: u8 = 0b0000_0001;
const ALIVE_MASK: u8 = 0b1111_1011;

enum State {
    /// Not found, or lost; try again then.
    Absent { retry: Instant },
    /// Set up; samples still to leave out, samples missed in a row.
    Running { settling: u8, misses: u8 },
}

/// The accelerometer.
pub struct Imu<W: BusOperation> {
    part: Ism330dhcx<W, Delay, MainBank>,
    state: State,
    /// The log knows that it is missing.
    reported: bool,
}

impl<W: BusOperation> Imu<W> {
    /// The part at the end of these wires, not looked for yet.
    pub fn new(wires: W) -> Self {
        Self {
            part: Ism330dhcx::from_bus(wires, Delay),
            state: State::Absent {
                retry: Instant::from_ticks(0),
            },
            reported: false,
        }
    }

    /// The reading for this moment; None while the part is missing or settling. Call it once per sample period.
    pub fn read(&mut self, now: Instant) -> Option<Reading> {
        match self.state {
            State::Absent { retry } => {
                if reached(now, retry) {
                    self.state = self.find(now);
                }
                None
            }
            State::Running { settling, misses } => {
                let reading = self.fetch().ok().flatten();
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
                reading.filter(|_| settling == 0)
            }
        }
    }

    fn absent(&mut self, now: Instant) -> State {
        if !self.reported {
            warn!("no accelerometer");
            self.reported = true;
        }
        State::Absent {
            retry: after(now, millis(RETRY_MS)),
        }
    }

    /// Looks for the part and sets it up.
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

    /// Resets the part and sets it up; false when something else, or nothing, answers.
    ///
    /// The registers have their reset values, so each is written whole, through the driver's register types. Its setters would
    /// read, modify and write, and look after the part's state machine and learning core, which are off.
    fn set_up(&mut self) -> Result<bool, Error<W::Error>> {
        let part = &mut self.part;
        // A disturbance may have left another register bank selected, in which even the identifier is out of reach.
        part.mem_bank_set(MemBank::UserBank)?;
        if part.device_id_get()? != ISM330DHCX_ID {
            return Ok(false);
        }
        Ctrl3C::new().with_sw_reset(1).write(part)?;
        let mut attempts = 0;
        while Ctrl3C::read(part)?.sw_reset() != 0 {
            // The datasheet gives it 50 us.
            Delay.delay_us(50);
            attempts += 1;
            if attempts > 20 {
                return Ok(false);
            }
        }
        Ctrl9Xl::new().with_device_conf(1).write(part)?;
        // Block data update: the two bytes of a value belong together.
        Ctrl3C::new().with_bdu(1).write(part)?;
        Ctrl8Xl::new()
            .with_hpcf_xl(HpSlopeXlEn::LpOdrDiv20 as u8)
            .write(part)?;
        Ctrl1Xl::new()
            .with_lpf2_xl_en(1)
            .with_fs_xl(FsXl::_2g as u8)
            .with_odr_xl(OdrXl::_416hz as u8)
            .write(part)?;
        Ok(true)
    }

    /// Reads the part out; None when it has nothing new or does not answer like itself.
    fn fetch(&mut self) -> Result<Option<Reading>, Error<W::Error>> {
        let status = self.part.status_reg_get()?.into_bits();
        if status & ALIVE_MASK != ALIVE {
            return Ok(None);
        }
        let temperature = self.part.temperature_raw_get()?;
        let acceleration = self.part.acceleration_raw_get()?;
        Ok(Some(counts::reading(acceleration, temperature, MOUNTING)))
    }
}

/// The part's SPI (mode 0 or 3, at most 10 MHz) and its chip select.
pub struct Wires<S, C> {
    spi: S,
    select: C,
}

impl<S: SpiBus, C: OutputPin<Error = Infallible>> Wires<S, C> {
    /// The part's bus and its chip select, which is high.
    pub fn new(spi: S, select: C) -> Self {
        Self { spi, select }
    }

    /// One transfer of the part: its chip select low around what `f` does.
    fn select(&mut self, f: impl FnOnce(&mut S) -> Result<(), S::Error>) -> Result<(), S::Error> {
        let Ok(()) = self.select.set_low();
        let result = f(&mut self.spi).and_then(|()| self.spi.flush());
        let Ok(()) = self.select.set_high();
        result
    }
}

impl<S: SpiBus, C: OutputPin<Error = Infallible>> BusOperation for Wires<S, C> {
    type Error = S::Error;

    fn read_bytes(&mut self, bytes: &mut [u8]) -> Result<(), S::Error> {
        self.select(|spi| spi.transfer_in_place(bytes))
    }

    fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        self.select(|spi| write(spi, bytes))
    }

    fn write_byte_read_bytes(&mut self, byte: &[u8; 1], bytes: &mut [u8]) -> Result<(), S::Error> {
        /// The upper bit of the address byte.
        const READ: u8 = 0x80;
        let [register] = byte;
        self.select(|spi| {
            spi.transfer_in_place(&mut [register | READ])?;
            spi.transfer_in_place(bytes)
        })
    }

    // The default copies into a buffer of 257 bytes on the stack.
    fn write_to_register(&mut self, register: u8, bytes: &[u8]) -> Result<(), S::Error> {
        self.select(|spi| {
            spi.transfer_in_place(&mut [register])?;
            write(spi, bytes)
        })
    }
}

/// Writes through the one operation that reading needs too.
fn write<S: SpiBus>(spi: &mut S, bytes: &[u8]) -> Result<(), S::Error> {
    bytes
        .iter()
        .try_for_each(|&byte| spi.transfer_in_place(&mut [byte]))
}
