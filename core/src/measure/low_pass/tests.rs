//! Tests of the low-pass filter: settling, tuning, overshoot and internal overflow. The host tests compare the responses with
//! reference vectors.

use super::*;
use crate::measure::{ONE_G, RANGE};
use crate::sweep::every;
use proptest::prelude::*;

/// The largest signal. The magnitude of the lowest signal is one unit larger.
const FULL: i32 = RANGE - 1;

/// Cut-off frequencies over the complete range, in mHz.
const CUTOFFS: [u16; 12] = [
    100, 101, 137, 500, 1_000, 2_000, 3_333, 7_999, 8_000, 12_345, 20_000, 25_000,
];

/// All kinds with cut-off frequencies over the complete range. Without digital filter it is that of the element.
fn settings() -> impl Iterator<Item = (Kind, u16)> {
    let kinds = [Kind::Butterworth, Kind::CriticallyDamped];
    let digital = kinds.into_iter().flat_map(|kind| {
        let allowed = CUTOFFS
            .into_iter()
            .filter(move |f| kind.cutoffs().contains(f));
        allowed.map(move |cutoff| (kind, cutoff))
    });
    digital.chain([(Kind::Analog, 20_000)])
}

/// The second-order sections of a filter, and the coefficient from the band-pass to the low-pass integrator.
fn sections(kind: Kind, cutoff: u16) -> (Vec<Section>, i32) {
    match kind {
        Kind::Analog => (vec![ELEMENT], ELEMENT_LOW),
        _ => {
            let filter = design::butterworth(cutoff);
            (filter.sections.to_vec(), filter.low)
        }
    }
}

fn tuned(kind: Kind, cutoff: u16) -> LowPass {
    let mut filter = LowPass::new();
    filter.tune(kind, cutoff).unwrap();
    filter
}

const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
    I32x3 { x, y, z }
}

const fn along_x(x: i32) -> I32x3 {
    vector(x, 0, 0)
}

/// Samples in `periods` of the cut-off frequency.
fn samples(periods: u32, cutoff: u16) -> u32 {
    periods * 200_000 / u32::from(cutoff)
}

/// The same filter in i128 without overflow. It asserts that all intermediate values are in the range that the module
/// documentation states.
struct Model {
    chain: ModelChain,
    /// The largest state so far, as a fraction of 2^30.
    peak: f64,
}

enum ModelChain {
    Sections(Vec<Section>, i32, Vec<(i128, i128)>),
    Critical(i32, [i128; 8]),
}

impl Model {
    fn settled(kind: Kind, cutoff: u16, rest: i32) -> Self {
        let zero = 1i128 << 31;
        let rest = (i128::from(rest.clamp(-FULL - 1, FULL)) << 32) + zero;
        let chain = match kind {
            Kind::CriticallyDamped => {
                ModelChain::Critical(design::critically_damped(cutoff), [rest; 8])
            }
            _ => {
                let (sections, low) = sections(kind, cutoff);
                let states = vec![(0, rest); sections.len()];
                ModelChain::Sections(sections, low, states)
            }
        };
        Self { chain, peak: 0.0 }
    }

    /// Checks that a signal fits the multiplication, and returns it.
    fn signal(value: i128) -> i128 {
        i128::from(i32::try_from(value).expect("a signal fits 32 bits"))
    }

    fn state(&mut self, value: i128) -> i128 {
        let fraction = (value as f64 / 2f64.powi(62)).abs();
        assert!(fraction < 1.0, "a state of {fraction} * 2^30");
        self.peak = self.peak.max(fraction);
        value
    }

    fn step(&mut self, input: i32) -> i32 {
        let mut signal = i128::from(input.clamp(-FULL - 1, FULL));
        let mut chain = std::mem::replace(&mut self.chain, ModelChain::Critical(0, [0; 8]));
        match &mut chain {
            ModelChain::Sections(sections, to_low, states) => {
                // The difference of two states must fit into 64 bits.
                let word = |value: i128| i128::from(i64::try_from(value).expect("fits 64 bits"));
                for (section, (band, low)) in sections.iter().zip(states) {
                    let difference = word((signal << 32) + (1 << 31) - *low);
                    let half = ((i128::from(section.band) * difference) >> 32)
                        - ((i128::from(section.leak) * *band) >> 32);
                    let v1 = self.state(*band + half);
                    *band = self.state(v1 + half);
                    let half = (i128::from(*to_low) * v1) >> 32;
                    let v2 = self.state(*low + half);
                    *low = self.state(v2 + half);
                    signal = Self::signal(v2 >> 32);
                }
            }
            ModelChain::Critical(gain, states) => {
                for s in states {
                    let half = i128::from(*gain) * Self::signal(signal - (*s >> 32));
                    let v = self.state(*s + half);
                    *s = self.state(v + half);
                    signal = Self::signal(v >> 32);
                }
            }
        }
        self.chain = chain;
        signal as i32
    }
}

