//! From the data rate of the accelerometer to the sampling rate of 200 Hz, without aliases.
//!
//! The oscillator of an accelerometer has an error of some per cent, so its data rate and [`SAMPLE_PERIOD`]
//! have no fixed ratio. The resampler calculates the acceleration at the times of the 200 Hz samples from the last 20 or 24 values of
//! the accelerometer, weighted by a low-pass response that is continuous in time. The response is stored at four points per value
//! and interpolated between them. So the cut-off frequencies of the following filters do not depend on the oscillator, and
//! vibration does not alias into their pass bands.
//!
//! An accelerometer states its data rate, or a driver measures it ([`Resampler::adjust`]). The remaining error of up to 0.15 %, and slow
//! changes of up to 2 %, are measured with the clock of the caller ([`Resampler::follow`]): some seconds after the start, an output is
//! complete in the middle between two calls, so there is exactly one output between two calls.
//!
//! The weights are symmetric in time: the delay is half their number in values of the accelerometer, equal at all frequencies. The
//! response is a minimax design (linear programming), one for 833 Hz and one for 1000 Hz, with an error of the oscillator of up to 5 %:
//!
//! | frequency | gain with 20 weights, for 833 Hz | with 24 weights, for 1000 Hz |
//! |---|---|---|
//! | constant | exactly 1 | exactly 1 |
//! | up to 25 Hz | within 0.03 dB | within 0.03 dB |
//! | 80 Hz | -3.8 to -5.5 dB | -4.2 to -6.0 dB |
//! | from 160 Hz to half of the rate | below -40 dB | below -40 dB |
//! | from 185 Hz to half of the rate | below -60 dB | below -58.8 dB |
//!
//! ```
//! use plumbline::measure::{I32x3, ONE_G, resampler::Resampler};
//!
//! let mut resampler = Resampler::<i32, 0>::new();
//! resampler.start(833_000);
//! let level = I32x3 { x: 0, y: 0, z: ONE_G };
//! let outputs = (0..853).filter_map(|_| resampler.push([0, 0, ONE_G]));
//! assert_eq!(outputs.filter(|&output| output == level).count(), 201);
//! ```

use super::{I32x3, SAMPLE_PERIOD};

/// The number of weighted values at 833 Hz.
pub const TAPS: usize = 20;

/// The number of weighted values at 1000 Hz.
pub const TAPS_1000: usize = 24;

/// The base-2 logarithm of the number of points of the response per value.
const POINTS: u32 = 2;

/// The response: the sum of every fourth point is about 2^15. The last three points fill the last group of four.
static RESPONSE: [i16; (TAPS + 1) << POINTS] = [
    -16, -29, -43, -61, -88, -124, -163, -206, -254, -307, -360, -412, -461, -502, -530, -539,
    -527, -487, -415, -305, -156, 38, 278, 566, 899, 1276, 1694, 2146, 2625, 3124, 3634, 4141,
    4637, 5109, 5546, 5937, 6272, 6543, 6742, 6863, 6904, 6863, 6742, 6543, 6272, 5937, 5546, 5109,
    4637, 4141, 3634, 3124, 2625, 2146, 1694, 1276, 899, 566, 278, 38, -156, -305, -415, -487,
    -527, -539, -530, -502, -461, -412, -360, -307, -254, -206, -163, -124, -88, -61, -43, -29,
    -16, 0, 0, 0,
];

/// The response for 1000 Hz.
static RESPONSE_1000: [i16; (TAPS_1000 + 1) << POINTS] = [
    -35, -23, -45, -58, -80, -103, -130, -160, -193, -228, -265, -303, -338, -373, -403, -428,
    -445, -452, -447, -428, -392, -338, -263, -167, -46, 97, 267, 460, 679, 920, 1185, 1468, 1769,
    2083, 2409, 2740, 3074, 3404, 3728, 4038, 4333, 4604, 4851, 5065, 5248, 5392, 5498, 5561, 5583,
    5561, 5498, 5392, 5248, 5065, 4851, 4604, 4333, 4038, 3728, 3404, 3074, 2740, 2409, 2083, 1769,
    1468, 1185, 920, 679, 460, 267, 97, -46, -167, -263, -338, -392, -428, -447, -452, -445, -428,
    -403, -373, -338, -303, -265, -228, -193, -160, -130, -103, -80, -58, -45, -23, -35, 0, 0, 0,
];

