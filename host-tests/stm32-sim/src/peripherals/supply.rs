//! The converter at the divider of the sensor's supply: its clock, its pin, and the voltages of scene and microcontroller.

use super::Peripherals;
use crate::adc::Surroundings;
use crate::gpio::PinMode;
use crate::timebase::Picoseconds;

impl Peripherals {
    /// Moves the converter on to this time.
    pub(super) fn advance_adc(&mut self, now: Picoseconds) {
        let (imu, reference) = (&mut self.imu, self.pwr.supply());
        self.adc
            .advance(now, |time| (imu.supply(time).into(), reference.at(time)));
    }

    pub(super) fn around_adc(&self, now: Picoseconds) -> Surroundings {
        Surroundings {
            now,
            clock: self.rcc.adc_clock(),
            is_analog: self.gpio.mode(self.board.facts().pins.supply) == PinMode::Analog,
        }
    }
}
