//! The low-pass filter on the up vector (GEMAC manual 9.1 and technical data): digital filters of order 8, and the element of
//! second order at 20 Hz that the technical data specify "without digital filter".
//!
//! All filters are chains of trapezoidal integrators (state-variable form) with separate coefficients and state. The Butterworth
//! filter has four second-order sections, the critically damped filter eight equal first-order sections, and the element one
//! second-order section. Each section integrates
//! the difference between its input and its output in 64 bits, so it settles exactly at its input. The DC gain is therefore
//! exactly 1, independent of the rounding of the coefficients, and there is no limit cycle.
//!
//! Scaling: signals are i32 within +-2^29 (+-8 g, 1 g = 2^26), states i64 with 32 more fractional bits. States that are outputs
//! have an offset of 1/2, so their upper half is the output rounded to nearest. For any input, all internal signals and states
//! stay below 2^30 (the tests use the worst-case input of each), so the difference of two does not overflow.

use super::low_pass_design::{
    self as design, BUTTERWORTH_MAX, Butterworth, ELEMENT, ELEMENT_LOW, Section,
};
use super::{I32x3, saturated};
use core::ops::RangeInclusive;

/// The response of the filter.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// No filter: the output is the input.
    #[default]
    Off,
    /// Butterworth of second order at 20 Hz: what the GEMAC sensors have without digital filter.
    Analog,
    /// Butterworth of order 8: flat pass band, steep slope, overshoot 16 to 18 %.
    Butterworth,
    /// Critically damped of order 8: no overshoot.
    CriticallyDamped,
}

impl Kind {
    /// The permitted cut-off frequencies (-3 dB) of this kind, in mHz. The setting also exists while the filter is off.
    pub const fn cutoffs(self) -> RangeInclusive<u16> {
        match self {
            Self::Off | Self::Analog | Self::Butterworth => 100..=BUTTERWORTH_MAX,
            Self::CriticallyDamped => 100..=8_000,
        }
    }

    /// The delay in us for slow changes, with a permitted cut-off frequency in mHz. With time constants it is 8 tau = 0.383 / fc
    /// (critically damped) and 0.816 / fc (Butterworth). The digital filter has this multiplied by x / tan(x) with x = pi fc / fs, which
    /// is nearly 1 - x^2 / 3.
    pub const fn delay(self, cutoff: u16) -> u32 {
        let (product, correction) = match self {
            Self::Off => return 0,
            Self::Analog => return 10_881,
            Self::Butterworth => (815_800_000, 67),
            Self::CriticallyDamped => (383_050_000, 31),
        };
        let cutoff = if cutoff == 0 { 1 } else { cutoff as u32 };
        product / cutoff - cutoff * correction / 1000
    }
}

/// The cut-off frequency is not within [`Kind::cutoffs`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange;

/// The low-pass filter on the three components of the up vector.
///
/// It starts settled at its first input vector. After [`tune`](Self::tune) it is settled at its last output vector.
///
/// ```
/// use plumbline::measure::{I32x3, ONE_G, low_pass::{Kind, LowPass}};
///
/// let mut filter = LowPass::new();
/// filter.tune(Kind::CriticallyDamped, 2_000)?;
/// let level = I32x3 { x: 0, y: 0, z: ONE_G };
/// assert_eq!(filter.step(level), level);
/// # Ok::<(), plumbline::measure::low_pass::OutOfRange>(())
/// ```
#[derive(Clone, Debug)]
pub struct LowPass {
    kind: Kind,
    cutoff: u16,
    chain: Chain,
    /// The last output; None before the first step.
    output: Option<I32x3>,
}

/// The coefficients in force and the state of each axis.
#[derive(Clone, Debug)]
enum Chain {
    Off,
    Analog([Integrators; 3]),
    Butterworth(Butterworth, [[Integrators; 4]; 3]),
    /// The gain in Q32. Each section has one integrator.
    CriticallyDamped(i32, [[i64; 8]; 3]),
}

