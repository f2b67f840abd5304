//! The registers of the ISM330DHCX: their values, and the transfers that read and write them.

use super::counts;
use super::driver::{Gyroscope, Ism330dhcx, Trouble};
use crate::board::delay;
use crate::imu::self_test::SetUp;
use crate::imu::values::Values;
use crate::imu::{SpiError, Wires};
use ism330dhcx_rs::blocking::ISM330DHCX_ID;
use ism330dhcx_rs::blocking::prelude::{
    BdrGy, BdrXl, Ctrl1Xl, Ctrl2G, Ctrl3C, Ctrl4C, Ctrl5C, Ctrl9Xl, FifoCtrl3, FifoCtrl4, FifoMode,
    FsGy, FsXl, OdrGy, OdrTBatch, OdrXl, Reg, StXl,
};
use plumbline::time::Instant;

impl<const TESTS: usize, const GYROSCOPES: usize> Ism330dhcx<TESTS, GYROSCOPES> {
    /// Resets the accelerometer, configures it, and compares its registers.
    ///
    /// The registers have their reset values, so each is written completely, with the register types of the driver crate. The
    /// functions of the crate would read, modify and write, and also handle the state machine and the machine learning core,
    /// which are off.
    pub(super) fn configure(&mut self) -> Result<(), Trouble> {
        let identifier = self.read(Reg::WhoAmI)?;
        // Nothing is written while the accelerometer can be in its boot, in which the line is open: FFh, or 0 without a pull-up.
        self.zeros = match identifier {
            0 => self.zeros.saturating_add(1),
            _ => 0,
        };
        if identifier == NOTHING || (1..BOOT_ATTEMPTS).contains(&self.zeros) {
            return Err(Trouble::Silent);
        }
        if identifier != ISM330DHCX_ID {
            // After a disturbance another register bank can be selected, in which the identifier cannot be read.
            self.write(Reg::FuncCfgAccess, 0)?;
            match self.read(Reg::WhoAmI)? {
                ISM330DHCX_ID => {}
                0 | NOTHING => return Err(Trouble::Silent),
                _ => return Err(Trouble::Identity),
            }
        }
        // The gyroscope must be in power-down before a reset (AN5398, section 5.8). After a disturbance it can run in any product.
        self.write(Reg::Ctrl2G, 0)?;
        let reset = Ctrl3C::new().with_sw_reset(1);
        self.write(Reg::Ctrl3C, reset.into_bits())?;
        let mut attempts = 0;
        while Ctrl3C::from_bits(self.read(Reg::Ctrl3C)?).sw_reset() != 0 {
            // The datasheet specifies 50 us.
            delay(50);
            attempts += 1;
            if attempts > 20 {
                return Err(Trouble::Settings);
            }
        }
        for (register, value) in OTHERS.iter().chain(const { &batching(GYROSCOPES) }) {
            self.write(*register, *value)?;
        }
        if let Some(gyroscope) = self.gyroscope.first_mut() {
            *gyroscope = Gyroscope::INITIAL;
        }
        let fine = self.read(Reg::InternalFreqFine)?;
        if self.read(Reg::InternalFreqFine)? != fine {
            return Err(Trouble::Line);
        }
        self.resampler.start(counts::data_rate(fine as i8));
        self.clipped = false;
        self.temperature = None;
        self.tags.restart();
        self.values = Values::INITIAL;
        self.set_up = SetUp::Normal;
        // The last one, CTRL1_XL, starts the accelerometer.
        let controls = Self::controls(SetUp::Normal);
        for (place, value) in controls.into_iter().enumerate().rev() {
            self.wires.transfer(&mut [CONTROLS + place as u8, value])?;
        }
        let read = self.read_controls()?;
        if read[GYROSCOPE] != controls[GYROSCOPE] {
            // The identifier of the IIS2ICLX is the same, but it has no gyroscope.
            return Err(Trouble::Identity);
        }
        for _ in 0..COMPARED {
            self.compare_next()?;
        }
        Ok(())
    }

    /// Compares the control registers and another register with their values.
    ///
    /// This is done before the FIFO is read, so the values in it were measured with these settings.
    pub(super) fn compare(&mut self, now: Instant) {
        match self.compare_next() {
            Ok(true) => {}
            Ok(false) => self.spoil(now),
            Err(trouble) => self.fail(now, trouble),
        }
    }

    /// Compares the control registers, and the next one of the others. Returns false after an error on the line: only the second
    /// comparison was good.
    fn compare_next(&mut self) -> Result<bool, Trouble> {
        let (register, value) = self.expected(self.next);
        self.next = if self.next + 1 < COMPARED {
            self.next + 1
        } else {
            0
        };
        let controls = Self::controls(self.set_up);
        for attempt in 0..2 {
            if self.read_controls()? == controls && self.read(register)? == value {
                return Ok(attempt == 0);
            }
        }
        Err(Trouble::Settings)
    }

