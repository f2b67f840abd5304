//! From the motion to the output registers: the clock of the part, full scales, LPF2, self-test, data-ready flags.

use super::super::timebase::{MICROSECOND, Picoseconds, SECOND};
use super::Fault;
use super::digits::{Digits, Noise};
use super::fifo::{Fifo, Sensor};
use super::filter::{LowPass, Memory};
use super::sibling::Sibling;
use bench::motion::Motion;
use plumbline::measure::{I32x3, ONE_G};
use plumbline::time::Instant;

/// The rate of the oscillator in Hz, and its change per unit of INTERNAL_FREQ_FINE in percent (AN5398, "Timestamp").
const OSCILLATOR: f64 = 6667.0;
const FINE_PERCENT: f64 = 0.15;

/// The divisor of the oscillator for each output data rate, by ODR_XL and ODR_G (AN5398, "ODR_coeff"); 0: off. The names of the
/// rates are 12.5, 26, 52, 104, 208, 416, 833, 1667, 3333, 6667 Hz.
const DIVISORS: [f64; 12] = [
    0.0, 512.0, 256.0, 128.0, 64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 512.0,
];

/// Micro-degrees per second per count, by FS_G: 250, 500, 1000 and 2000 deg/s (datasheet, G_So).
const RATE_UNITS: [f64; 4] = [8750.0, 17_500.0, 35_000.0, 70_000.0];
/// With FS_125 and with FS_4000.
const RATE_UNIT_125: f64 = 4375.0;
const RATE_UNIT_4000: f64 = 140_000.0;

/// Cut-off of LPF2 as divisor of the output data rate, by HPCF_XL (datasheet, "Accelerometer bandwidth configurations").
const CUTOFFS: [f64; 8] = [4.0, 10.0, 20.0, 45.0, 100.0, 200.0, 400.0, 800.0];

/// The noise density of the accelerometer in g, and of the gyroscope in deg/s per square root of Hz (datasheet, An and Rn, high-performance
/// mode).
const DENSITY: f64 = 60e-6;
const RATE_DENSITY: f64 = 5e-3;

/// The rate of the thermometer in Hz (datasheet, TODR), and counts per degree relative to 25 degC.
const THERMOMETER_RATE: f64 = OSCILLATOR / 128.0;
const COUNTS_PER_DEGREE: f64 = 256.0;

/// The datasheet does not state the noise of the thermometer. Here one value in this number is a count farther from 25 degC, which is less than
/// 0.01 degC: a real part does not repeat a count for long.
const TEMPERATURE_NOISE: u64 = 100;

/// The gyroscope's turn-on time (datasheet, Ton).
const GYROSCOPE_TURN_ON: Picoseconds = 35_000 * MICROSECOND;

/// The self-test offset of each axis, in g: within the 90 to 1700 mg of the datasheet.
const SELF_TEST: f64 = 0.5;

/// The sample clock of one of the sensors, derived from the clock of the part.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct Clock {
    /// The nominal rate in Hz; 0: off.
    rate: f64,
    /// The next sample; its time is a number of periods, so that it does not drift.
    start: Picoseconds,
    samples: u64,
}

impl Clock {
    fn next(&self, deviation: f64) -> Option<Picoseconds> {
        (self.rate > 0.0).then(|| {
            let period = SECOND as f64 / (self.rate * (1.0 + deviation / 100.0));
            self.start + ((self.samples + 1) as f64 * period).round() as Picoseconds
        })
    }

    fn set_rate(&mut self, rate: f64, start: Picoseconds) {
        if rate != self.rate {
            *self = Self {
                rate,
                start,
                samples: 0,
            };
        }
    }
}

/// A value in two output registers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Output {
    shown: i16,
    newest: i16,
    /// With block data update: the byte that has been read while the other has not.
    half_read: Option<u8>,
    /// There was a value since power-up.
    has_value: bool,
}

