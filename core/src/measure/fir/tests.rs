//! Tests of the linear-phase filter: coefficients compared with the window formula, response of the coefficients and of sine
//! inputs, delay, settling and change of setting.

use super::*;
use crate::measure::ONE_G;
use crate::sweep::every;
use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use proptest::prelude::*;

/// The setting, its cut-off frequency in Hz, and the side lobes of its window in dB.
const SETTINGS: [(Cutoff, f64, f64); 4] = [
    (Cutoff::TenHertz, 10.0, 43.3),
    (Cutoff::FiveHertz, 5.0, 45.3),
    (Cutoff::OneHertz, 1.0, 50.5),
    (Cutoff::HalfHertz, 0.5, 50.5),
];

const RATE: f64 = 200.0;

const FULL: i32 = 2 * RANGE - 1;

fn design(cutoff: Cutoff) -> &'static Design {
    cutoff.design().unwrap()
}

fn tuned(cutoff: Cutoff) -> Fir {
    let mut filter = Fir::new();
    filter.tune(cutoff);
    filter
}

const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
    I32x3 { x, y, z }
}

/// One step with an input along Z. All axes are equal.
fn step(filter: &mut Fir, input: i32) -> i32 {
    filter.step(vector(0, 0, input)).z
}

/// The number of samples in a duration.
fn count(duration: Duration) -> usize {
    (duration.ticks() / SAMPLE_PERIOD.ticks()) as usize
}

#[test]
fn coefficients_are_symmetric_and_positive_with_sum_2_pow_17() {
    for (cutoff, ..) in SETTINGS {
        let coefficients = design(cutoff).coefficients;
        assert!(coefficients.len() <= LONGEST && coefficients.len() % 2 == 1);
        assert!(coefficients.iter().eq(coefficients.iter().rev()));
        assert!(coefficients.iter().all(|&c| c > 0));
        let sum: i32 = coefficients.iter().map(|&c| i32::from(c)).sum();
        assert_eq!(sum, 131_072, "{cutoff:?}");
    }
}

/// The window by its definition: the inverse transform of a Chebyshev polynomial.
fn dolph_chebyshev(length: usize, side_lobes: f64) -> Vec<f64> {
    let order = (length - 1) as f64;
    let x0 = (10f64.powf(side_lobes / 20.0).acosh() / order).cosh();
    let polynomial = |x: f64| {
        if x.abs() <= 1.0 {
            (order * x.acos()).cos()
        } else {
            (order * x.abs().acosh()).cosh()
        }
    };
    let half = (length - 1) / 2;
    let window: Vec<f64> = (0..length)
        .map(|n| {
            let n = n as f64 - half as f64;
            (0..=half)
                .map(|k| {
                    let angle = PI * k as f64 / length as f64;
                    let weight = if k == 0 { 1.0 } else { 2.0 };
                    weight * polynomial(x0 * angle.cos()) * (2.0 * angle * n).cos()
                })
                .sum()
        })
        .collect();
    let sum: f64 = window.iter().sum();
    window.into_iter().map(|w| w / sum).collect()
}

#[test]
fn coefficients_are_dolph_chebyshev_windows() {
    for (cutoff, _, side_lobes) in SETTINGS {
        let coefficients = design(cutoff).coefficients;
        let window = dolph_chebyshev(coefficients.len(), side_lobes);
        for (n, (&coefficient, window)) in coefficients.iter().zip(window).enumerate() {
            // The middle one compensates the rounding of the others.
            let limit = if n == coefficients.len() / 2 {
                4.0
            } else {
                0.51
            };
            let error = f64::from(coefficient) - window * 131_072.0;
            assert!(error.abs() <= limit, "{cutoff:?} {n}: {error}");
        }
    }
}

/// The gain at `frequency` Hz of the coefficients and triangles.
fn gain(cutoff: Cutoff, frequency: f64) -> f64 {
    let Design {
        decimation,
        coefficients,
    } = design(cutoff);
    let decimation = f64::from(1 << decimation);
    let turn = PI * frequency / RATE;
    let triangle = ((turn * decimation).sin() / (decimation * turn.sin())).powi(2);
    let middle = (coefficients.len() / 2) as f64;
    let sum: f64 = coefficients
        .iter()
        .enumerate()
        .map(|(n, &c)| f64::from(c) * (2.0 * turn * decimation * (n as f64 - middle)).cos())
        .sum();
    triangle * triangle * sum / 131_072.0
}

#[test]
fn gain_at_cutoff_is_minus_3_db_within_0_1_percent_of_frequency() {
    for (cutoff, frequency, _) in SETTINGS {
        assert!(
            gain(cutoff, frequency * 0.999) > FRAC_1_SQRT_2,
            "{cutoff:?}"
        );
        assert!(
            gain(cutoff, frequency * 1.001) < FRAC_1_SQRT_2,
            "{cutoff:?}"
        );
    }
}

