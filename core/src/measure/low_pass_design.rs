//! The coefficients of the low-pass filters from a cut-off frequency, calculated on the device with integers.
//!
//! With theta = pi fc / fs, the bilinear transform (prewarped, so that the cut-off frequency is exact) maps the cut-off to g =
//! tan(theta). All coefficients are functions of s = sin(theta) and c = cos(theta). These follow from the sine and cosine of the
//! double angle, which is below 45 deg: s c = sin(2 theta) / 2, s^2 = (1 - cos(2 theta)) / 2.
//!
//! ```text
//! Butterworth, section of damping k:   band = g / (1 + g (g + k))         = s c / (1 + k s c)
//!                                      leak = g (g + k) / (1 + g (g + k)) = (s^2 + k s c) / (1 + k s c)
//!                                         g = s c / c^2
//! critically damped, factor w:         gain = w g / (1 + w g)             = w s c / (c^2 + w s c)
//! ```
//!
//! All coefficients are below 1/2 if the sampling rate is at least eight times the cut-off frequency, so Q32 fits into an i32.
//! The response with these coefficients is within 1e-5 dB of the exact one in the pass band.

use super::SAMPLE_PERIOD;

/// The highest cut-off frequency of the Butterworth filter, in mHz.
pub(super) const BUTTERWORTH_MAX: u16 = 25_000;

/// The sampling rate in mHz.
const SAMPLE_RATE: u64 = 1_000_000_000 / SAMPLE_PERIOD.ticks();

const _: () = assert!(
    SAMPLE_RATE >= 8 * BUTTERWORTH_MAX as u64,
    "the sampling rate must be at least eight times the cut-off frequency"
);

/// 2 pi in Q60.
const TAU: u64 = 7_244_019_458_077_122_842;

/// 2 theta for a cut-off of 1 mHz, in Q46.
const ANGLE_PER_MHZ: u64 = (TAU / SAMPLE_RATE) >> 14;

/// 1 in Q31.
const ONE: u32 = 1 << 31;

/// The dampings of the four sections, 2 cos((2 i + 1) pi / 16), in Q30, highest damping first. So the input of each section is at
/// most the input range times the overshoot of the sections before it.
const DAMPINGS: [u32; 4] = [2_106_220_352, 1_785_567_396, 1_193_077_991, 418_953_276];

/// The ratio between the frequency of each of the eight poles of the critically damped filter and the cut-off frequency of the
/// filter, 1 / sqrt(2^(1/8) - 1) = 3.324, in Q29.
const POLE_FACTOR: u32 = 1_784_543_059;

/// One second-order section of a Butterworth filter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Section {
    /// From the input to the band-pass integrator, Q32.
    pub band: i32,
    /// From the band-pass integrator to itself, Q32; subtracted.
    pub leak: i32,
}

/// The section of the Butterworth filter of second order at 20 Hz (damping 2 cos(pi / 4)).
pub(super) const ELEMENT: Section = Section {
    band: 891_660_920,
    leak: 1_550_717_162,
};

/// From the band-pass to the low-pass integrator of [`ELEMENT`], Q32.
pub(super) const ELEMENT_LOW: i32 = 1_395_519_469;

/// A Butterworth filter of order 8.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Butterworth {
    /// The sections in the order in which the signal passes them.
    pub sections: [Section; 4],
    /// From the band-pass to the low-pass integrator, Q32; the same for all sections.
    pub low: i32,
}

/// The Butterworth filter of order 8 with its -3 dB point at `cutoff` mHz (100..=25000).
pub(super) fn butterworth(cutoff: u16) -> Butterworth {
    let Products { sc, s2, c2 } = products(cutoff);
    let sections = DAMPINGS.map(|k| {
        let ksc = ((u64::from(k) * u64::from(sc)) >> 30) as u32;
        let reciprocal = ratio(ONE, ONE.wrapping_add(ksc / 2));
        Section {
            band: high(sc, reciprocal) as i32,
            leak: high(s2.wrapping_add(ksc), reciprocal) as i32,
        }
    });
    Butterworth {
        sections,
        low: ratio(sc, c2) as i32,
    }
}

/// The gain, Q32, of the eight equal poles of a critically damped filter of order 8 with its -3 dB point at `cutoff` mHz
/// (100..=8000).
pub(super) fn critically_damped(cutoff: u16) -> i32 {
    let Products { sc, c2, .. } = products(cutoff);
    let wsc = ((u64::from(POLE_FACTOR) * u64::from(sc)) >> 29) as u32;
    ratio(wsc / 2, (c2 / 2).wrapping_add(wsc / 2)) as i32
}

/// Products of s = sin(theta) and c = cos(theta), all in Q32.
struct Products {
    sc: u32,
    s2: u32,
    c2: u32,
}

fn products(cutoff: u16) -> Products {
    let x = ((u64::from(cutoff) * ANGLE_PER_MHZ) >> 14) as u32; // 2 theta, Q32
    let u = high(x, x);
    // sin x = x (1 - u/6 (1 - u/20 (1 - u/42 (1 - u/72)))); the next term is below 2^-31.
    let sine = nest::<6>(u, nest::<20>(u, nest::<42>(u, nest::<72>(u, ONE))));
    // 1 - cos x = u/2 (1 - u/12 (1 - u/30 (1 - u/56 (1 - u/90))))
    let versine = nest::<12>(u, nest::<30>(u, nest::<56>(u, nest::<90>(u, ONE))));
    let s2 = high(u, versine) / 2;
    Products {
        sc: high(x, sine),
        s2,
        c2: s2.wrapping_neg(),
    }
}