impl Output {
    fn set(&mut self, value: i16) {
        self.newest = value;
        self.has_value = true;
        if self.half_read.is_none() {
            self.shown = value;
        }
    }

    /// Byte 0 or 1.
    fn read(&mut self, byte: u8, block_update: bool) -> u8 {
        let value = self.shown.to_le_bytes()[usize::from(byte)];
        self.half_read = match self.half_read {
            None if block_update => Some(byte),
            Some(other) if block_update && other == byte => Some(byte),
            _ => None,
        };
        if self.half_read.is_none() {
            self.shown = self.newest;
        }
        value
    }
}

/// The three sensors and their output registers.
#[derive(Clone, Debug)]
pub(super) struct Sampling {
    deviation: f64,
    pub(super) self_test_works: bool,
    pub(super) sibling: Sibling,
    accelerometer: Clock,
    gyroscope: Clock,
    thermometer: Clock,
    acceleration_unit: f64,
    digits: Digits,
    rate_unit: f64,
    rate_digits: Digits,
    /// The bits of the next angular rate that are inverted on the line.
    pub(super) inverted: [i16; 3],
    /// In each acceleration of this period, these bits of Y are inverted on the line; 0: in none.
    pub(super) inverts: (u64, i16),
    /// The number of temperatures, also before a reset.
    temperatures: u64,
    low_pass: Option<LowPass>,
    memories: [Memory; 3],
    self_test: f64,
    status: Status,
    /// Temperature, angular rate, acceleration.
    outputs: [Output; 7],
    pub(super) fifo: Fifo,
}

/// STATUS_REG.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Status {
    acceleration: bool,
    rate: bool,
    temperature: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            deviation: 0.0,
            self_test_works: true,
            sibling: Sibling::Ism330dhcx,
            accelerometer: Clock::default(),
            gyroscope: Clock::default(),
            thermometer: Clock::default(),
            acceleration_unit: Sibling::Ism330dhcx.units()[0],
            digits: Digits::new(0),
            rate_unit: RATE_UNITS[0],
            rate_digits: Digits::new(1),
            inverted: [0; 3],
            inverts: (0, 0),
            temperatures: 0,
            low_pass: None,
            memories: [Memory::default(); 3],
            self_test: 0.0,
            status: Status::default(),
            outputs: [Output::default(); 7],
            fifo: Fifo::default(),
        }
    }
}

impl Sampling {
    /// Power-down; the properties of the part stay.
    pub(super) fn reset(&mut self) {
        *self = Self {
            deviation: self.deviation,
            self_test_works: self.self_test_works,
            sibling: self.sibling,
            digits: self.digits,
            rate_digits: self.rate_digits,
            inverts: self.inverts,
            temperatures: self.temperatures,
            ..Self::default()
        };
    }

    pub(super) fn set_noise(&mut self, noise: Noise) {
        self.digits.noise = noise;
        self.rate_digits.noise = match noise {
            Noise::Alternating => Noise::Pairs,
            other => other,
        };
    }

    /// Changes the clock of the part from the next sample on.
    pub(super) fn set_clock_deviation(&mut self, percent: f64) {
        let old = self.deviation;
        for clock in [
            &mut self.accelerometer,
            &mut self.gyroscope,
            &mut self.thermometer,
        ] {
            if let Some(next) = clock.next(old) {
                let period = SECOND as f64 / (clock.rate * (1.0 + old / 100.0));
                clock.start = next.saturating_sub(period as Picoseconds);
                clock.samples = 0;
            }
        }
        self.deviation = percent;
    }

