//! The FIFO: its steps, the values in it and the readings of them.

use super::counts::{self, STATE, VALUE, Value};
use super::driver::{Adxl355, COMPARE, MEASUREMENT_US, State};
use super::registers::reading;
use crate::board::MOUNTING;
use crate::imu::Wires;
use adi_adxl355::Register;
use plumbline::measure::Reading;
use plumbline::time::Instant;

/// The largest difference of two consecutive temperatures, in counts: 1.8 K. A larger one is that of a temperature that has changed while
/// it was read.
const TEMPERATURE_STEP: u16 = 16;

/// The next step of reading the part.
#[derive(Clone, Copy)]
pub(super) enum Step {
    /// Nothing: the part is not read.
    None,
    /// Compare identity and configuration.
    Compare,
    /// Read the number of values and the temperature.
    Level,
    /// Exchange the first half of a value.
    FirstHalf,
    /// Exchange the second half.
    SecondHalf,
    /// Evaluate the value.
    Evaluate,
}

impl<const TESTS: usize> Adxl355<TESTS> {
    pub(super) fn read_on(&mut self, now: Instant) -> Option<Reading> {
        let (first, second) = self.bytes.split_at_mut(VALUE / 2);
        match self.step {
            Step::None => None,
            Step::Compare => {
                self.compare(now);
                None
            }
            Step::Level => {
                self.values = self.level(now);
                self.next_value();
                None
            }
            Step::FirstHalf => {
                self.wires.select(true);
                let sent = self.wires.exchange(first);
                self.step = Step::SecondHalf;
                self.skip(sent.is_err());
                None
            }
            Step::SecondHalf => {
                let sent = self.wires.exchange(second);
                self.wires.select(false);
                self.step = Step::Evaluate;
                self.skip(sent.is_err());
                None
            }
            Step::Evaluate => {
                let bytes = self.bytes;
                self.values = self.values.saturating_sub(1);
                self.next_value();
                self.take(now, counts::value(&bytes))
            }
        }
    }

    /// Prepares the transfer of the next value, if there is one.
    fn next_value(&mut self) {
        self.bytes = [0; VALUE];
        self.bytes[0] = reading(Register::FIFO_DATA);
        self.step = match self.values {
            0 => Step::None,
            _ => Step::FirstHalf,
        };
    }

    /// After a failure of the SPI: ends the transfer and the reading of the FIFO.
    fn skip(&mut self, failed: bool) {
        if failed {
            self.wires.select(false);
            self.step = Step::None;
        }
    }

    /// Compares identity and configuration with what they must be. A second difference, 5 ms after the first one, is none of the transfer.
    fn compare(&mut self, now: Instant) {
        self.step = Step::Level;
        let own = self.identifies();
        let is_right = own.and_then(|own| Ok(own && self.is_configured()?)) == Ok(true);
        if is_right {
            self.doubted = false;
        } else if self.doubted {
            warn!("the accelerometer has another configuration");
            self.begin_again(now);
        } else if let State::Running { readings, .. } = &mut self.state {
            self.doubted = true;
            *readings = COMPARE;
        }
    }

    /// The number of values in the FIFO.
    fn level(&mut self, now: Instant) -> u8 {
        let Ok(state) = self.state() else {
            return 0;
        };
        let values = counts::level(&state);
        if counts::has_lost(&state) {
            self.lost = true;
            self.resampler.restart();
            self.counted = None;
        } else if values > 0 {
            self.measure_rate(now, values);
        }
        if values > 0 {
            self.measure_temperature(&state);
        }
        values
    }

    fn measure_temperature(&mut self, state: &[u8; STATE]) {
        let counts = counts::temperature_counts(state);
        if counts.abs_diff(self.warmth) <= TEMPERATURE_STEP {
            self.temperature = Some(counts::temperature(counts));
        }
        self.warmth = counts;
    }

    /// Counts the values until the data rate is known. `waiting` values are in the FIFO.
    fn measure_rate(&mut self, now: Instant, waiting: u8) {
        if self.is_timed || !matches!(self.state, State::Running { settling: 0, .. }) {
            return;
        }
        let sum = self.taken.wrapping_add(waiting.into());
        let Some((from, first)) = self.counted else {
            self.counted = Some((now, sum));
            return;
        };
        let passed = now.ticks().wrapping_sub(from.ticks()) as u32;
        if passed >= MEASUREMENT_US {
            if let Some(rate) = counts::data_rate(sum.wrapping_sub(first), passed) {
                self.resampler.adjust(rate);
                self.is_timed = true;
            }
            self.counted = None;
        }
    }

    /// Processes a value. Returns a reading if one is complete.
    fn take(&mut self, now: Instant, value: Value) -> Option<Reading> {
        let counts = match value {
            Value::Acceleration(counts) => counts,
            Value::Empty => return None,
            Value::Misplaced => {
                warn!("the values of the accelerometer are not in their order");
                self.begin_again(now);
                return None;
            }
        };
        let State::Running {
            settling, misses, ..
        } = &mut self.state
        else {
            return None;
        };
        *misses = 0;
        if *settling > 0 {
            *settling -= 1;
            return None;
        }
        self.taken = self.taken.wrapping_add(1);
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
}
