//! The registers of the ADXL355: their values, and the transfers that read and write them.

use super::counts::{self, STATE};
use super::driver::Adxl355;
use crate::imu::self_test::SetUp;
use crate::imu::{SpiError, Wires};
use adi_adxl355::{DEVICE_ID, Odr, Range, Register};

/// DEVID_AD, DEVID_MST and PARTID.
const IDENTITY: [u8; 3] = [0xAD, 0x1D, DEVICE_ID];

/// The value of RESET that resets the part.
const RESET_CODE: u8 = 0x52;

/// Bit of the address byte: read.
const READ: u8 = 1;

/// Bits of SELF_TEST: the mode, and the force.
const TEST_MODE: u8 = 1 << 0;
const TEST_FORCE: u8 = 1 << 1;

/// FILTER to INT_MAP, SYNC, and RANGE with the reset value of its upper bits. The FIFO holds 96 entries.
const SETTINGS: [(Register, u8); 5] = [
    (Register::FILTER, Odr::_1000Hz.val()),
    (Register::FIFO_SAMPLES, 96),
    (Register::INT_MAP, 0),
    (Register::SYNC, 0),
    (Register::RANGE, 1 << 7 | Range::_8G.val()),
];

/// What OFFSET_X to SELF_TEST read as, ACT_COUNT (0) and SELF_TEST (0) apart.
const EXPECTED: [u8; CONFIGURATION] = [
    0,
    0,
    0,
    0,
    0,
    0, // OFFSET_X, OFFSET_Y, OFFSET_Z
    0,
    0,
    0,
    0, // ACT_EN, ACT_THRESH, ACT_COUNT
    SETTINGS[0].1,
    SETTINGS[1].1,
    SETTINGS[2].1,
    SETTINGS[3].1,
    SETTINGS[4].1, // FILTER to RANGE
    0,
    0, // POWER_CTL, SELF_TEST
];

/// The number of registers from OFFSET_X to SELF_TEST.
const CONFIGURATION: usize = (Register::SELF_TEST as u8 - Register::OFFSET_X_H as u8 + 1) as usize;

/// The place of ACT_COUNT in them, which has no effect.
const ACT_COUNT: usize = (Register::ACT_COUNT as u8 - Register::OFFSET_X_H as u8) as usize;

/// The shadow registers.
pub(super) type Shadows = [u8; 5];

impl<const TESTS: usize> Adxl355<TESTS> {
    /// Whether the part answers with its identity.
    pub(super) fn identifies(&mut self) -> Result<bool, SpiError> {
        Ok(self.read(Register::DEVID_AD)? == IDENTITY)
    }

    /// Resets the part, which takes some milliseconds. Returns the shadow registers before the reset.
    pub(super) fn reset(&mut self) -> Result<Shadows, SpiError> {
        let shadows = self.read(Register::SHADOW_REG1)?;
        self.write(Register::RESET, RESET_CODE)?;
        Ok(shadows)
    }

    /// Whether the part has started correctly after a reset.
    pub(super) fn has_started(&mut self, shadows: Shadows) -> Result<bool, SpiError> {
        let state = self.state()?;
        Ok(!counts::is_loading(&state)
            && self.identifies()?
            && self.read(Register::SHADOW_REG1)? == shadows)
    }

    /// Configures the part, which is in standby after a reset, and begins to measure. Returns false if it has another configuration then.
    pub(super) fn configure(&mut self) -> Result<bool, SpiError> {
        for (register, value) in SETTINGS {
            self.write(register, value)?;
        }
        self.change(SetUp::Normal)?;
        self.write(Register::POWER_CTL, 0)?;
        self.is_configured()
    }

    /// Whether the part has its configuration.
    pub(super) fn is_configured(&mut self) -> Result<bool, SpiError> {
        let mut found: [u8; CONFIGURATION] = self.read(Register::OFFSET_X_H)?;
        const { assert!(ACT_COUNT == CONFIGURATION - 8) };
        let [.., act_count, _, _, _, _, _, _, _] = &mut found;
        *act_count = 0;
        let mut expected = EXPECTED;
        let [.., self_test] = &mut expected;
        *self_test = self.force;
        Ok(found == expected)
    }

    /// Sets the self-test. The part permits it while it measures.
    pub(super) fn change(&mut self, set_up: SetUp) -> Result<(), SpiError> {
        self.force = match set_up {
            SetUp::Normal => 0,
            SetUp::Test { pushed: false } => TEST_MODE,
            SetUp::Test { pushed: true } => TEST_MODE | TEST_FORCE,
        };
        self.write(Register::SELF_TEST, self.force)
    }

    /// The transfer that reads STATUS, FIFO_ENTRIES and the temperature.
    pub(super) fn state(&mut self) -> Result<[u8; STATE], SpiError> {
        let mut bytes = [0; STATE];
        bytes[0] = reading(Register::STATUS);
        self.wires.transfer(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads consecutive registers.
    fn read<const LENGTH: usize>(&mut self, first: Register) -> Result<[u8; LENGTH], SpiError> {
        self.wires.select(true);
        let mut values = [0; LENGTH];
        let result = self.wires.exchange(&mut [reading(first)]);
        let result = result.and_then(|()| self.wires.exchange(&mut values));
        self.wires.select(false);
        result.map(|()| values)
    }

    fn write(&mut self, register: Register, value: u8) -> Result<(), SpiError> {
        self.wires.transfer(&mut [(register as u8) << 1, value])
    }
}

/// The address byte that reads from this register on.
pub(super) const fn reading(register: Register) -> u8 {
    (register as u8) << 1 | READ
}