#[test]
fn gain_falls_in_pass_band_and_is_below_minus_40_db_from_3_2_times_cutoff() {
    for (cutoff, frequency, _) in SETTINGS {
        let mut last = 1.0;
        for percent in 1..=290 {
            let now = gain(cutoff, frequency * f64::from(percent) / 100.0);
            assert!(now < last, "{cutoff:?} {percent} %");
            last = now;
        }
        let stop = 3.2 * frequency;
        for i in 0..=20_000 {
            let at = stop + (100.0 - stop) * f64::from(i) / 20_000.0;
            assert!(gain(cutoff, at).abs() <= 0.01, "{cutoff:?} {at} Hz");
        }
    }
}

/// The settled response to a sine of 1 g: the part at the input frequency relative to the stated delay, in phase and in
/// quadrature, the largest value of the rest, and the peak of the output.
fn sine_response(cutoff: Cutoff, frequency: f64) -> (f64, f64, f64, f64) {
    let mut filter = tuned(cutoff);
    let turn = TAU * frequency / RATE;
    let skip = count(cutoff.settling());
    let delay = count(cutoff.delay());
    let length = 4_000;
    let outputs: Vec<f64> = (0..skip + length)
        .map(|n| {
            let input = (turn * n as f64).sin() * f64::from(ONE_G);
            f64::from(step(&mut filter, input.round() as i32)) / f64::from(ONE_G)
        })
        .collect();
    let wave = |n: usize| (turn * (n as f64 - delay as f64)).sin_cos();
    let settled = || (skip..skip + length).map(|n| (outputs[n], wave(n)));
    let sum = |f: fn(f64, (f64, f64)) -> f64| settled().map(|(y, w)| f(y, w)).sum::<f64>();
    // A fit of both waves, because they are not orthogonal over part of a period.
    let (ss, sc, cc) = (
        sum(|_, w| w.0 * w.0),
        sum(|_, w| w.0 * w.1),
        sum(|_, w| w.1 * w.1),
    );
    let (ys, yc) = (sum(|y, w| y * w.0), sum(|y, w| y * w.1));
    let determinant = ss * cc - sc * sc;
    let in_phase = (ys * cc - yc * sc) / determinant;
    let quadrature = (yc * ss - ys * sc) / determinant;
    let rest = settled()
        .map(|(y, w)| (y - in_phase * w.0 - quadrature * w.1).abs())
        .fold(0.0, f64::max);
    let peak = settled().map(|(y, _)| y.abs()).fold(0.0, f64::max);
    (in_phase, quadrature, rest, peak)
}

#[test]
fn sine_in_pass_band_has_gain_of_coefficients_and_stated_delay() {
    for (cutoff, frequency, _) in SETTINGS {
        for tenths in [1, 3, 5, 7, 9, 10, 12, 15, 20] {
            let at = frequency * f64::from(tenths) / 10.0 * 1.0003;
            let (in_phase, quadrature, rest, _) = sine_response(cutoff, at);
            assert!(
                (in_phase - gain(cutoff, at)).abs() < 2e-4,
                "{cutoff:?} {at} Hz: {in_phase}"
            );
            // Linear phase: besides the delayed sine there are only aliases, attenuated by 40 dB.
            assert!(quadrature.abs() < 2e-4, "{cutoff:?} {at} Hz: {quadrature}");
            assert!(rest <= 0.01, "{cutoff:?} {at} Hz: {rest}");
        }
    }
}

#[test]
fn sine_in_stop_band_is_attenuated_by_40_db() {
    for (cutoff, frequency, _) in SETTINGS {
        let stop = 3.2 * frequency;
        for i in (0..=400).step_by(every(25)) {
            let at = stop + (99.9 - stop) * f64::from(i) / 400.0;
            let (.., peak) = sine_response(cutoff, at);
            assert!(peak <= 0.01, "{cutoff:?} {at} Hz: {peak}");
        }
    }
}

#[test]
fn delay_and_settling_match_documentation() {
    let milliseconds = |duration: Duration| duration.ticks() / 1000;
    let stated = [
        (Cutoff::Off, 0, 0),
        (Cutoff::TenHertz, 30, 65),
        (Cutoff::FiveHertz, 70, 145),
        (Cutoff::OneHertz, 390, 785),
        (Cutoff::HalfHertz, 790, 1585),
    ];
    for (cutoff, delay, settling) in stated {
        assert_eq!(milliseconds(cutoff.delay()), delay);
        assert_eq!(milliseconds(cutoff.settling()), settling);
    }
}