    /// CTRL1_XL, CTRL8_XL and CTRL5_C. The filter starts from 0 g when the accelerometer is switched on.
    pub(super) fn set_up_accelerometer(
        &mut self,
        now: Picoseconds,
        ctrl1: u8,
        ctrl8: u8,
        ctrl5: u8,
    ) {
        self.acceleration_unit = self.sibling.units()[usize::from(ctrl1 >> 2 & 0b11)];
        let cutoff = CUTOFFS[usize::from(ctrl8 >> 5)];
        self.low_pass = (ctrl1 & 0b10 != 0).then(|| LowPass::new(1.0 / cutoff));
        self.self_test = match ctrl5 & 0b11 {
            0b01 => SELF_TEST,
            0b10 => -SELF_TEST,
            _ => 0.0,
        };
        if self.accelerometer.rate == 0.0 {
            self.memories = [Memory::default(); 3];
        }
        self.accelerometer.set_rate(rate(ctrl1), now);
        self.set_up_thermometer(now);
    }

    /// CTRL2_G.
    pub(super) fn set_up_gyroscope(&mut self, now: Picoseconds, ctrl2: u8) {
        self.rate_unit = match (ctrl2 & 0b01 != 0, ctrl2 & 0b10 != 0) {
            (true, _) => RATE_UNIT_4000,
            (_, true) => RATE_UNIT_125,
            _ => RATE_UNITS[usize::from(ctrl2 >> 2 & 0b11)],
        };
        let turn_on = if self.gyroscope.rate == 0.0 {
            GYROSCOPE_TURN_ON
        } else {
            0
        };
        self.gyroscope.set_rate(rate(ctrl2), now + turn_on);
        self.set_up_thermometer(now);
    }

    /// It runs together with the others, not faster than they do.
    fn set_up_thermometer(&mut self, now: Picoseconds) {
        let fastest = self.accelerometer.rate.max(self.gyroscope.rate);
        self.thermometer
            .set_rate(fastest.min(THERMOMETER_RATE), now);
    }

    /// STATUS_REG.
    pub(super) fn status(&self) -> u8 {
        let Status {
            acceleration,
            rate,
            temperature,
        } = self.status;
        u8::from(acceleration) | u8::from(rate) << 1 | u8::from(temperature) << 2
    }

    /// Reads an output register, counted from OUT_TEMP_L. Reading a high byte clears the data-ready flag of its sensor.
    pub(super) fn output(&mut self, index: u8, block_update: bool) -> u8 {
        let (value, byte) = (index / 2, index % 2);
        if byte == 1 {
            match value {
                0 => self.status.temperature = false,
                1..=3 => self.status.rate = false,
                _ => self.status.acceleration = false,
            }
        }
        self.outputs[usize::from(value)].read(byte, block_update)
    }

    /// Takes the samples until `now`.
    pub(super) fn advance(&mut self, now: Picoseconds, own: Fault, motion: &mut dyn Motion) {
        loop {
            let clocks = [&self.accelerometer, &self.gyroscope, &self.thermometer];
            let times = clocks.map(|clock| clock.next(self.deviation));
            let Some(next) = times
                .into_iter()
                .flatten()
                .min()
                .filter(|next| *next <= now)
            else {
                return;
            };
            let fault = Fault::at(next, own, motion);
            let reading = motion.reading(Instant::from_ticks(next / MICROSECOND));
            let due = times.map(|time| time == Some(next));
            if due[0] {
                self.accelerometer.samples += 1;
                self.sample_acceleration(reading.acceleration, fault);
            }
            if due[1] {
                self.gyroscope.samples += 1;
            }
            if due[1] && fault != Fault::WithoutRate {
                let rates = vector(reading.angular_rate, 65536.0);
                let deviation = RATE_DENSITY * (self.gyroscope.rate / 2.0).sqrt();
                let unit = self.rate_unit / 1e6;
                let mut counts = self.rate_digits.of(rates, deviation, unit);
                match fault {
                    Fault::StuckRate(axis, count) => counts[axis] = count,
                    Fault::ZeroRates => counts = [0; 3],
                    _ => {}
                }
                self.status.rate |= set(&mut self.outputs[1..4], counts, fault);
                let number = self.gyroscope.samples;
                self.batch(Sensor::Gyroscope, number, fault);
            }
            if due[2] {
                self.thermometer.samples += 1;
                let degrees = f64::from(reading.temperature) / 100.0;
                let number = self.thermometer.samples;
                let mut exact = count((degrees - 25.0) * COUNTS_PER_DEGREE);
                self.temperatures += 1;
                if self.temperatures.is_multiple_of(TEMPERATURE_NOISE) {
                    exact = exact.saturating_add(if exact < 0 { -1 } else { 1 });
                }
                if fault == Fault::StuckTemperature {
                    exact = self.outputs[0].newest;
                }
                self.status.temperature |= set(&mut self.outputs[..1], [exact], fault);
                self.batch(Sensor::Thermometer, number, fault);
            }
        }
    }