/// The responses of all internal signals of a filter of second-order sections to a unit impulse: for each section difference, v1, band
/// state, v2, low state.
fn impulse_responses(kind: Kind, cutoff: u16, length: usize) -> Vec<Vec<f64>> {
    let (sections, to_low) = sections(kind, cutoff);
    let q32 = 2f64.powi(-32);
    let mut nodes = vec![Vec::new(); 5 * sections.len()];
    let mut states = vec![(0.0, 0.0); sections.len()];
    for n in 0..length {
        let mut signal = if n == 0 { 1.0 } else { 0.0 };
        for (i, (section, (band, low))) in sections.iter().zip(&mut states).enumerate() {
            let difference = signal - *low;
            let half =
                f64::from(section.band) * q32 * difference - f64::from(section.leak) * q32 * *band;
            let v1 = *band + half;
            *band = v1 + half;
            let half = f64::from(to_low) * q32 * v1;
            let v2 = *low + half;
            *low = v2 + half;
            signal = v2;
            for (j, value) in [difference, v1, *band, v2, *low].into_iter().enumerate() {
                nodes[5 * i + j].push(value);
            }
        }
    }
    nodes
}

#[test]
fn input_is_limited_to_8_g() {
    for (kind, cutoff) in settings() {
        let mut filter = tuned(kind, cutoff);
        let over = vector(i32::MAX, i32::MIN, FULL + 1);
        assert_eq!(filter.step(over), vector(FULL, -FULL - 1, FULL));
    }
}

#[test]
fn without_digital_filter_gain_is_that_of_second_order_at_20_hz() {
    for (frequency, gain) in [
        (5.0, -0.015),
        (10.0, -0.239),
        (20.0, -3.010),
        (40.0, -14.150),
    ] {
        let mut filter = tuned(Kind::Analog, 20_000);
        let (mut sine, mut cosine) = (0.0, 0.0);
        for n in 0..4200 {
            let phase = std::f64::consts::TAU * frequency * f64::from(n) / 200.0;
            let output = filter.step(along_x((f64::from(ONE_G) * phase.sin()) as i32));
            if n >= 200 {
                sine += f64::from(output.x) * phase.sin();
                cosine += f64::from(output.x) * phase.cos();
            }
        }
        let peak = sine.hypot(cosine) / 2000.0 / f64::from(ONE_G);
        let db = 20.0 * f64::log10(peak);
        assert!((db - gain).abs() < 0.01, "{frequency} Hz: {db} dB");
    }
}

#[test]
fn without_digital_filter_cutoff_has_no_effect() {
    let mut filter = tuned(Kind::Analog, 100);
    let mut twin = filter.clone();
    for n in 0..100 {
        filter.tune(Kind::Analog, 100 + n).unwrap();
        let input = along_x(ONE_G / 100 * i32::from(n));
        assert_eq!(filter.step(input), twin.step(input));
    }
}

#[test]
fn ramp_is_late_by_the_stated_delay() {
    for (kind, cutoff) in settings().chain([(Kind::Off, 2_000)]) {
        let mut filter = tuned(kind, cutoff);
        let slope = 20_000;
        let mut late = 0;
        for n in 0..samples(20, cutoff).min(50_000) as i32 {
            let input = along_x(n * slope - FULL);
            late = input.x - filter.step(input).x;
        }
        let delay = f64::from(late) / f64::from(slope) * 5_000.0;
        let stated = f64::from(kind.delay(cutoff));
        // At 25 Hz the stated delay is 20 us too long.
        assert!(
            (delay - stated).abs() < 25.0 + stated * 1e-5,
            "{kind:?} {cutoff}: {delay} {stated}"
        );
    }
}

#[test]
fn filter_that_is_off_passes_each_vector() {
    for mut filter in [LowPass::new(), tuned(Kind::Off, 2_000)] {
        for n in 0..100 {
            let input = vector(ONE_G / 100 * n, if n % 2 == 0 { FULL } else { -FULL }, n);
            assert_eq!(filter.step(input), input);
        }
        // A filter that is switched on begins at the last vector.
        filter.tune(Kind::Butterworth, 500).unwrap();
        assert_eq!(filter.step(along_x(ONE_G / 2)).y.signum(), -1);
        filter.tune(Kind::Off, 500).unwrap();
        assert_eq!(filter.step(along_x(7)), along_x(7));
    }
}