/// The base-2 logarithm of a period of the accelerometer, in the unit of the time.
pub(crate) const PERIOD: u32 = 16;

/// The base-2 logarithm of the distance of two points of the response.
const POINT: u32 = PERIOD - POINTS;

/// The base-2 logarithm of the total weight of an interpolated response.
const WEIGHT: u32 = 15 + POINT;

/// The sampling rate in Hz.
const SAMPLE_RATE: u32 = (1_000_000 / SAMPLE_PERIOD.ticks()) as u32;

/// A component of a value of the accelerometer, `i16` or `i32`, for a resampler with this number of weights.
pub trait Component<const WEIGHTS: usize>: Copy + Into<i32> {
    /// The number 0 of this type.
    const ZERO: Self;

    /// The sum of the values, oldest first, multiplied by their weights. `ahead` is the time from the output to the newest value,
    /// less than one period.
    fn weighted_sum(values: &[[Self; 3]; WEIGHTS], ahead: u32) -> [i64; 3];
}

// Not generic, so that the functions are optimized as this crate, and not as the crate that uses them.
impl Component<TAPS> for i16 {
    const ZERO: Self = 0;

    fn weighted_sum(values: &[[Self; 3]; TAPS], ahead: u32) -> [i64; 3] {
        weighted_sum(values, &RESPONSE, ahead)
    }
}

impl Component<TAPS> for i32 {
    const ZERO: Self = 0;

    fn weighted_sum(values: &[[Self; 3]; TAPS], ahead: u32) -> [i64; 3] {
        weighted_sum(values, &RESPONSE, ahead)
    }
}

impl Component<TAPS_1000> for i32 {
    const ZERO: Self = 0;

    fn weighted_sum(values: &[[Self; 3]; TAPS_1000], ahead: u32) -> [i64; 3] {
        weighted_sum(values, &RESPONSE_1000, ahead)
    }
}

/// The resampler for the three components of a vector. The outputs have `FRACTION` more fractional bits than the values: 14 at most
/// for `i16`, 0 for `i32`. `WEIGHTS` is [`TAPS`] for a data rate of 833 Hz, [`TAPS_1000`] for 1000 Hz.
#[derive(Clone, Debug)]
pub struct Resampler<V, const FRACTION: u32, const WEIGHTS: usize = TAPS> {
    /// The last values, the oldest first.
    values: [[V; 3]; WEIGHTS],
    /// The number of values since the start, `WEIGHTS` at most.
    filled: usize,
    /// The time from the next output to the newest value; negative before the output is due.
    ahead: i32,
    /// The time between two outputs at the stated data rate.
    step: i32,
    /// What is added to `step`, because the clock of the accelerometer is not exact.
    correction: i32,
    /// The sum of the phase errors.
    drift: i32,
}

