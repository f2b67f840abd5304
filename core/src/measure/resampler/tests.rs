//! Tests of the resampler: times of the outputs, gain of the pass band and the stop band, range.

use super::*;
use crate::measure::{ONE_G, RANGE};
use crate::sweep::every;
use core::f64::consts::TAU;
use proptest::prelude::*;
use std::vec::Vec;

/// The nominal data rate in mHz, and the rates of oscillators with an error of 5 %.
const RATES: [u32; 3] = [791_706, 833_375, 875_044];

fn started(rate: u32) -> Resampler<i32, 0> {
    let mut resampler = Resampler::new();
    resampler.start(rate);
    resampler
}

/// The data rates with the 24 weights for 1000 Hz.
const RATES_1000: [u32; 3] = [950_000, 1_000_000, 1_048_575];

const fn at_x(x: i32) -> [i32; 3] {
    [x, 0, 0]
}

/// The outputs of `count` values of a signal in g, a function of the time in s, with their times. The time of an output is that
/// of the values that it represents: its delay is subtracted.
fn outputs(rate: u32, count: u32, signal: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    weighted_outputs::<TAPS>(rate, count, signal)
}

/// The same with this number of weights.
fn weighted_outputs<const WEIGHTS: usize>(
    rate: u32,
    count: u32,
    signal: impl Fn(f64) -> f64,
) -> Vec<(f64, f64)>
where
    i32: Component<WEIGHTS>,
{
    let period = 1000.0 / f64::from(rate);
    let mut resampler = Resampler::<i32, 0, WEIGHTS>::new();
    resampler.start(rate);
    let mut outputs = Vec::new();
    for place in 0..count {
        let value = signal(f64::from(place) * period) * f64::from(ONE_G);
        if let Some(output) = resampler.push(at_x(value.round() as i32)) {
            // The first output is at the time of the last value, 19, without its delay of 10 values, and the next ones follow every 5 ms.
            let time = outputs.len() as f64 * 0.005 + WEIGHTS as f64 / 2.0 * period;
            outputs.push((time, f64::from(output.x) / f64::from(ONE_G)));
        }
    }
    outputs
}

#[test]
fn output_after_a_restart_has_only_the_values_after_it() {
    let mut resampler = started(RATES[1]);
    for _ in 0..1000 {
        resampler.push(at_x(ONE_G));
    }
    resampler.restart();
    let outputs: Vec<_> = (0..TAPS).map(|_| resampler.push(at_x(-ONE_G))).collect();
    assert!(outputs[..TAPS - 1].iter().all(Option::is_none));
    let level = I32x3 {
        x: -ONE_G,
        y: 0,
        z: 0,
    };
    assert_eq!(outputs[TAPS - 1], Some(level));
}

#[test]
fn first_output_needs_twenty_values() {
    let mut resampler = started(833_375);
    for value in 1..20 {
        assert_eq!(resampler.push(at_x(value)), None);
    }
    assert!(resampler.push(at_x(20)).is_some());
}

#[test]
fn start_discards_values() {
    let mut resampler = started(833_375);
    while resampler.push(at_x(ONE_G)).is_none() {}
    resampler.start(833_375);
    for _ in 1..20 {
        assert_eq!(resampler.push(at_x(-ONE_G)), None);
    }
    assert_eq!(
        resampler.push(at_x(-ONE_G)),
        Some(I32x3 {
            x: -ONE_G,
            y: 0,
            z: 0
        })
    );
}

#[test]
fn any_rate_gives_200_outputs_per_second() {
    for rate in [200_000, 416_000, 791_706, 833_375, 875_044, 1_048_575] {
        let mut resampler = started(rate);
        let seconds = 100;
        let values = u64::from(rate) * seconds / 1000;
        let outputs = (0..values).filter(|_| resampler.push(at_x(0)).is_some());
        let expected = (values - 19) as f64 * 200_000.0 / f64::from(rate);
        let error = outputs.count() as f64 - expected;
        assert!(error.abs() <= 1.5, "{rate} mHz: {error}");
    }
}

