//! The FIFO: its steps, the values in it and the readings of them.

use super::counts::{self, STATE, Value};
use super::driver::{Adxl355, COMPARE, MEASUREMENT_US, State};
use crate::board::MOUNTING;
use crate::imu::words::Task;
use plumbline::measure::Reading;
use plumbline::time::Instant;

/// The largest difference of two consecutive temperatures, in counts: 1.8 K. A larger one is that of a temperature that has changed while
/// it was read.
const TEMPERATURE_STEP: u16 = 16;

impl<const TESTS: usize> Adxl355<TESTS> {
    pub(super) fn read_on(&mut self, now: Instant) -> Option<Reading> {
        match self.words.step(&mut self.wires) {
            Task::None => None,
            Task::Compare => {
                self.compare(now);
                None
            }
            Task::Level => {
                let values = self.level(now);
                self.words.expect(values.into());
                None
            }
            Task::Evaluate(bytes) => self.take(now, counts::value(&bytes)),
        }
    }

    /// Compares identity and configuration with what they must be. A second difference, 5 ms after the first one, is none of the transfer.
    fn compare(&mut self, now: Instant) {
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
        Some(self.carry_test_on(now, reading))
    }
}
