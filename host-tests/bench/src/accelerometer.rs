//! The accelerometer and the gyroscope of a sensor on the bench: values at their data rate, resampled to readings at 200 Hz as on the
//! boards.

use crate::fault::Fault;
use crate::motion::Motion;
use plumbline::measure::mean_rate::MeanRate;
use plumbline::measure::resampler::Resampler;
use plumbline::measure::{RANGE, Reading};
use plumbline::time::Instant;

/// The data rate in mHz, nominal: that of the ISM330DHCX (6667 Hz / 8).
const DATA_RATE: u32 = 6_667_000 / 8;

/// The range of the gyroscope in 2^-16 deg/s: 32767 counts of 35 mdps.
const FASTEST: i32 = (32_767.0 * 0.035 * 65_536.0) as i32;

/// The number of equal values in a row after which the firmware uses no more of them.
const EQUAL: u32 = 32;

/// The number of values that are there before a reading needs them.
const AHEAD: u32 = 2;

const SECOND: u64 = 1_000_000_000_000;

/// The accelerometer of a simulated sensor: it has its own clock, data rate and faults.
pub struct Accelerometer {
    resampler: Resampler<i32, 0>,
    rate: MeanRate<0>,
    start: Instant,
    /// The number of values since the start.
    values: u64,
    /// The error of its oscillator in units of 10^-6; the accelerometer states it.
    deviation: i32,
    /// A value was clipped since the last reading.
    clipped: bool,
    /// The last reading. A frozen or silent sensor repeats it.
    last: Option<Reading>,
    /// The number of values that a frozen sensor has repeated.
    repeated: u32,
    /// There was a reading since power-up.
    started: bool,
}

impl Accelerometer {
    /// An accelerometer whose oscillator has this error, in 10^-6.
    pub fn new(deviation: i32) -> Self {
        Self {
            resampler: Resampler::new(),
            rate: MeanRate::new(),
            start: Instant::from_ticks(0),
            values: 0,
            deviation,
            clipped: false,
            last: None,
            repeated: 0,
            started: false,
        }
    }

    /// Switches the power on. The first call of [`readings`](Self::readings) follows when the first reading is complete.
    pub fn power_on(&mut self) {
        self.last = None;
        self.started = false;
    }

    /// The data rate in mHz.
    fn data_rate(&self) -> u32 {
        let change = i64::from(DATA_RATE) * i64::from(self.deviation) / 1_000_000;
        (i64::from(DATA_RATE) + change) as u32
    }

    /// The first reading, that of an accelerometer that has been at rest before.
    fn start(&mut self, now: Instant, motion: &mut dyn Motion) -> Option<Reading> {
        let still = self.value(now, motion)?;
        self.started = true;
        self.resampler.start(self.data_rate());
        self.rate = MeanRate::new();
        self.start = now;
        self.values = 0;
        self.clipped = false;
        let first = std::iter::repeat_with(|| self.push(still)).flatten().next();
        // So that each reading is complete at the end of its 5 ms, also if the clocks differ a little.
        for _ in 0..AHEAD {
            self.push(still);
        }
        first
    }

    /// The value of the part at a time; None if it has none.
    fn value(&mut self, now: Instant, motion: &mut dyn Motion) -> Option<Reading> {
        let reading = motion.reading(now);
        let fault = motion.fault(now);
        if fault != Some(Fault::Frozen) {
            self.repeated = 0;
        }
        match fault {
            Some(fault) if fault.is_mute() => None,
            Some(Fault::Frozen) => {
                self.repeated += 1;
                let last = *self.last.get_or_insert(reading);
                (self.repeated < EQUAL).then_some(last)
            }
            _ => Some(*self.last.insert(reading)),
        }
    }

    /// The readings that are complete at `now`.
    pub fn readings(&mut self, now: Instant, motion: &mut dyn Motion) -> Vec<Reading> {
        if !self.started {
            return self.start(now, motion).into_iter().collect();
        }
        let mut readings = Vec::new();
        loop {
            let period = u128::from(SECOND) * 1000 / u128::from(self.data_rate());
            let picoseconds = u128::from(self.values + 1) * period;
            let time = Instant::from_ticks(self.start.ticks() + (picoseconds / 1_000_000) as u64);
            if time > now {
                self.resampler.follow();
                return readings;
            }
            self.values += 1;
            let value = self.value(time, motion);
            readings.extend(value.and_then(|value| self.push(value)));
        }
    }

    fn push(&mut self, reading: Reading) -> Option<Reading> {
        let value = reading.acceleration.to_array();
        let value = value.map(|component| component.clamp(-RANGE, RANGE - 1));
        let rate = reading.angular_rate.to_array();
        self.rate
            .push(rate.map(|rate| rate.clamp(-FASTEST, FASTEST)));
        self.clipped |= reading.clipped;
        let acceleration = self.resampler.push(value)?;
        Some(Reading {
            acceleration,
            // At the first sample there is no mean yet.
            angular_rate: self.rate.take(&self.resampler).unwrap_or_default(),
            clipped: core::mem::take(&mut self.clipped),
            ..reading
        })
    }
}