#[test]
fn filter_starts_settled_at_first_vector() {
    let first = vector(123_456_789, -1, ONE_G);
    for (kind, cutoff) in settings() {
        let mut filter = tuned(kind, cutoff);
        for _ in 0..1000 {
            assert_eq!(filter.step(first), first, "{kind:?} {cutoff}");
        }
    }
}

#[test]
fn constant_input_settles_exactly_and_stays() {
    for (kind, cutoff) in settings() {
        let mut filter = tuned(kind, cutoff);
        for target in [
            vector(ONE_G, -ONE_G, 0),
            vector(1, -1, 7),
            vector(-FULL, FULL, -12_345),
            vector(0, 1, ONE_G + 1),
            vector(2, 0, ONE_G),
        ] {
            for _ in 0..samples(30, cutoff) {
                filter.step(target);
            }
            for _ in 0..samples(5, cutoff) {
                assert_eq!(filter.step(target), target, "{kind:?} {cutoff}");
            }
        }
    }
}

#[test]
fn critically_damped_filter_with_any_cutoff_does_not_overshoot() {
    for cutoff in Kind::CriticallyDamped.cutoffs().step_by(every(79)) {
        let mut filter = tuned(Kind::CriticallyDamped, cutoff);
        let mut last = filter.step(vector(-ONE_G, ONE_G, 0));
        let target = vector(ONE_G, -FULL, 100);
        for _ in 0..samples(8, cutoff) {
            let now = filter.step(target);
            assert!(
                last.x <= now.x && now.x <= target.x,
                "{cutoff} mHz: {now:?}"
            );
            assert!(
                last.y >= now.y && now.y >= target.y,
                "{cutoff} mHz: {now:?}"
            );
            assert!(
                last.z <= now.z && now.z <= target.z,
                "{cutoff} mHz: {now:?}"
            );
            last = now;
        }
        assert_eq!(last, target, "{cutoff} mHz");
    }
}

#[test]
fn cutoff_out_of_range_is_refused_and_changes_nothing() {
    for (kind, highest) in [
        (Kind::Off, 25_000),
        (Kind::Analog, 25_000),
        (Kind::Butterworth, 25_000),
        (Kind::CriticallyDamped, 8_000),
    ] {
        let mut filter = tuned(Kind::Butterworth, 777);
        filter.step(along_x(0));
        for _ in 0..50 {
            filter.step(along_x(ONE_G));
        }
        let mut twin = filter.clone();
        for cutoff in [0, 1, 99, highest + 1, u16::MAX] {
            assert_eq!(filter.tune(kind, cutoff), Err(OutOfRange));
        }
        for _ in 0..500 {
            assert_eq!(filter.step(along_x(ONE_G)), twin.step(along_x(ONE_G)));
        }
        assert_eq!(filter.tune(kind, 100), Ok(()));
        assert_eq!(filter.tune(kind, highest), Ok(()));
    }
}

#[test]
fn tune_with_same_setting_changes_nothing() {
    for (kind, cutoff) in settings() {
        let mut filter = tuned(kind, cutoff);
        filter.step(along_x(0));
        let mut twin = filter.clone();
        for n in 0..samples(4, cutoff).max(100) {
            if n % 3 == 0 {
                filter.tune(kind, cutoff).unwrap();
            }
            assert_eq!(filter.step(along_x(ONE_G)), twin.step(along_x(ONE_G)));
        }
    }
}

#[test]
fn tune_with_other_setting_continues_from_last_output() {
    let target = vector(ONE_G, -ONE_G / 2, 3);
    for (from, to) in settings().flat_map(|from| settings().map(move |to| (from, to))) {
        if from == to {
            continue;
        }
        let mut filter = tuned(from.0, from.1);
        filter.step(along_x(-ONE_G));
        let mut present = vector(0, 0, 0);
        for _ in 0..samples(1, from.1).min(500) {
            present = filter.step(target);
        }
        filter.tune(to.0, to.1).unwrap();
        // The output at rest stays the same. Then the output is that of a filter that has always had this setting.
        let mut twin = filter.clone();
        assert_eq!(twin.step(present), present, "{from:?} to {to:?}");
        let mut fresh = tuned(to.0, to.1);
        fresh.step(present);
        for _ in 0..20 {
            assert_eq!(
                filter.step(target),
                fresh.step(target),
                "{from:?} to {to:?}"
            );
        }
    }
}