/// One step of a nested power series: 1 - `u` / N * `inner`, with `u` in Q32 and the rest in Q31.
fn nest<const N: u32>(u: u32, inner: u32) -> u32 {
    ONE.wrapping_sub(high(u, inner) / N)
}

/// The upper half of the product: Qa times Q32 gives Qa.
fn high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

/// `a` / `b` in Q32, truncated, for `a` below `b`. Bit by bit, because the 64-bit division of the compiler would be larger than
/// the rest of this file.
#[inline(never)] // measured: smaller, and no answer takes longer
pub(super) fn ratio(a: u32, b: u32) -> u32 {
    let (mut rest, mut quotient) = (a, 0);
    for _ in 0..32 {
        let carry = rest >> 31 != 0;
        rest <<= 1;
        quotient <<= 1;
        if carry || rest >= b {
            rest = rest.wrapping_sub(b);
            quotient |= 1;
        }
    }
    quotient
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU as TAU_F64};

    const Q32: f64 = 4_294_967_296.0;

    fn tangent(cutoff: u16) -> f64 {
        (PI * f64::from(cutoff) / 200_000.0).tan()
    }

    #[test]
    fn constants_match_formulas() {
        assert_eq!(SAMPLE_RATE, 200_000);
        assert!((TAU as f64 / 2f64.powi(60) - TAU_F64).abs() < 1e-15);
        for (i, &k) in DAMPINGS.iter().enumerate() {
            let exact = 2.0 * ((2 * i + 1) as f64 * PI / 16.0).cos();
            assert!((f64::from(k) - exact * 2f64.powi(30)).abs() <= 0.5);
        }
        let factor = 1.0 / (2f64.powf(0.125) - 1.0).sqrt();
        assert!((f64::from(POLE_FACTOR) - factor * 2f64.powi(29)).abs() <= 0.5);
    }

    #[test]
    fn coefficients_are_within_eight_units_of_exact_arithmetic() {
        let check = |got: i32, exact: f64, cutoff: u16| {
            assert!(
                (f64::from(got) - exact * Q32).abs() <= 8.0,
                "{cutoff} mHz: {got} {}",
                exact * Q32
            );
        };
        for cutoff in 100..=25_000 {
            let g = tangent(cutoff);
            let filter = butterworth(cutoff);
            check(filter.low, g, cutoff);
            for (i, section) in filter.sections.iter().enumerate() {
                let k = 2.0 * ((2 * i + 1) as f64 * PI / 16.0).cos();
                let denominator = 1.0 + g * (g + k);
                check(section.band, g / denominator, cutoff);
                check(section.leak, g * (g + k) / denominator, cutoff);
            }
            if cutoff <= 8_000 {
                let wg = g / (2f64.powf(0.125) - 1.0).sqrt();
                check(critically_damped(cutoff), wg / (1.0 + wg), cutoff);
            }
        }
    }

    #[test]
    fn element_is_butterworth_filter_of_second_order_at_20_hz() {
        let (g, k) = (tangent(20_000), 2f64.sqrt());
        let denominator = 1.0 + g * (g + k);
        for (got, exact) in [
            (ELEMENT.band, g / denominator),
            (ELEMENT.leak, g * (g + k) / denominator),
            (ELEMENT_LOW, g),
        ] {
            assert!((f64::from(got) - exact * Q32).abs() <= 0.5, "{got}");
        }
    }

    /// The magnitude in dB at `frequency` Hz of the filters with their coefficients.
    fn magnitude(cutoff: u16, critically: bool, frequency: f64) -> f64 {
        // The half increment of a trapezoidal integrator is j w times its output.
        let w = (PI * frequency / 200.0).tan();
        let mut db = 0.0;
        if critically {
            let gain = f64::from(critically_damped(cutoff)) / Q32;
            let ratio = w / (gain / (1.0 - gain));
            db -= 80.0 * (1.0 + ratio * ratio).log10();
        } else {
            let filter = butterworth(cutoff);
            for section in filter.sections {
                let (band, leak) = (f64::from(section.band) / Q32, f64::from(section.leak) / Q32);
                let low = f64::from(filter.low) / Q32;
                // With the states eliminated, j w v1 = p (x - y) - (q - p low) v1 and j w y = low v1.
                let (p, q) = (band / (1.0 - leak), leak / (1.0 - leak));
                let (real, imaginary) = (p * low - w * w, w * (q - p * low));
                db -= 10.0 * ((real * real + imaginary * imaginary) / (p * low).powi(2)).log10();
            }
        }
        db
    }

    #[test]
    fn response_in_pass_band_is_within_1e_5_db_of_exact_one() {
        for cutoff in (100..=25_000u16).step_by(7) {
            let fc = f64::from(cutoff) / 1000.0;
            for tenth in 1..=10 {
                let f = fc * f64::from(tenth) / 10.0;
                let ratio = (PI * f / 200.0).tan() / tangent(cutoff);
                let exact = -10.0 * (1.0 + ratio.powi(16)).log10();
                let error = magnitude(cutoff, false, f) - exact;
                assert!(
                    error.abs() < 1e-5,
                    "Butterworth {cutoff} mHz at {f} Hz: {error:e} dB"
                );
                if cutoff <= 8_000 {
                    let exact = -80.0 * (1.0 + ratio * ratio * (2f64.powf(0.125) - 1.0)).log10();
                    let error = magnitude(cutoff, true, f) - exact;
                    assert!(
                        error.abs() < 1e-5,
                        "critical {cutoff} mHz at {f} Hz: {error:e} dB"
                    );
                }
            }
        }
    }
}
