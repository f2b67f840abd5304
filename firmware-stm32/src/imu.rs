//! The ISM330DHCX: acceleration at +-2 g and temperature, gyroscope powered down.
//!
//! Output data rate 416 Hz in high-performance mode, low-pass filter LPF2 at a twentieth of it (20.8 Hz), like the 20 Hz second-order
//! characteristic that the replaced sensors state without their digital filter. The part is sampled by the microcontroller's clock;
//! its own oscillator is a few per cent off.
//!
//! A part that is missing or fails costs nothing but samples: it is tried again every second.

use crate::board::Delay;
use crate::counts::{self, Mounting};
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use ism330dhcx_rs::blocking::prelude::{FsXl, HpSlopeXlEn, MainBank, MemBank, OdrXl};
use ism330dhcx_rs::blocking::{
    Error, ISM330DHCX_ID, Ism330dhcx, PROPERTY_DISABLE, PROPERTY_ENABLE,
};
use plumbline::measure::Reading;
use plumbline::time::{Instant, after, millis, reached};
use st_mems_bus::blocking::MemBankFunctions;
use st_mems_bus::blocking::spi::SpiBus;

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

/// The accelerometer on its SPI.
pub struct Imu<S: SpiDevice> {
    part: Ism330dhcx<SpiBus<S>, Delay, MainBank>,
    mounting: Mounting,
    state: State,
    /// The log knows that it is missing.
    reported: bool,
}

impl<S: SpiDevice> Imu<S> {
    /// The part on this SPI, not looked for yet.
    pub fn new(spi: S, mounting: Mounting) -> Self {
        Self {
            part: Ism330dhcx::new_spi(spi, Delay),
            mounting,
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
    fn set_up(&mut self) -> Result<bool, Error<S::Error>> {
        let part = &mut self.part;
        // A disturbance may have left another register bank selected, in which even the identifier is out of reach.
        part.mem_bank_set(MemBank::UserBank)?;
        if part.device_id_get()? != ISM330DHCX_ID {
            return Ok(false);
        }
        part.reset_set(PROPERTY_ENABLE)?;
        let mut attempts = 0;
        while part.reset_get()? != PROPERTY_DISABLE {
            // The datasheet gives it 50 us.
            Delay.delay_us(50);
            attempts += 1;
            if attempts > 20 {
                return Ok(false);
            }
        }
        part.device_conf_set(PROPERTY_ENABLE)?;
        part.block_data_update_set(PROPERTY_ENABLE)?;
        part.xl_full_scale_set(FsXl::_2g)?;
        part.xl_filter_lp2_set(PROPERTY_ENABLE)?;
        part.xl_hp_path_on_out_set(HpSlopeXlEn::LpOdrDiv20)?;
        part.xl_data_rate_set(OdrXl::_416hz)?;
        Ok(true)
    }

    /// Reads the part out; None when it has nothing new or does not answer like itself.
    fn fetch(&mut self) -> Result<Option<Reading>, Error<S::Error>> {
        let status = self.part.status_reg_get()?.into_bits();
        if status & ALIVE_MASK != ALIVE {
            return Ok(None);
        }
        let temperature = self.part.temperature_raw_get()?;
        let acceleration = self.part.acceleration_raw_get()?;
        Ok(Some(counts::reading(
            acceleration,
            temperature,
            self.mounting,
        )))
    }
}
