//! The linear-phase low-pass filter on the up vector (ifm JN2101 manual 9.2: "digital FIR filter").
//!
//! Its coefficients are Dolph-Chebyshev windows. For a given cut-off frequency and attenuation, they have the shortest delay.
//! They are symmetric, so the delay is the same at all frequencies. They are positive, so the output is always between the
//! smallest and the largest input, without overshoot or overflow. Their sum is exactly 2^17, so a constant vector passes exactly.
//!
//! At 200 Hz, a cut-off frequency of 0.5 Hz would need 500 coefficients and memory for 500 vectors. The lower cut-off frequencies
//! are therefore filtered at a lower rate, once every `decimation` samples. A triangular mean (two running sums) comes before the
//! filter; its zeros are at the frequencies that alias into the pass band. Linear interpolation between the filtered vectors
//! comes after the filter. Both are symmetric and pass a constant vector exactly. Aliases and images are attenuated by at least
//! 40 dB.
//!
//! | cut-off, -3 dB | decimation | coefficients | delay  | settled after | at least 40 dB from |
//! |----------------|------------|--------------|--------|---------------|---------------------|
//! | 10 Hz          | 1          | 13           | 30 ms  | 65 ms         | 32 Hz               |
//! | 5 Hz           | 2          | 13           | 70 ms  | 145 ms        | 16 Hz               |
//! | 1 Hz           | 8          | 17           | 390 ms | 785 ms        | 3.2 Hz              |
//! | 0.5 Hz         | 16         | 17           | 790 ms | 1585 ms       | 1.6 Hz              |
//!
//! The cut-off frequencies are exact to 0.1 % relative to the actual sampling rate. "Settled after": the time from the last
//! change of the input until the output is exact.

use super::{I32x3, RANGE, SAMPLE_PERIOD};
use crate::time::Duration;

/// The cut-off frequency (-3 dB) of the filter.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cutoff {
    /// No filter: the vector passes unchanged.
    #[default]
    Off,
    /// 10 Hz, with a delay of 30 ms.
    TenHertz,
    /// 5 Hz, with a delay of 70 ms.
    FiveHertz,
    /// 1 Hz, with a delay of 390 ms.
    OneHertz,
    /// 0.5 Hz, with a delay of 790 ms.
    HalfHertz,
}

impl Cutoff {
    /// The delay of the output, equal at all frequencies.
    pub const fn delay(self) -> Duration {
        samples(self.delay_in_samples())
    }

    /// The time from the last change of the input until the output is constant.
    pub const fn settling(self) -> Duration {
        match self {
            Self::Off => samples(0),
            _ => samples(2 * self.delay_in_samples() + 1),
        }
    }

    /// Half of the length of the impulse response: both triangles and the coefficients between them.
    const fn delay_in_samples(self) -> u32 {
        match self.design() {
            None => 0,
            Some(design) => {
                let decimation = 1 << design.decimation;
                2 * (decimation - 1) + decimation * (design.coefficients.len() as u32 - 1) / 2
            }
        }
    }

    const fn design(self) -> Option<&'static Design> {
        match self {
            Self::Off => None,
            Self::TenHertz => Some(&TEN_HERTZ),
            Self::FiveHertz => Some(&FIVE_HERTZ),
            Self::OneHertz => Some(&ONE_HERTZ),
            Self::HalfHertz => Some(&HALF_HERTZ),
        }
    }
}

/// The design of one setting.
struct Design {
    /// One vector in 2^`decimation` is filtered.
    decimation: u32,
    /// A Dolph-Chebyshev window; the sum is 2^17.
    coefficients: &'static [i16],
}

/// Side lobes at -43.3 dB.
static TEN_HERTZ: Design = Design {
    decimation: 0,
    coefficients: &[
        1638, 3819, 7158, 11101, 14882, 17624, 18628, 17624, 14882, 11101, 7158, 3819, 1638,
    ],
};

/// Side lobes at -45.3 dB.
static FIVE_HERTZ: Design = Design {
    decimation: 1,
    coefficients: &[
        1443, 3602, 6973, 11051, 15026, 17938, 19006, 17938, 15026, 11051, 6973, 3602, 1443,
    ],
};