#[test]
fn step_response_has_no_overshoot_and_settles_exactly() {
    for (cutoff, ..) in SETTINGS {
        // The step comes at each position in a block of decimated samples.
        for phase in 0..16 {
            let mut filter = tuned(cutoff);
            for _ in 0..phase + 1 {
                assert_eq!(step(&mut filter, -1234), -1234);
            }
            let mut last = -1234;
            let (delay, settling) = (count(cutoff.delay()), count(cutoff.settling()));
            for n in 0..settling {
                let output = step(&mut filter, ONE_G);
                assert!(output >= last, "{cutoff:?} {n}");
                if n + 1 < delay {
                    assert!(output < ONE_G / 2);
                }
                if n > delay {
                    assert!(output > ONE_G / 2);
                }
                last = output;
            }
            assert_eq!(last, ONE_G, "{cutoff:?}");
            for _ in 0..100 {
                assert_eq!(step(&mut filter, ONE_G), ONE_G);
            }
        }
    }
}

#[test]
fn input_beyond_16_g_is_limited() {
    for (cutoff, ..) in SETTINGS {
        let mut filter = tuned(cutoff);
        for input in [FULL, i32::MIN, i32::MAX, -2 * RANGE] {
            let output = (0..count(cutoff.settling()))
                .map(|_| step(&mut filter, input))
                .last();
            assert_eq!(output, Some(input.clamp(-2 * RANGE, FULL)));
        }
    }
    let mut off = Fir::new();
    assert_eq!(step(&mut off, i32::MIN), -2 * RANGE);
}

#[test]
fn filter_off_passes_each_vector_at_once() {
    let mut filter = Fir::new();
    for v in [vector(1, 2, 3), vector(-ONE_G, 0, ONE_G)] {
        assert_eq!(filter.step(v), v);
    }
}

#[test]
fn axes_are_independent() {
    for (cutoff, ..) in SETTINGS {
        let mut combined = tuned(cutoff);
        let mut single = [tuned(cutoff), tuned(cutoff), tuned(cutoff)];
        for n in 0..400i32 {
            let inputs = [n * 1_000_003, n * n * 777, -n * 99_991];
            let [x, y, z] = inputs;
            let separate: Vec<i32> = single
                .iter_mut()
                .zip(inputs)
                .map(|(filter, input)| step(filter, input))
                .collect();
            assert_eq!(combined.step(vector(x, y, z)).to_array()[..], separate[..]);
        }
    }
}

#[test]
fn filter_size_is_below_400_bytes() {
    assert!(size_of::<Fir>() <= 400, "{}", size_of::<Fir>());
}

fn cutoffs() -> impl Strategy<Value = Cutoff> {
    prop::sample::select(vec![
        Cutoff::Off,
        Cutoff::TenHertz,
        Cutoff::FiveHertz,
        Cutoff::OneHertz,
        Cutoff::HalfHertz,
    ])
}

proptest! {
    #[test]
    fn constant_input_passes_exactly_from_first_sample(cutoff in cutoffs(), x: i32, y: i32, z: i32) {
        let mut filter = tuned(cutoff);
        let input = vector(x, y, z);
        let held = vector(held(x), held(y), held(z));
        for _ in 0..100 {
            prop_assert_eq!(filter.step(input), held);
        }
    }

    #[test]
    fn output_stays_within_range_of_inputs(cutoff in cutoffs(), inputs in prop::collection::vec(-FULL..FULL, 1..600)) {
        let mut filter = tuned(cutoff);
        let (low, high) = (*inputs.iter().min().unwrap(), *inputs.iter().max().unwrap());
        for input in inputs {
            let output = step(&mut filter, input);
            prop_assert!((low..=high).contains(&output));
        }
    }

    #[test]
    fn tune_continues_from_last_output(
        before in cutoffs(),
        after in cutoffs(),
        inputs in prop::collection::vec(-FULL..FULL, 1..400),
    ) {
        let mut filter = tuned(before);
        let mut last = 0;
        for input in inputs {
            last = step(&mut filter, input);
        }
        let mut same = filter.clone();
        filter.tune(after);
        if before == after {
            for input in [5, FULL, 7] {
                prop_assert_eq!(step(&mut filter, input), step(&mut same, input));
            }
        } else {
            // The output stays the same while the input is equal to it.
            for _ in 0..40 {
                prop_assert_eq!(step(&mut filter, last), last);
            }
        }
    }

    #[test]
    fn output_is_rounded_convolution(inputs in prop::collection::vec(-FULL..FULL, 13..60)) {
        // Without decimation, only the coefficients have an effect.
        let mut filter = tuned(Cutoff::TenHertz);
        let coefficients = design(Cutoff::TenHertz).coefficients;
        for (n, &input) in inputs.iter().enumerate() {
            let output = step(&mut filter, input);
            if n >= 12 {
                let exact: i64 = inputs[n - 12..=n].iter().zip(coefficients).map(|(&v, &c)| i64::from(v) * i64::from(c)).sum();
                prop_assert!((i64::from(output) * 131_072 - exact).abs() <= 65_536);
            }
        }
    }
}
