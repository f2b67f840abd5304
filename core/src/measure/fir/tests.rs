//! Tests of the linear-phase filter: the coefficients against the formula of their window, the response from the coefficients and
//! from sines that are fed in, delay, rest and change of setting.

use super::*;
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

const FULL: i32 = 4 * ONE_G - 1;

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

/// One step with an input along Z; the axes are alike.
fn step(filter: &mut Fir, input: i32) -> i32 {
    filter.step(vector(0, 0, input)).z
}

/// The number of samples in a duration.
fn count(duration: Duration) -> usize {
    (duration.ticks() / SAMPLE_PERIOD.ticks()) as usize
}

#[test]
fn the_coefficients_are_symmetric_positive_and_add_up_to_a_power_of_two() {
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
fn the_coefficients_are_dolph_chebyshev_windows() {
    for (cutoff, _, side_lobes) in SETTINGS {
        let coefficients = design(cutoff).coefficients;
        let window = dolph_chebyshev(coefficients.len(), side_lobes);
        for (n, (&coefficient, window)) in coefficients.iter().zip(window).enumerate() {
            // The one in the middle takes up the rounding of the others.
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

/// The gain at `frequency` Hz as coefficients and triangles make it.
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
fn the_gain_is_3_db_down_within_a_thousandth_of_the_cutoff_frequency() {
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
fn the_gain_falls_through_the_pass_band_and_stays_40_db_down_from_3_2_times_the_cutoff() {
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

/// The settled response to a sine of 1 g: its part with the input's frequency and the delay that the filter states, in phase and
/// in quadrature, and the largest of the rest. The whole output's peak last.
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
    // A fit of both waves, which over part of a period are not orthogonal.
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
fn sines_come_out_with_the_gain_of_the_coefficients_and_the_stated_delay() {
    for (cutoff, frequency, _) in SETTINGS {
        for tenths in [1, 3, 5, 7, 9, 10, 12, 15, 20] {
            let at = frequency * f64::from(tenths) / 10.0 * 1.0003;
            let (in_phase, quadrature, rest, _) = sine_response(cutoff, at);
            assert!(
                (in_phase - gain(cutoff, at)).abs() < 2e-4,
                "{cutoff:?} {at} Hz: {in_phase}"
            );
            // Linear phase: nothing is left beside the delayed sine, other than what the lower rate folds, 40 dB down.
            assert!(quadrature.abs() < 2e-4, "{cutoff:?} {at} Hz: {quadrature}");
            assert!(rest <= 0.01, "{cutoff:?} {at} Hz: {rest}");
        }
    }
}

#[test]
fn sines_in_the_stop_band_are_40_db_down_whatever_they_are_folded_to() {
    for (cutoff, frequency, _) in SETTINGS {
        let stop = 3.2 * frequency;
        for i in 0..400 {
            let at = stop + (99.9 - stop) * f64::from(i) / 400.0;
            let (.., peak) = sine_response(cutoff, at);
            assert!(peak <= 0.01, "{cutoff:?} {at} Hz: {peak}");
        }
    }
}

#[test]
fn delay_and_settling_are_as_documented() {
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
fn a_step_never_overshoots_is_half_way_after_the_delay_and_settles_to_the_last_bit() {
    for (cutoff, ..) in SETTINGS {
        // The step comes at every place in a block of decimated samples.
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
fn the_ends_of_the_range_pass() {
    for (cutoff, ..) in SETTINGS {
        let mut filter = tuned(cutoff);
        for input in [FULL, i32::MIN, i32::MAX, -4 * ONE_G] {
            let output = (0..count(cutoff.settling()))
                .map(|_| step(&mut filter, input))
                .last();
            assert_eq!(output, Some(input.clamp(-4 * ONE_G, FULL)));
        }
    }
    let mut off = Fir::new();
    assert_eq!(step(&mut off, i32::MIN), -4 * ONE_G);
}

#[test]
fn off_passes_every_vector_at_once() {
    let mut filter = Fir::new();
    for v in [vector(1, 2, 3), vector(-ONE_G, 0, ONE_G)] {
        assert_eq!(filter.step(v), v);
    }
}

#[test]
fn the_axes_do_not_mix() {
    for (cutoff, ..) in SETTINGS {
        let mut whole = tuned(cutoff);
        let mut single = [tuned(cutoff), tuned(cutoff), tuned(cutoff)];
        for n in 0..400i32 {
            let inputs = [n * 1_000_003, n * n * 777, -n * 99_991];
            let [x, y, z] = inputs;
            let apart: Vec<i32> = single
                .iter_mut()
                .zip(inputs)
                .map(|(filter, input)| step(filter, input))
                .collect();
            assert_eq!(whole.step(vector(x, y, z)).to_array()[..], apart[..]);
        }
    }
}

#[test]
fn the_filter_takes_less_than_400_bytes() {
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
    fn a_constant_passes_exactly_from_the_first_sample_on(cutoff in cutoffs(), x: i32, y: i32, z: i32) {
        let mut filter = tuned(cutoff);
        let input = vector(x, y, z);
        let held = vector(held(x), held(y), held(z));
        for _ in 0..100 {
            prop_assert_eq!(filter.step(input), held);
        }
    }

    #[test]
    fn the_output_stays_within_the_inputs(cutoff in cutoffs(), inputs in prop::collection::vec(-FULL..FULL, 1..600)) {
        let mut filter = tuned(cutoff);
        let (low, high) = (*inputs.iter().min().unwrap(), *inputs.iter().max().unwrap());
        for input in inputs {
            let output = step(&mut filter, input);
            prop_assert!((low..=high).contains(&output));
        }
    }

    #[test]
    fn a_change_of_setting_goes_on_from_the_output(
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
            // At rest where it was, for as long as the input is that too.
            for _ in 0..40 {
                prop_assert_eq!(step(&mut filter, last), last);
            }
        }
    }

    #[test]
    fn the_output_is_the_convolution_rounded(inputs in prop::collection::vec(-FULL..FULL, 13..60)) {
        // Without decimation there is nothing but the coefficients.
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
