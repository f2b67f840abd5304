//! The FIFO: its steps, the words in it and the readings of them.

use super::counts::{self, WORD, Word};
use super::driver::{Ism330dhcx, State, Trouble};
use super::registers::READ;
use crate::board::MOUNTING;
use crate::imu::Wires;
use crate::imu::rates::Rates;
use crate::imu::words::Task;
use ism330dhcx_rs::blocking::prelude::Reg;
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::{I32x3, Reading};
use plumbline::time::Instant;

/// The number of consecutive samples without an angular rate after which the gyroscope has failed: 200 ms. It turns on within 35 ms.
const SILENT_SAMPLES: u8 = 40;

/// The number of accelerations without a change of the temperature after which it is not known: 10 s. A count is 1/256 degC.
const UNCHANGED: u16 = 8334;

impl<const TESTS: usize, const GYROSCOPES: usize> Ism330dhcx<TESTS, GYROSCOPES> {
    /// Performs one step of reading the FIFO. Returns a reading if one is complete, unless the accelerometer is missing or
    /// settling.
    pub(super) fn read_on(&mut self, now: Instant) -> Option<Reading> {
        match self.words.step(&mut self.wires) {
            Task::None => None,
            Task::Compare => {
                self.compare(now);
                None
            }
            Task::Level => {
                let words = self.level(now);
                self.words.expect(words);
                None
            }
            Task::Evaluate(bytes) => self.take(now, &bytes),
        }
    }

    /// The number of words in the FIFO.
    fn level(&mut self, now: Instant) -> u16 {
        let mut bytes = [Reg::FifoStatus1 as u8 | READ, 0, 0];
        if self.wires.transfer(&mut bytes).is_err() {
            return 0;
        }
        let status = [bytes[1], bytes[2]];
        let Some(words) = counts::level(status) else {
            self.spoil(now);
            return 0;
        };
        if counts::has_lost(status) {
            self.tags.restart();
            self.gap();
        }
        words
    }

    /// Values were lost. The rotation in them is not known, and neither a reading nor the judgement of a value must have values from before
    /// and after the gap.
    fn gap(&mut self) {
        self.values.restart();
        if let Some(gyroscope) = self.gyroscope.first_mut() {
            gyroscope.rate = MeanRate::new();
            gyroscope.rates = Rates::INITIAL;
            gyroscope.silent = 0;
            gyroscope.lost = true;
            self.resampler.restart();
        }
    }

    /// There was an error on the line. A single one costs a value. If they repeat, the data are wrong too, which have no parity: the
    /// accelerometer has failed.
    pub(super) fn spoil(&mut self, now: Instant) {
        if self.line.repeats() {
            self.fail(now, Trouble::Line);
            return;
        }
        let all = self.settling_values();
        if let State::Running { settling, .. } = &mut self.state
            && *settling > 0
        {
            *settling = all;
        }
        self.gap();
    }

    /// Processes a word. Returns a reading if one is complete.
    fn take(&mut self, now: Instant, bytes: &[u8; WORD]) -> Option<Reading> {
        let &[_, tag, ..] = bytes;
        if !self.tags.accept(tag) {
            // The rest is read later: after lost words their number is wrong, which must not be a second error.
            self.words.stop();
            self.spoil(now);
            return None;
        }
        self.line.good();
        if let Some(gyroscope) = self.gyroscope.first_mut()
            && let Some(mut counts) = counts::rate_word(bytes)
        {
            let clipped = counts::is_clipped(counts);
            let is_stuck = gyroscope.rates.push(&mut counts);
            gyroscope.rate.push(counts);
            if is_stuck && !clipped {
                self.fail(now, Trouble::Stuck);
            }
            return None;
        }
        let counts = match counts::word(bytes) {
            Word::Acceleration(counts) => counts,
            Word::Temperature(temperature) => {
                self.take_temperature(temperature);
                return None;
            }
            Word::Other => return None,
        };
        self.unchanged = self.unchanged.saturating_add(1);
        if self.unchanged == UNCHANGED {
            warn!("the temperature does not change");
            self.temperature = None;
        }
        let counts = counts.map(i32::from);
        // An axis that clips is told as such.
        if self.values.push(counts) && !counts::is_clipped(counts) {
            self.fail(now, Trouble::Stuck);
            return None;
        }
        if self.values.are_wrong(self.doubted) {
            self.fail(now, Trouble::Line);
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
                self.settled();
            }
            return None;
        }
        self.clipped |= counts::is_clipped(counts);
        let within = |count: i32| count.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        let output = self.resampler.push(counts.map(within))?;
        let rate = self.angular_rate(now);
        let mut reading = Reading {
            acceleration: counts::acceleration(output, MOUNTING),
            temperature: self.temperature?,
            clipped: core::mem::take(&mut self.clipped),
            ..Reading::default()
        };
        if GYROSCOPES > 0 {
            reading.angular_rate = rate?;
        }
        Some(self.carry_test_on(now, reading))
    }

    /// A temperature far from the last one has a wrong bit, unless the next one is near to it.
    fn take_temperature(&mut self, counts: i16) {
        let step = counts.abs_diff(self.warmth);
        if step > 0 {
            self.unchanged = 0;
        }
        if step <= counts::TEMPERATURE_STEP && self.unchanged < UNCHANGED {
            self.temperature = Some(counts::temperature(counts));
        }
        self.warmth = counts;
    }

    /// The mean angular rate up to the last output of the resampler. None if there is none yet, or no gyroscope.
    fn angular_rate(&mut self, now: Instant) -> Option<I32x3> {
        let gyroscope = self.gyroscope.first_mut()?;
        let Some(mean) = gyroscope.rate.take(&self.resampler) else {
            gyroscope.silent += 1;
            if gyroscope.silent >= SILENT_SAMPLES {
                self.fail(now, Trouble::NoRate);
            }
            return None;
        };
        gyroscope.silent = 0;
        Some(counts::angular_rate(mean, MOUNTING))
    }
}
