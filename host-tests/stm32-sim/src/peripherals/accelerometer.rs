//! The SPI with the accelerometer: its clock, its pins, which can be without connection or too slow, and the chip select.

use super::Peripherals;
use crate::adxl355::Adxl355;
use crate::board;
use crate::gpio::Gpio;
use crate::ism330dhcx::Ism330dhcx;
use crate::spi::{Clocks, SpiPart};
use crate::timebase::Picoseconds;
use crate::violation::Violations;

impl Peripherals {
    /// Mounts an ADXL355 in the place of the ISM330DHCX, with its motion.
    pub fn fit_adxl355(&mut self) {
        self.adxl355 = Some(Adxl355::new(self.imu.take_motion()));
        self.imu.unmount();
    }

    pub(super) fn clocks(&self) -> Clocks {
        Clocks {
            hclk: self.rcc.hclk(),
            pclk: match self.board.facts().spi {
                board::Spi::Spi1 => self.rcc.pclk2(),
                board::Spi::Spi2 => self.rcc.pclk1(),
            },
        }
    }

    /// The frequency of SCK in Hz.
    pub fn spi_bit_rate(&self) -> u32 {
        self.spi.bit_rate(self.clocks())
    }

    /// Moves SPI and accelerometer on to this cycle.
    pub(super) fn advance_spi(&mut self, cycle: u64) {
        if !self.spi.is_due(cycle) {
            return;
        }
        let timebase = *self.rcc.timebase();
        let clocks = self.clocks();
        let time_at = |cycle| timebase.time_at(cycle);
        let mut part = Mounted {
            imu: &mut self.imu,
            adxl355: self.adxl355.as_mut(),
        };
        let connected = board::spi_is_connected(self.board, &self.afio, &self.gpio);
        if connected && !self.spi.is_in_ti_mode() {
            let rate = self.spi.bit_rate(clocks);
            if board::spi_pins_are_fast_enough(self.board, &self.gpio, rate) {
                self.spi.advance(cycle, clocks, time_at, &mut part);
            } else {
                let reason = "the pins of the SPI are too slow for its clock";
                self.violations.add("GPIOx_OSPEEDR", reason);
                let mut late = LateEdges(part);
                self.spi.advance(cycle, clocks, time_at, &mut late);
            }
        } else {
            self.spi.advance(cycle, clocks, time_at, &mut OpenWires);
        }
        while let Some(register) = self.imu.take_unmodelled() {
            let name = format!("ISM330DHCX {register:02X}h");
            self.violations.add(name, "register not modelled");
        }
        let adxl355 = &mut self.adxl355;
        while let Some((register, reason)) = adxl355.as_mut().and_then(Adxl355::take_complaint) {
            self.violations
                .add(format!("ADXL355 {register:02X}h"), reason);
        }
        if let Some(reason) = self.imu.take_complaint() {
            self.violations.add("ISM330DHCX", reason);
        }
    }

    /// Changes the pins and reports the chip select, which has a pull-up, to the accelerometer.
    pub(super) fn change_pins<T>(
        &mut self,
        cycle: u64,
        f: impl FnOnce(&mut Gpio, &mut Violations) -> T,
    ) -> T {
        self.advance_spi(cycle);
        let select = self.board.facts().pins.select;
        let is_low = |gpio: &Gpio| gpio.output(select) == Some(false);
        let before = is_low(&self.gpio);
        let result = f(&mut self.gpio, &mut self.violations);
        let after = is_low(&self.gpio);
        if before != after {
            self.violations.check(
                self.spi.is_busy(),
                "GPIOx",
                "the accelerometer's chip select changes within a frame",
            );
            let now = self.now(cycle);
            let mut part = Mounted {
                imu: &mut self.imu,
                adxl355: self.adxl355.as_mut(),
            };
            part.select(now, after);
        }
        result
    }
}

/// The pins of the SPI without a connection: the input floats high.
struct OpenWires;

impl SpiPart for OpenWires {
    fn select(&mut self, _: Picoseconds, _: bool) {}

    fn transfer(&mut self, _: Picoseconds, _: u8) -> u8 {
        0xFF
    }
}

/// The part at the SPI.
struct Mounted<'a> {
    imu: &'a mut Ism330dhcx,
    adxl355: Option<&'a mut Adxl355>,
}

impl SpiPart for Mounted<'_> {
    fn select(&mut self, now: Picoseconds, selected: bool) {
        match &mut self.adxl355 {
            Some(part) => part.select(now, selected),
            None => self.imu.select(now, selected),
        }
    }

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        match &mut self.adxl355 {
            Some(part) => part.transfer(now, byte),
            None => self.imu.transfer(now, byte),
        }
    }
}

/// Pins whose edges are late: the last bit of each byte that is read repeats the bit before it.
struct LateEdges<'a>(Mounted<'a>);

impl SpiPart for LateEdges<'_> {
    fn select(&mut self, now: Picoseconds, selected: bool) {
        self.0.select(now, selected);
    }

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        let answer = self.0.transfer(now, byte);
        answer & !1 | answer >> 1 & 1
    }
}