/// Side lobes at -50.5 dB.
static ONE_HERTZ: Design = Design {
    decimation: 3,
    coefficients: &AT_A_TWENTY_FIFTH,
};

/// Side lobes at -50.5 dB.
static HALF_HERTZ: Design = Design {
    decimation: 4,
    coefficients: &AT_A_TWENTY_FIFTH,
};

/// The cut-off frequency is 1/25 of the decimated rate.
static AT_A_TWENTY_FIFTH: [i16; LONGEST] = [
    710, 1689, 3321, 5524, 8116, 10775, 13096, 14682, 15246, 14682, 13096, 10775, 8116, 5524, 3321,
    1689, 710,
];

/// The maximum number of coefficients of a setting.
const LONGEST: usize = 17;

/// The base-2 logarithm of the sum of the coefficients.
const SUM: u32 = 17;

/// The filter on the three components of the up vector.
///
/// It starts settled at its first input vector. After [`tune`](Self::tune) it is settled at its last output vector. Size: about
/// 350 bytes.
///
/// ```
/// use plumbline::measure::{I32x3, ONE_G, fir::{Cutoff, Fir}};
///
/// let mut filter = Fir::new();
/// filter.tune(Cutoff::TenHertz);
/// let level = I32x3 { x: 0, y: 0, z: ONE_G };
/// assert_eq!(filter.step(level), level);
/// ```
#[derive(Clone, Debug)]
pub struct Fir {
    cutoff: Cutoff,
    /// The running sums of each axis.
    means: [Mean; 3],
    /// The number of samples in the running sums.
    phase: u32,
    /// The decimated vectors, the oldest at `oldest`. Only as many are used as there are coefficients.
    history: [[i32; 3]; LONGEST],
    oldest: usize,
    /// The filtered vector before the last one: the start of the interpolation.
    from: [i32; 3],
    /// The last filtered vector: the end of the interpolation.
    to: [i32; 3],
    /// The last output; None before the first step.
    output: Option<I32x3>,
}

/// The triangular mean of one axis, over two blocks of `decimation` samples. The weights rise from 0 in the older block and fall
/// to 1 in the newer block.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    /// The sum of the samples of this block.
    sum: i64,
    /// The sum of those sums: the samples with falling weights.
    falling: i64,
    /// The samples of the last block with rising weights.
    rising: i64,
}

impl Fir {
    /// A filter that is off.
    pub const fn new() -> Self {
        Self {
            cutoff: Cutoff::Off,
            means: [Mean {
                sum: 0,
                falling: 0,
                rising: 0,
            }; 3],
            phase: 0,
            history: [[0; 3]; LONGEST],
            oldest: 0,
            from: [0; 3],
            to: [0; 3],
            output: None,
        }
    }

    /// Sets the cut-off frequency. The output continues without a step. Setting the same value again has no effect.
    pub fn tune(&mut self, cutoff: Cutoff) {
        if cutoff == self.cutoff {
            return;
        }
        self.cutoff = cutoff;
        if let Some(output) = self.output {
            self.settle(output.to_array());
        }
    }

    /// Filters one vector (1 g = 2^26); call it once per [`SAMPLE_PERIOD`]. The output is rounded to nearest. The input is
    /// limited to +-16 g.
    pub fn step(&mut self, input: I32x3) -> I32x3 {
        let input = input.to_array().map(held);
        if self.output.is_none() {
            self.settle(input);
        }
        let output = match self.cutoff.design() {
            None => input,
            Some(design) => self.filter(design, input),
        };
        let [x, y, z] = output;
        let output = I32x3 { x, y, z };
        self.output = Some(output);
        output
    }

    /// Forgets the earlier vectors: the next one is as the first one. Call it when samples were missing: the last ones before can be wrong.
    pub fn forget(&mut self) {
        self.output = None;
    }

