//! The FIFO: its steps, the values in it and the readings of them.

use super::counts::{self, STATE, Value};
use super::driver::{Adxl355, MEASUREMENT_US, State};
use crate::board::MOUNTING;
use crate::imu::words::Task;
use plumbline::measure::Reading;
use plumbline::time::Instant;

/// The largest difference of two consecutive temperatures, in counts: 1.8 K. A larger one is that of a temperature that has changed while
/// it was read.
const TEMPERATURE_STEP: u16 = 16;

/// The number of values without a change of the temperature after which it is not known: 60 s. A count is 0.11 degC, and the datasheet does not
/// state the noise.
const UNCHANGED: u16 = 60_000;

impl<const TESTS: usize> Adxl355<TESTS> {
    pub(super) fn read_on(&mut self, now: Instant) -> Option<Reading> {
        match self.words.step(&mut self.wires) {
            Task::None => None,
            Task::Compare => {
                self.compare();
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

    /// Compares identity and configuration with what they must be, so the values in the FIFO were measured with them: 90 us. If only the
    /// second comparison is good, there was an error on the line.
    fn compare(&mut self) {
        for attempt in 0..2 {
            let own = self.identifies();
            if own.and_then(|own| Ok(own && self.is_configured()?)) == Ok(true) {
                if attempt > 0 {
                    self.spoil();
                }
                return;
            }
        }
        warn!("the accelerometer has another configuration");
        self.begin_again();
    }

    /// There was an error on the line. A single one costs a value. If they repeat, the data are wrong too, which have no parity: the part is
    /// started again, and must have values without an error for 0.5 s.
    fn spoil(&mut self) {
        if self.line.repeats() {
            self.distrust("bit errors on its line");
            return;
        }
        let all = self.settling_values();
        if let State::Running { settling, .. } = &mut self.state
            && *settling > 0
        {
            *settling = all;
        }
    }

    /// The values are wrong, and must be without an error for 0.5 s.
    fn distrust(&mut self, defect: &str) {
        warn!("the accelerometer has {=str}", defect);
        self.doubted = true;
        self.begin_again();
    }

    /// The number of values in the FIFO.
    fn level(&mut self, now: Instant) -> u8 {
        let Ok(state) = self.state() else {
            return 0;
        };
        let Some(values) = counts::level(&state) else {
            self.spoil();
            return 0;
        };
        if counts::has_lost(&state) {
            self.lost = true;
            self.values.restart();
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
        let step = counts.abs_diff(self.warmth);
        if step > 0 {
            self.unchanged = 0;
        }
        if step <= TEMPERATURE_STEP && self.unchanged < UNCHANGED {
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
            Value::Empty => {
                // The number of values was wrong.
                self.words.stop();
                self.spoil();
                return None;
            }
            Value::Misplaced => {
                self.spoil();
                return None;
            }
        };
        self.line.good();
        self.unchanged = self.unchanged.saturating_add(1);
        if self.unchanged == UNCHANGED {
            warn!("the temperature does not change");
            self.temperature = None;
        }
        // An axis that clips is told as such.
        if self.values.push(counts) && !counts::is_clipped(counts) {
            self.distrust("an axis that does not change");
            return None;
        }
        if self.values.are_wrong(self.doubted) {
            self.distrust("bit errors in its values");
            return None;
        }
        while let Some(counts) = self.values.release() {
            let reading = self.evaluate(now, counts);
            if reading.is_some() {
                return reading;
            }
        }
        None
    }

    /// Processes an acceleration. Returns a reading if one is complete.
    fn evaluate(&mut self, now: Instant, counts: [i32; 3]) -> Option<Reading> {
        let State::Running { settling, misses } = &mut self.state else {
            return None;
        };
        *misses = 0;
        if *settling > 0 {
            *settling -= 1;
            if *settling == 0 {
                self.doubted = false;
            }
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