/// Runs `seconds` with calls of `follow` that are late by up to 0.2 ms. `rate` is the data rate in Hz at a time in s. Checks that
/// there is one output between two calls after 4 s.
fn follow(stated: u32, phase: f64, seconds: u32, rate: impl Fn(f64) -> f64) {
    let mut resampler = started(stated);
    let mut next = phase * 0.0012;
    for period in 1..seconds * 200 {
        let late = f64::from(period * 7919 % 200) * 1e-6;
        let time = f64::from(period) * 0.005 + late;
        let mut outputs = 0;
        while next < time {
            outputs += usize::from(resampler.push(at_x(0)).is_some());
            next += 1.0 / rate(next);
        }
        resampler.follow();
        if period > 800 {
            assert_eq!(outputs, 1, "{stated} mHz, {phase}, {time} s");
        }
    }
}

#[test]
fn data_rate_with_error_of_0_15_percent_gives_one_output_per_period() {
    for stated in RATES {
        for error in [-1.5e-3, -0.7e-3, 0.0, 0.7e-3, 1.5e-3] {
            for phase in (0..10).step_by(every(5)) {
                let actual = f64::from(stated) / 1000.0 * (1.0 + error);
                follow(stated, f64::from(phase) / 10.0, 20, |_| actual);
            }
        }
    }
}

#[test]
fn data_rate_that_drifts_by_2_percent_gives_one_output_per_period() {
    for direction in [-1.0, 1.0] {
        let drift = |time: f64| 833.375 * (1.0 + direction * (0.02 * time / 300.0).min(0.02));
        follow(833_375, 0.5, 400, drift);
    }
}

#[test]
fn constant_vector_passes_exactly() {
    for rate in RATES {
        for level in [RANGE - 1, -RANGE, 1, -1, 12_345_678, 0] {
            let vector = [level, -(level / 2), level / 3];
            let mut resampler = started(rate);
            let mut outputs = (0..400).filter_map(|_| resampler.push(vector));
            let same = outputs.all(|output| output.to_array() == vector);
            assert!(same, "{rate} {level}");
        }
    }
}

#[test]
fn fraction_shifts_outputs() {
    let mut coarse = Resampler::<i16, 0>::new();
    let mut fine = Resampler::<i16, 14>::new();
    coarse.start(833_375);
    fine.start(833_375);
    for n in 0..1000 {
        let value = [i16::MAX, i16::MIN, (n * 7919_i32) as i16]
            .map(|v| if n % 50 < 25 { v } else { -1 - v });
        let outputs = coarse.push(value).zip(fine.push(value));
        for (coarse, fine) in outputs
            .into_iter()
            .flat_map(|(coarse, fine)| coarse.to_array().into_iter().zip(fine.to_array()))
        {
            assert!((fine - (coarse << 14)).abs() <= 1 << 13, "{coarse} {fine}");
        }
    }
}

#[test]
fn weights_are_symmetric_in_time() {
    for (response, weights) in [(&RESPONSE[..], TAPS), (&RESPONSE_1000, TAPS_1000)] {
        let (response, fill) = response.split_at(weights << POINTS | 1);
        assert!(response.iter().eq(response.iter().rev()));
        assert_eq!(fill, [0; 3]);
    }
}

#[test]
fn pass_band_has_stated_gain_and_a_delay_of_ten_values() {
    for rate in RATES {
        for frequency in 1..=25 {
            let signal = |time: f64| 0.5 * (TAU * f64::from(frequency) * time).sin();
            for (time, output) in outputs(rate, 2000, signal) {
                // 0.03 dB are 0.35 %, and the interpolation adds less than 0.03 %.
                let error = (output - signal(time)).abs();
                assert!(error < 0.5 * 0.0038, "{rate} {frequency} Hz: {error}");
            }
        }
    }
}

#[test]
fn stop_band_has_stated_attenuation() {
    for rate in RATES {
        for frequency in (160..=416).step_by(every(8)) {
            // The second phase is for frequencies that alias to 0 Hz.
            let peak = [0.0, 0.25].map(|phase| {
                let signal = |time: f64| (TAU * (f64::from(frequency) * time + phase)).sin();
                let outputs = outputs(rate, 2000, signal);
                outputs
                    .iter()
                    .fold(0.0, |peak: f64, (_, x)| peak.max(x.abs()))
            });
            let limit = if frequency < 185 { 1e-2 } else { 1e-3 };
            assert!(
                peak.iter().all(|&peak| peak < limit),
                "{rate} {frequency} Hz: {peak:?}"
            );
        }
    }
}