    /// A register besides the control registers, and its value.
    fn expected(&self, number: usize) -> (Reg, u8) {
        let batching = const { &batching(GYROSCOPES) };
        let mut all = OTHERS.iter().chain(batching).skip(number);
        all.next().copied().unwrap_or((Reg::WhoAmI, ISM330DHCX_ID))
    }

    /// CTRL1_XL to CTRL8_XL.
    const fn controls(set_up: SetUp) -> [u8; 8] {
        [
            range(set_up),
            gyroscope(GYROSCOPES),
            // Block data update: the two bytes of a value are consistent.
            Ctrl3C::new().with_bdu(1).into_bits(),
            // A disturbance on the lines of the SPI must not look like a start condition of I2C.
            Ctrl4C::new().with_i2c_disable(1).into_bits(),
            push(set_up),
            0,
            0,
            0,
        ]
    }

    /// Reads CTRL1_XL to CTRL8_XL: 36 us.
    fn read_controls(&mut self) -> Result<[u8; 8], SpiError> {
        let mut bytes = [0; 9];
        bytes[0] = CONTROLS | READ;
        self.wires.transfer(&mut bytes)?;
        let [_, controls @ ..] = bytes;
        Ok(controls)
    }

    /// Sets range and self-test.
    pub(super) fn change(&mut self, set_up: SetUp) -> Result<(), SpiError> {
        self.set_up = set_up;
        self.write(Reg::Ctrl5C, push(set_up))?;
        self.write(Reg::Ctrl1Xl, range(set_up))
    }

    fn read(&mut self, register: Reg) -> Result<u8, SpiError> {
        let mut bytes = [register as u8 | READ, 0];
        self.wires.transfer(&mut bytes)?;
        Ok(bytes[1])
    }

    fn write(&mut self, register: Reg, value: u8) -> Result<(), SpiError> {
        self.wires.transfer(&mut [register as u8, value])
    }
}

/// CTRL1_XL: the range, and 833 Hz.
const fn range(set_up: SetUp) -> u8 {
    let range = match set_up {
        SetUp::Normal => FsXl::_8g,
        SetUp::Test { .. } => FsXl::_4g,
    };
    let register = Ctrl1Xl::new().with_fs_xl(range as u8);
    register.with_odr_xl(OdrXl::_833hz as u8).into_bits()
}

/// CTRL5_C: the self-test.
const fn push(set_up: SetUp) -> u8 {
    let push = match set_up {
        SetUp::Test { pushed: true } => StXl::Positive,
        _ => StXl::Disable,
    };
    Ctrl5C::new().with_st_xl(push as u8).into_bits()
}

/// CTRL2_G: 833 Hz, +-1000 deg/s. The range also without a gyroscope in the product: it shows that the part has one.
const fn gyroscope(gyroscopes: usize) -> u8 {
    let rate = match gyroscopes {
        0 => OdrGy::Off,
        _ => OdrGy::_833hz,
    };
    let register = Ctrl2G::new().with_fs_g(FsGy::_1000dps as u8);
    register.with_odr_g(rate as u8).into_bits()
}

/// FIFO_CTRL3: the data rates in the FIFO.
const fn batching(gyroscopes: usize) -> [(Reg, u8); 1] {
    let rate = match gyroscopes {
        0 => BdrGy::NotBatched,
        _ => BdrGy::_833hz,
    };
    let register = FifoCtrl3::new().with_bdr_xl(BdrXl::_833hz as u8);
    [(Reg::FifoCtrl3, register.with_bdr_gy(rate as u8).into_bits())]
}

/// The registers besides the control registers and FIFO_CTRL3, with values that never change.
const OTHERS: [(Reg, u8); 5] = [
    (Reg::Ctrl9Xl, Ctrl9Xl::new().with_device_conf(1).into_bits()),
    (
        Reg::FifoCtrl4,
        FifoCtrl4::new()
            .with_fifo_mode(FifoMode::StreamMode as u8)
            .with_odr_t_batch(OdrTBatch::_52hz as u8)
            .into_bits(),
    ),
    // The reset values.
    (Reg::FifoCtrl1, 0),
    (Reg::FifoCtrl2, 0),
    (Reg::Ctrl10C, 0),
];

/// The number of registers that are compared in turn, with FIFO_CTRL3 and WHO_AM_I.
const COMPARED: usize = OTHERS.len() + 2;

/// The address of CTRL1_XL, the first control register, and the place of CTRL2_G.
const CONTROLS: u8 = Reg::Ctrl1Xl as u8;
const GYROSCOPE: usize = 1;

/// The number of attempts, every 5 ms, in which the accelerometer can be in its boot of 10 ms.
const BOOT_ATTEMPTS: u8 = 4;

/// What is read if nothing answers: the line has a pull-up.
const NOTHING: u8 = 0xFF;

/// Bit of the address byte: read.
pub(super) const READ: u8 = 0x80;
