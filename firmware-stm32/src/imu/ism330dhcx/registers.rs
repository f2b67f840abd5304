//! The registers of the ISM330DHCX: their values, and the transfers that read and write them.

use super::counts;
use super::driver::{Gyroscope, Ism330dhcx};
use crate::board::delay;
use crate::imu::self_test::SetUp;
use crate::imu::{SpiError, Wires};
use ism330dhcx_rs::blocking::ISM330DHCX_ID;
use ism330dhcx_rs::blocking::prelude::{
    BdrGy, BdrXl, Ctrl1Xl, Ctrl2G, Ctrl3C, Ctrl4C, Ctrl5C, Ctrl9Xl, FifoCtrl3, FifoCtrl4, FifoMode,
    FsGy, FsXl, OdrGy, OdrTBatch, OdrXl, Reg, StXl,
};

impl<const TESTS: usize, const GYROSCOPES: usize> Ism330dhcx<TESTS, GYROSCOPES> {
    /// Resets the accelerometer and configures it. Returns false if it does not answer with its identifier. `booted` is true if it is not
    /// in its boot.
    ///
    /// The registers have their reset values, so each is written completely, with the register types of the driver crate. The
    /// functions of the crate would read, modify and write, and also handle the state machine and the machine learning core,
    /// which are off.
    pub(super) fn set_up(&mut self, booted: bool) -> Result<bool, SpiError> {
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
    pub(super) fn change(&mut self, set_up: SetUp) -> Result<(), SpiError> {
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
    pub(super) fn transfer(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
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
pub(super) const READ: u8 = 0x80;
