//! From the motion to the values: the clock of the part, the low-pass, the range, the self-test.

use super::Fault;
use super::fifo::Fifo;
use crate::ism330dhcx::digits::Digits;
use crate::timebase::{MICROSECOND, Picoseconds, SECOND};
use bench::motion::Motion;
use plumbline::measure::{I32x3, ONE_G};
use plumbline::time::Instant;

/// The data rate in Hz for FILTER = 0; each step of it is half the rate.
const FASTEST: f64 = 4000.0;

/// g per count at +-2 g.
const UNIT: f64 = 1.0 / 256_000.0;

/// The noise density in g per square root of Hz.
const DENSITY: f64 = 22.5e-6;

/// The offset of each axis by the force of the self-test, in g (datasheet, typical).
const FORCE: [f64; 3] = [0.3, 0.3, 1.5];

/// The time after the begin of measuring in which the values are wrong.
const TURN_ON: Picoseconds = 10_000 * MICROSECOND;

/// The number of steps of the low-pass in a period, and its weights.
const STEPS: u64 = 4;
const WEIGHTS: [f64; 7] = [1.0, 2.0, 3.0, 4.0, 3.0, 2.0, 1.0];

#[derive(Clone, Debug, Default)]
pub(super) struct Sampling {
    deviation: f64,
    pub(super) offset: [f64; 3],
    pub(super) self_test_works: bool,
    pub(super) digits: Digits,
    /// The data rate in Hz; 0 in standby.
    rate: f64,
    /// The begin of measuring, or of the present clock, and the steps of the low-pass since then.
    start: Picoseconds,
    steps: u64,
    /// The end of the turn-on time.
    on: Picoseconds,
    unit: f64,
    forced: bool,
    measures_temperature: bool,
    /// OFFSET_X to OFFSET_Z.
    trim: [i32; 3],
    inputs: [[f64; 3]; WEIGHTS.len()],
    counts: [i32; 3],
    is_ready: bool,
    pub(super) data: [u8; 9],
    pub(super) temperature: [u8; 2],
    pub(super) fifo: Fifo,
}

impl Sampling {
    pub(super) fn new() -> Self {
        Self {
            self_test_works: true,
            ..Self::default()
        }
    }

    /// The state after a reset; the properties of the part stay.
    pub(super) fn reset(&mut self) {
        *self = Self {
            deviation: self.deviation,
            offset: self.offset,
            self_test_works: self.self_test_works,
            digits: self.digits,
            ..Self::default()
        };
    }

    pub(super) fn set_clock_deviation(&mut self, percent: f64) {
        self.start = self.time_of(self.steps);
        self.steps = 0;
        self.deviation = percent;
    }

    /// The time of a step since the start.
    fn time_of(&self, step: u64) -> Picoseconds {
        if self.rate == 0.0 {
            return self.start;
        }
        let rate = self.rate * STEPS as f64 * (1.0 + self.deviation / 100.0);
        self.start + (step as f64 * SECOND as f64 / rate).round() as Picoseconds
    }

    /// POWER_CTL, FILTER, RANGE, SELF_TEST and the offsets.
    pub(super) fn set_up(
        &mut self,
        now: Picoseconds,
        power: u8,
        filter: u8,
        range: u8,
        test: u8,
        trim: [i32; 3],
    ) {
        let rate = match power & 1 {
            0 => FASTEST / f64::from(1_u32 << (filter & 0x0F)),
            _ => 0.0,
        };
        if rate == 0.0 {
            self.fifo = Fifo::default();
        }
        if rate != self.rate {
            self.on = now + TURN_ON;
            self.start = now;
            self.steps = 0;
            self.rate = rate;
        }
        self.measures_temperature = power & 0b10 == 0;
        self.unit = UNIT * [4.0, 1.0, 2.0, 4.0][usize::from(range & 0b11)];
        self.forced = test & 0b11 == 0b11;
        self.trim = trim;
    }

    /// STATUS without NVM_BUSY. The read clears DATA_RDY and FIFO_OVR.
    pub(super) fn take_status(&mut self, now: Picoseconds, samples: u8) -> u8 {
        let full = self.fifo.entries(now) >= samples;
        let ready = std::mem::take(&mut self.is_ready);
        u8::from(ready) | u8::from(full) << 1 | u8::from(self.fifo.take_overrun()) << 2
    }

    /// Takes the values until `now`.
    pub(super) fn advance(&mut self, now: Picoseconds, fault: Fault, motion: &mut dyn Motion) {
        while self.rate > 0.0 {
            let next = self.time_of(self.steps + 1);
            if next > now {
                return;
            }
            self.steps += 1;
            let reading = motion.reading(Instant::from_ticks(next / MICROSECOND));
            self.inputs.rotate_left(1);
            if let Some(newest) = self.inputs.last_mut() {
                *newest = vector(reading.acceleration);
            }
            if fault != Fault::Stopped && self.steps.is_multiple_of(STEPS) {
                self.sample(next, fault);
                if self.measures_temperature && fault != Fault::StuckTemperature {
                    // The datasheet does not state the noise. Here 5 values in 1000 are a count less: a real part does not repeat a count for
                    // long.
                    let value = self.steps / STEPS % 1000;
                    let noise = u16::from(value >= 995);
                    let counts = temperature(reading.temperature).saturating_sub(noise);
                    self.temperature = counts.to_be_bytes();
                }
            }
        }
    }

    fn sample(&mut self, now: Picoseconds, fault: Fault) {
        let total: f64 = WEIGHTS.iter().sum();
        let mut values = self.offset;
        for (axis, value) in values.iter_mut().enumerate() {
            let inputs = self.inputs.iter().zip(WEIGHTS);
            *value += inputs
                .map(|(input, weight)| input[axis] * weight)
                .sum::<f64>()
                / total;
            if self.forced && self.self_test_works {
                *value += FORCE[axis];
            }
            if now < self.on {
                *value += 0.5;
            }
        }
        let deviation = DENSITY * (self.rate / 4.0).sqrt();
        let rounded = self.digits.rounded(values, deviation, self.unit);
        let before = self.counts;
        self.counts = [0, 1, 2].map(|axis| {
            let count = rounded[axis] as i32 + self.trim[axis] * 16;
            count.clamp(-0x80000, 0x7FFFF)
        });
        match fault {
            Fault::Zeros => self.counts = [0; 3],
            Fault::StuckAxis(axis) => self.counts[axis] = before[axis],
            Fault::Frozen => self.counts = before,
            _ => {}
        }
        let axes = self.counts.map(|count| {
            let [high, middle, low, _] = (count << 12).to_be_bytes();
            [high, middle, low]
        });
        self.data.copy_from_slice(axes.as_flattened());
        self.fifo.push(now, axes);
        self.is_ready = true;
    }
}

/// The counts of a temperature in 0.01 degC.
fn temperature(hundredths: i16) -> u16 {
    let degrees = f64::from(hundredths) / 100.0;
    (1885.0 - (degrees - 25.0) * 9.05)
        .round()
        .clamp(0.0, 4095.0) as u16
}

fn vector(value: I32x3) -> [f64; 3] {
    [value.x, value.y, value.z].map(|value| f64::from(value) / f64::from(ONE_G))
}