/// The state of one second-order section.
#[derive(Clone, Copy, Debug)]
struct Integrators {
    /// Output of the band-pass, 0 at rest.
    band: i64,
    /// Output of the low-pass, which is the output of the section.
    low: i64,
}

impl Integrators {
    const ZERO: Self = Self { band: 0, low: 0 };
}

impl LowPass {
    /// A filter that is off.
    pub const fn new() -> Self {
        Self {
            kind: Kind::Off,
            // Not a valid cut-off frequency; it makes all bits 0.
            cutoff: 0,
            chain: Chain::Off,
            output: None,
        }
    }

    /// Sets kind and cut-off frequency in mHz. The output continues without a step. Setting the same values again has no effect.
    /// On an error, nothing changes.
    ///
    /// The execution time is about that of five steps.
    pub fn tune(&mut self, kind: Kind, cutoff: u16) -> Result<(), OutOfRange> {
        if !kind.cutoffs().contains(&cutoff) {
            return Err(OutOfRange);
        }
        // Without digital filter, the cut-off frequency has no effect.
        let has_cutoff = !matches!(kind, Kind::Off | Kind::Analog);
        if kind == self.kind && (cutoff == self.cutoff || !has_cutoff) {
            return Ok(());
        }
        self.kind = kind;
        self.cutoff = cutoff;
        self.chain = match kind {
            Kind::Off => Chain::Off,
            Kind::Analog => Chain::Analog([Integrators::ZERO; 3]),
            Kind::Butterworth => {
                Chain::Butterworth(design::butterworth(cutoff), [[Integrators::ZERO; 4]; 3])
            }
            Kind::CriticallyDamped => {
                Chain::CriticallyDamped(design::critically_damped(cutoff), [[0; 8]; 3])
            }
        };
        if let Some(output) = self.output {
            self.settle(output);
        }
        Ok(())
    }

    /// Filters one vector; call it once per [`SAMPLE_PERIOD`](super::SAMPLE_PERIOD). The output is rounded to nearest. The input
    /// is limited to +-8 g. The Butterworth filter can overshoot: its output can be up to 1.81 times 8 g.
    pub fn step(&mut self, input: I32x3) -> I32x3 {
        let input = limit(input);
        if self.output.is_none() {
            self.settle(input);
        }
        let I32x3 { x, y, z } = input;
        let output = match &mut self.chain {
            Chain::Off => input,
            Chain::Analog([ax, ay, az]) => I32x3 {
                x: element(ax, x),
                y: element(ay, y),
                z: element(az, z),
            },
            Chain::Butterworth(filter, [ax, ay, az]) => I32x3 {
                x: butterworth(filter, ax, x),
                y: butterworth(filter, ay, y),
                z: butterworth(filter, az, z),
            },
            Chain::CriticallyDamped(gain, [ax, ay, az]) => I32x3 {
                x: critical(*gain, ax, x),
                y: critical(*gain, ay, y),
                z: critical(*gain, az, z),
            },
        };
        self.output = Some(output);
        output
    }

    /// Forgets the earlier vectors: the next one is as the first one. Call it when samples were missing: the last ones before can be wrong.
    pub fn forget(&mut self) {
        self.output = None;
    }

    /// Continues from this output, which is limited to +-8 g: the state is that after a constant input.
    pub fn restart(&mut self, output: I32x3) {
        self.output = Some(limit(output));
        self.settle(output);
    }