    fn sample_acceleration(&mut self, acceleration: I32x3, fault: Fault) {
        let offset = if self.self_test_works {
            self.self_test
        } else {
            0.0
        };
        let mut values = vector(acceleration, f64::from(ONE_G)).map(|value| value + offset);
        if let Some(low_pass) = &self.low_pass {
            for (value, memory) in values.iter_mut().zip(&mut self.memories) {
                *value = low_pass.step(memory, *value);
            }
        }
        let deviation = DENSITY * (self.accelerometer.rate / 2.0).sqrt();
        let unit = self.acceleration_unit;
        let mut counts = self.digits.of(values, deviation, unit);
        counts[self.sibling.axes()..].fill(0);
        if let Fault::Stuck(axis, count) = fault {
            counts[axis] = count;
        }
        self.status.acceleration |= set(&mut self.outputs[4..], counts, fault);
        let number = self.accelerometer.samples;
        self.batch(Sensor::Accelerometer, number, fault);
    }

    /// Puts the newest output of a sensor into the FIFO.
    fn batch(&mut self, sensor: Sensor, number: u64, fault: Fault) {
        if fault == Fault::Stopped {
            return;
        }
        let newest = |place: usize| self.outputs[place].newest;
        let inverted = match sensor {
            Sensor::Gyroscope => std::mem::take(&mut self.inverted),
            Sensor::Accelerometer
                if self.inverts.0 > 0 && number.is_multiple_of(self.inverts.0) =>
            {
                [0, self.inverts.1, 0]
            }
            _ => [0; 3],
        };
        let counts = match sensor {
            Sensor::Thermometer => [newest(0), 0, 0],
            Sensor::Gyroscope => [0, 1, 2].map(|axis| newest(1 + axis) ^ inverted[axis]),
            Sensor::Accelerometer => [0, 1, 2].map(|axis| newest(4 + axis) ^ inverted[axis]),
        };
        self.fifo.push(sensor, number, counts);
    }

    /// INTERNAL_FREQ_FINE.
    pub(super) fn frequency_fine(&self) -> i8 {
        (self.deviation / FINE_PERCENT).round() as i8
    }
}

/// The rate in the upper half of CTRL1_XL or CTRL2_G; codes that are not allowed are off.
fn rate(control: u8) -> f64 {
    match DIVISORS.get(usize::from(control >> 4)) {
        Some(&divisor) if divisor > 0.0 => OSCILLATOR / divisor,
        _ => 0.0,
    }
}

fn vector(value: I32x3, unit: f64) -> [f64; 3] {
    [value.x, value.y, value.z].map(|value| f64::from(value) / unit)
}

/// Rounded to nearest; the cast saturates.
fn count(value: f64) -> i16 {
    value.round() as i16
}

/// Writes a sample to the output registers; true when there is new data.
fn set<const N: usize>(outputs: &mut [Output], counts: [i16; N], fault: Fault) -> bool {
    if fault == Fault::Stopped {
        return false;
    }
    for (output, count) in outputs.iter_mut().zip(counts) {
        if fault != Fault::Frozen || !output.has_value {
            output.set(count);
        }
    }
    true
}