    fn filter(&mut self, design: &Design, input: [i32; 3]) -> [i32; 3] {
        for (mean, sample) in self.means.iter_mut().zip(input) {
            mean.sum = mean.sum.wrapping_add(i64::from(sample));
            mean.falling = mean.falling.wrapping_add(mean.sum);
        }
        self.phase = self.phase.wrapping_add(1);
        if self.phase >> design.decimation != 0 {
            self.phase = 0;
            let decimated = self
                .means
                .each_mut()
                .map(|mean| mean.end(design.decimation));
            self.from = self.to;
            self.to = self.convolve(design.coefficients, decimated);
        }
        let [fx, fy, fz] = self.from;
        let [tx, ty, tz] = self.to;
        let way = self.phase.wrapping_add(1) as i32;
        [
            between(fx, tx, way, design.decimation),
            between(fy, ty, way, design.decimation),
            between(fz, tz, way, design.decimation),
        ]
    }

    /// Replaces the oldest vector by `newest` and returns the sum of all vectors multiplied by their coefficients.
    ///
    /// The vectors are used in the order of the memory, and the coefficients are rotated accordingly.
    fn convolve(&mut self, coefficients: &[i16], newest: [i32; 3]) -> [i32; 3] {
        if let Some(place) = self.history.get_mut(self.oldest) {
            *place = newest;
        }
        self.oldest = self.oldest.wrapping_add(1);
        if self.oldest >= coefficients.len() {
            self.oldest = 0;
        }
        let (young, old) = self
            .history
            .split_at_checked(self.oldest)
            .unwrap_or_default();
        let mut sums = [1i64 << (SUM - 1); 3];
        // The oldest vector gets the first coefficient. The coefficients are symmetric, so the direction has no effect.
        let turned = coefficients.len().wrapping_sub(self.oldest);
        let (first, last) = coefficients.split_at_checked(turned).unwrap_or_default();
        add_products(&mut sums, old, first);
        add_products(&mut sums, young, last);
        sums.map(|sum| (sum >> SUM) as i32)
    }

    /// Sets the state to that after a constant input of `rest`.
    #[cold]
    fn settle(&mut self, rest: [i32; 3]) {
        let decimation = self.cutoff.design().map_or(0, |design| design.decimation);
        self.phase = 0;
        self.oldest = 0;
        self.history.fill(rest);
        self.from = rest;
        self.to = rest;
        // The weights 0, 1, 2 ... of a complete block.
        let rising = (1i64 << decimation).wrapping_mul((1 << decimation) - 1) >> 1;
        self.means = rest.map(|sample| Mean {
            rising: rising.wrapping_mul(i64::from(sample)),
            ..Mean::default()
        });
    }
}

impl Default for Fir {
    fn default() -> Self {
        Self::new()
    }
}

impl Mean {
    /// The mean of the present block and the one before, rounded to nearest. Starts the next block.
    fn end(&mut self, decimation: u32) -> i32 {
        // The sum of the weights of both blocks is the square of their length.
        let half = (1i64 << (2 * decimation)) >> 1;
        let weighted = self.rising.wrapping_add(self.falling).wrapping_add(half);
        *self = Self {
            rising: (self.sum << decimation).wrapping_sub(self.falling),
            ..Self::default()
        };
        (weighted >> (2 * decimation)) as i32
    }
}

fn add_products(sums: &mut [i64; 3], vectors: &[[i32; 3]], coefficients: &[i16]) {
    let [mut x, mut y, mut z] = *sums;
    for ([vx, vy, vz], &coefficient) in vectors.iter().zip(coefficients) {
        let product = |component: i32| i64::from(component).wrapping_mul(i64::from(coefficient));
        x = x.wrapping_add(product(*vx));
        y = y.wrapping_add(product(*vy));
        z = z.wrapping_add(product(*vz));
    }
    *sums = [x, y, z];
}

/// The point on the straight line from `from` to `to` after `way` of 2^`steps` steps, rounded to nearest.
fn between(from: i32, to: i32, way: i32, steps: u32) -> i32 {
    let difference = i64::from(to).wrapping_sub(i64::from(from));
    let half = (1i64 << steps) >> 1;
    let moved = difference.wrapping_mul(i64::from(way)).wrapping_add(half) >> steps;
    from.wrapping_add(moved as i32)
}

/// `component` limited to -16 g..16 g, without the upper limit.
fn held(component: i32) -> i32 {
    component.clamp(-2 * RANGE, 2 * RANGE - 1)
}

const fn samples(count: u32) -> Duration {
    Duration::from_ticks(SAMPLE_PERIOD.ticks() * count as u64)
}

#[cfg(test)]
mod tests;