#[test]
fn bands_at_1000_hz_have_stated_gain() {
    let peak = |outputs: &[(f64, f64)]| {
        let sizes = outputs.iter().map(|(_, value)| value.abs());
        sizes.fold(0.0, f64::max)
    };
    for rate in RATES_1000 {
        for frequency in 1..=25 {
            let signal = |time: f64| 0.5 * (TAU * f64::from(frequency) * time).sin();
            for (time, output) in weighted_outputs::<TAPS_1000>(rate, 2000, signal) {
                // 0.03 dB are 0.35 %.
                let error = (output - signal(time)).abs();
                assert!(error < 0.5 * 0.0035, "{rate} {frequency} Hz: {error}");
            }
        }
        for frequency in (160..=500).step_by(every(4)) {
            let limit = if frequency < 185 { 1e-2 } else { 1.148e-3 };
            for phase in [0.0, 0.25] {
                let signal = |time: f64| (TAU * (f64::from(frequency) * time + phase)).sin();
                let peak = peak(&weighted_outputs::<TAPS_1000>(rate, 2000, signal));
                assert!(peak < limit, "{rate} {frequency} Hz: {peak}");
            }
        }
        for level in [RANGE - 1, -RANGE, 1] {
            let outputs =
                weighted_outputs::<TAPS_1000>(rate, 100, |_| f64::from(level) / f64::from(ONE_G));
            let expected = f64::from(level) / f64::from(ONE_G);
            assert!(
                outputs.iter().all(|(_, value)| *value == expected),
                "{rate} {level}"
            );
        }
    }
}

#[test]
fn measured_data_rate_replaces_the_nominal_one_without_a_gap() {
    for error in [-0.05, 0.03, 0.048] {
        let actual = 1000.0 * (1.0 + error);
        let mut resampler = Resampler::<i32, 0, TAPS_1000>::new();
        resampler.start(1_000_000);
        let (mut value, mut periods) = (0.0, Vec::new());
        for period in 1..2000 {
            let mut outputs = 0;
            while value / actual < f64::from(period) * 0.005 {
                outputs += usize::from(resampler.push(at_x(0)).is_some());
                value += 1.0;
            }
            if period == 256 {
                // Measured with an error of one value.
                resampler.adjust((actual * 1000.0 * (1.0 + 0.0008)) as u32);
            } else if period > 256 {
                resampler.follow();
            }
            periods.push(outputs);
        }
        assert!(periods[6..].iter().all(|outputs| *outputs <= 2), "{error}");
        assert!(
            periods[256 + 800..].iter().all(|outputs| *outputs == 1),
            "{error}"
        );
    }
}

#[test]
fn frequencies_between_the_bands_are_not_amplified() {
    for rate in RATES {
        // The largest sample of 80 Hz at 200 Hz can be 5 % below the peak.
        for (frequency, low, high) in [(80, 0.5, 0.65), (120, 0.08, 0.19)] {
            let signal = |time: f64| (TAU * f64::from(frequency) * time).sin();
            let outputs = outputs(rate, 4000, signal);
            let peak = outputs
                .iter()
                .fold(0.0, |peak: f64, (_, x)| peak.max(x.abs()));
            assert!((low..high).contains(&peak), "{rate} {frequency} Hz: {peak}");
        }
    }
}

#[test]
fn worst_case_input_exceeds_range_by_at_most_20_percent() {
    for (response, weights) in [(&RESPONSE[..], TAPS), (&RESPONSE_1000, TAPS_1000)] {
        for phase in 0..4 {
            let points = response[phase..].iter().step_by(4);
            let weights: Vec<i32> = points.map(|&w| w.into()).take(weights).collect();
            let (sum, magnitude) = weights
                .iter()
                .fold((0, 0), |(sum, magnitude), w| (sum + w, magnitude + w.abs()));
            assert!(magnitude * 10 < sum * 12, "{phase}: {magnitude} {sum}");
        }
    }
}

proptest! {
    #[test]
    fn any_input_and_rate_is_within_range(
        rate: u32,
        values in prop::collection::vec(prop::array::uniform3(-RANGE..=RANGE), 0..200),
    ) {
        let mut resampler = started(rate);
        for value in values {
            if let Some(output) = resampler.push(value) {
                for component in output.to_array() {
                    prop_assert!(f64::from(component).abs() < 1.2 * f64::from(RANGE));
                }
            }
        }
    }
}