    /// Sets the state to that after a constant input of `rest`.
    ///
    /// `rest` is limited to +-8 g, because the bound on the states is valid only for this range.
    #[cold]
    fn settle(&mut self, rest: I32x3) {
        let rest = limit(rest).to_array().map(state);
        match &mut self.chain {
            Chain::Off => {}
            Chain::Analog(axes) => {
                for (section, rest) in axes.iter_mut().zip(rest) {
                    *section = Integrators { band: 0, low: rest };
                }
            }
            Chain::Butterworth(_, axes) => {
                for (sections, rest) in axes.iter_mut().zip(rest) {
                    sections.fill(Integrators { band: 0, low: rest });
                }
            }
            Chain::CriticallyDamped(_, axes) => {
                for (poles, rest) in axes.iter_mut().zip(rest) {
                    poles.fill(rest);
                }
            }
        }
    }
}

impl Default for LowPass {
    fn default() -> Self {
        Self::new()
    }
}

/// `vector` with each component limited to -8 g..8 g.
fn limit(vector: I32x3) -> I32x3 {
    I32x3 {
        x: saturated(vector.x),
        y: saturated(vector.y),
        z: saturated(vector.z),
    }
}

/// The state of an output of `value`: 32 fractional bits and 1/2.
fn state(value: i32) -> i64 {
    (i64::from(value) << 32) | (1 << 31)
}

/// The upper half of a state: an output rounded to nearest.
fn output(state: i64) -> i32 {
    (state >> 32) as i32
}

/// A coefficient in Q32 times an output, as a state.
fn product(coefficient: i32, signal: i32) -> i64 {
    i64::from(coefficient).wrapping_mul(i64::from(signal))
}

/// A non-negative coefficient in Q32 times a state, rounded down.
fn scaled(coefficient: i32, state: i64) -> i64 {
    let fraction = u64::from(coefficient as u32).wrapping_mul(u64::from(state as u32)) >> 32;
    product(coefficient, output(state)).wrapping_add(fraction as i64)
}

/// One step of the element.
fn element(state: &mut Integrators, input: i32) -> i32 {
    pass(&ELEMENT, ELEMENT_LOW, state, input)
}

/// One step of the four sections. Not a loop, because a loop needs 30 more instructions for each vector.
fn butterworth(filter: &Butterworth, states: &mut [Integrators; 4], input: i32) -> i32 {
    let [first, second, third, fourth] = &filter.sections;
    let [s1, s2, s3, s4] = states;
    let signal = pass(first, filter.low, s1, input);
    let signal = pass(second, filter.low, s2, signal);
    let signal = pass(third, filter.low, s3, signal);
    pass(fourth, filter.low, s4, signal)
}

/// One step of a section. Each integrator takes half of its increment before it is read and half after (trapezoid).
///
/// The products include the fraction of a state. With rounded outputs, a section with low damping would have a limit cycle of one
/// or two units.
fn pass(section: &Section, to_low: i32, integrators: &mut Integrators, input: i32) -> i32 {
    let difference = state(input).wrapping_sub(integrators.low);
    let half =
        scaled(section.band, difference).wrapping_sub(scaled(section.leak, integrators.band));
    let band = integrators.band.wrapping_add(half);
    integrators.band = band.wrapping_add(half);

    let half = scaled(to_low, band);
    let low = integrators.low.wrapping_add(half);
    integrators.low = low.wrapping_add(half);
    output(low)
}

/// One step of the eight poles. Not a loop, because the compiler does not always unroll it.
fn critical(gain: i32, poles: &mut [i64; 8], input: i32) -> i32 {
    let [a, b, c, d, e, f, g, h] = poles;
    let signal = pole(gain, b, pole(gain, a, input));
    let signal = pole(gain, d, pole(gain, c, signal));
    let signal = pole(gain, f, pole(gain, e, signal));
    pole(gain, h, pole(gain, g, signal))
}

/// One step of a first-order section. Rounded outputs are sufficient here: a pole with a gain below 1/2 approaches its input from one
/// side.
fn pole(gain: i32, pole: &mut i64, input: i32) -> i32 {
    let half = product(gain, input.wrapping_sub(output(*pole)));
    let now = pole.wrapping_add(half);
    *pole = now.wrapping_add(half);
    output(now)
}

#[cfg(test)]
mod tests;