impl<V: Component<WEIGHTS>, const FRACTION: u32, const WEIGHTS: usize>
    Resampler<V, FRACTION, WEIGHTS>
{
    /// A resampler that is not started.
    pub const fn new() -> Self {
        Self {
            values: [[V::ZERO; 3]; WEIGHTS],
            filled: 0,
            ahead: 0,
            step: 0,
            correction: 0,
            drift: 0,
        }
    }

    /// Starts without values, for an accelerometer with a data rate in mHz, 200000 to 1048575.
    pub fn start(&mut self, rate: u32) {
        self.adjust(rate);
        self.restart();
    }

    /// Changes the data rate, in mHz as for [`start`](Self::start), and keeps the values.
    pub fn adjust(&mut self, rate: u32) {
        // Both sides of the fraction are divided by 16, so that the product fits into 32 bits.
        const SCALE: u32 = 1 << (PERIOD - 4);
        const UNIT: u32 = SAMPLE_RATE * 1000 / 16;
        let rate = rate.clamp(SAMPLE_RATE * 1000, u32::MAX >> (PERIOD - 4));
        self.step = (rate.wrapping_mul(SCALE) / UNIT) as i32;
        self.correction = 0;
        self.drift = 0;
    }

    /// Starts again without values, at the same data rate: after values that were lost.
    pub fn restart(&mut self) {
        self.filled = 0;
        self.ahead = -(1 << PERIOD);
    }

    /// Adjusts the rate of the outputs. Call it every [`SAMPLE_PERIOD`], after the values of this period.
    ///
    /// The loop has a damping of 1 and a time constant of 512 periods (2.6 s). A faster one would modulate vibration with its
    /// corrections.
    pub fn follow(&mut self) {
        if self.ahead < 0 {
            // The number of values since the last output, compared with that in the middle between two outputs.
            let error = self.ahead.wrapping_add(self.step / 2);
            self.drift = self.drift.saturating_add(error);
            self.correction = (error >> 8).wrapping_add(self.drift >> 18);
        }
    }

    /// Takes the next value of the accelerometer, within +-2^30. Returns an output if one is due; it can exceed the range of the
    /// values by 20 %. The first output needs as many values as there are weights.
    pub fn push(&mut self, value: [V; 3]) -> Option<I32x3> {
        let mut newer = value;
        for place in self.values.iter_mut().rev() {
            // Not `swap`, which is a loop for six bytes in size-optimized code: 3 us more for each value.
            newer = core::mem::replace(place, newer);
        }
        if self.filled < WEIGHTS {
            self.filled = self.filled.wrapping_add(1);
            if self.filled < WEIGHTS {
                return None;
            }
        }
        self.ahead = self.ahead.wrapping_add(1 << PERIOD);
        if self.ahead < 0 {
            return None;
        }
        let output = self.convolve(self.ahead as u32);
        let step = self.step.wrapping_add(self.correction);
        self.ahead = self.ahead.wrapping_sub(step);
        Some(output)
    }

    /// The time between two outputs, in 2^-16 periods of the accelerometer.
    pub fn interval(&self) -> u32 {
        self.step.wrapping_add(self.correction) as u32
    }

    /// The time from the last output to the newest value, in 2^-16 periods of the accelerometer. Call it before
    /// [`follow`](Self::follow).
    pub fn since_output(&self) -> i32 {
        self.ahead.wrapping_add(self.interval() as i32)
    }

    /// The sum of all values multiplied by their weights. `ahead` is less than one period.
    fn convolve(&self, ahead: u32) -> I32x3 {
        let shift = const { WEIGHT - FRACTION };
        let half = 1 << (shift - 1);
        let sums = V::weighted_sum(&self.values, ahead);
        let [x, y, z] = sums.map(|sum| (sum.wrapping_add(half) >> shift) as i32);
        I32x3 { x, y, z }
    }
}

/// The sum of the weights is rounded. The oldest value gets the rest, so that a constant passes exactly.
fn weighted_sum<V: Copy + Into<i32>, const WEIGHTS: usize>(
    values: &[[V; 3]; WEIGHTS],
    response: &[i16],
    ahead: u32,
) -> [i64; 3] {
    let first = (ahead >> POINT) as usize;
    let points = response.get(first..).unwrap_or_default();
    let fraction = (ahead & ((1 << POINT) - 1)) as i32;
    let (mut x, mut y, mut z) = (0, 0, 0);
    let mut rest = 1 << WEIGHT;
    for (&[vx, vy, vz], points) in values.iter().zip(points.chunks_exact(1 << POINTS)) {
        let &[here, next, ..] = points else { break };
        let here = i32::from(here);
        let difference = i32::from(next).wrapping_sub(here);
        let weight = (here << POINT).wrapping_add(difference.wrapping_mul(fraction));
        rest = i32::wrapping_sub(rest, weight);
        x = product(weight, vx).wrapping_add(x);
        y = product(weight, vy).wrapping_add(y);
        z = product(weight, vz).wrapping_add(z);
    }
    // There is an oldest value.
    let Some(&[vx, vy, vz]) = values.first() else {
        return [x, y, z];
    };
    [
        product(rest, vx).wrapping_add(x),
        product(rest, vy).wrapping_add(y),
        product(rest, vz).wrapping_add(z),
    ]
}

fn product<V: Into<i32>>(weight: i32, value: V) -> i64 {
    i64::from(weight).wrapping_mul(i64::from(value.into()))
}

impl<V: Component<WEIGHTS>, const FRACTION: u32, const WEIGHTS: usize> Default
    for Resampler<V, FRACTION, WEIGHTS>
{
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