#[test]
fn filter_tuned_before_first_vector_starts_settled_there() {
    let mut filter = tuned(Kind::Butterworth, 100);
    filter.tune(Kind::CriticallyDamped, 200).unwrap();
    filter.tune(Kind::Butterworth, 300).unwrap();
    assert_eq!(filter.step(along_x(ONE_G)), along_x(ONE_G));
}

#[test]
fn axes_are_filtered_equally_and_independently() {
    for (kind, cutoff) in settings() {
        let mut together = tuned(kind, cutoff);
        let mut apart = [(); 3].map(|()| tuned(kind, cutoff));
        for n in 0..300 {
            let v = vector(n * 1_000_003 % ONE_G, n * 700_001 % ONE_G, -n * 12_345);
            let one = [v.x, v.y, v.z];
            let alone: Vec<i32> = apart
                .iter_mut()
                .zip(one)
                .map(|(filter, value)| filter.step(along_x(value)).x)
                .collect();
            assert_eq!(together.step(v).to_array().to_vec(), alone);
        }
    }
}

#[test]
fn worst_case_input_of_each_internal_signal_does_not_overflow() {
    let mut peak = 0.0f64;
    let cutoffs = [
        100, 400, 1_000, 2_000, 4_000, 8_000, 12_000, 16_000, 20_000, 25_000,
    ];
    let digital = cutoffs.map(|cutoff| (Kind::Butterworth, cutoff));
    // The lowest frequencies take longest.
    let digital = digital.into_iter().skip(every(4) - 1);
    for (kind, cutoff) in digital.chain([(Kind::Analog, 20_000)]) {
        let length = samples(20, cutoff) as usize;
        for response in impulse_responses(kind, cutoff, length) {
            // Each input moves the signal in the same direction at the last sample.
            let mut model: Option<Model> = None;
            let mut filter = tuned(kind, cutoff);
            for &weight in response.iter().rev() {
                let input = if weight < 0.0 { -FULL - 1 } else { FULL };
                let model = model.get_or_insert_with(|| Model::settled(kind, cutoff, input));
                assert_eq!(
                    filter.step(along_x(input)).x,
                    model.step(input),
                    "{kind:?} {cutoff} mHz"
                );
            }
            peak = peak.max(model.unwrap().peak);
        }
    }
    // The worst-case input comes close to the bound.
    assert!(peak > 0.85, "{peak}");
}

fn any_setting() -> impl Strategy<Value = (Kind, u16)> {
    prop_oneof![
        (100..=25_000u16).prop_map(|f| (Kind::Butterworth, f)),
        (100..=8_000u16).prop_map(|f| (Kind::CriticallyDamped, f)),
        Just((Kind::Analog, 20_000)),
    ]
}

proptest! {
    #[test]
    fn any_sequence_of_inputs_and_tunings_does_not_overflow(
        first in any_setting(),
        runs in prop::collection::vec((any_setting(), prop::collection::vec((any::<i32>(), 1..200u32), 1..20)), 1..6),
    ) {
        let mut filter = tuned(first.0, first.1);
        let mut output = filter.step(along_x(0)).x;
        for ((kind, cutoff), inputs) in runs {
            // Settings that change nothing do not settle the filter.
            if (kind, cutoff) == (filter.kind, filter.cutoff) || (kind, filter.kind) == (Kind::Analog, Kind::Analog) {
                continue;
            }
            filter.tune(kind, cutoff).unwrap();
            let mut model = Model::settled(kind, cutoff, output);
            for (input, times) in inputs {
                for _ in 0..times {
                    output = filter.step(along_x(input)).x;
                    prop_assert_eq!(output, model.step(input));
                }
            }
        }
    }

    #[test]
    fn filter_after_any_input_settles_exactly(
        (kind, cutoff) in any_setting(),
        disturbance in prop::collection::vec(-FULL..=FULL, 1..100),
        target in -FULL..=FULL,
    ) {
        let mut filter = tuned(kind, cutoff.max(1_000));
        for input in disturbance {
            filter.step(along_x(input));
        }
        for _ in 0..samples(30, cutoff.max(1_000)) {
            filter.step(along_x(target));
        }
        for _ in 0..100 {
            prop_assert_eq!(filter.step(along_x(target)).x, target);
        }
    }
}
