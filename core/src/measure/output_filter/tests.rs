//! Tests of the output filter against both filters of the manual in double precision, one program cycle at a time.

use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;
use std::vec::Vec;

/// The unit of an angle in deg.
const UNIT: f64 = 360.0 / 4_294_967_296.0;

fn angle(degrees: f64) -> Angle {
    Angle((degrees / UNIT).round() as i64 as u32)
}

/// An angle in -180..180 deg.
fn degrees(angle: Angle) -> f64 {
    f64::from(angle.0 as i32) * UNIT
}

/// The filters of the manual: y = w y + (1 - w) x, then the mean of the last N values of y. N = 0: no moving average.
struct Reference {
    weight: f64,
    size: usize,
    state: f64,
    array: VecDeque<f64>,
}

impl Reference {
    fn at(weight: u16, size: u8, start: f64) -> Self {
        Self {
            weight: f64::from(weight) / 1000.0,
            size: size.into(),
            state: start,
            array: VecDeque::from(vec![start; size.into()]),
        }
    }

    fn cycle(&mut self, input: f64) -> f64 {
        self.state = self.weight * self.state + (1.0 - self.weight) * input;
        if self.size == 0 {
            return self.state;
        }
        self.array.pop_front();
        self.array.push_back(self.state);
        self.array.iter().sum::<f64>() / self.size as f64
    }

    /// The output at a reading: the one of the last of its cycles. `number` counts from 1.
    fn reading(&mut self, number: u32, input: f64) -> f64 {
        let cycles =
            |number: u32| u64::from(number) * u64::from(CYCLE_RATE) / u64::from(SAMPLE_RATE);
        let count = cycles(number) - cycles(number - 1);
        (0..count).map(|_| self.cycle(input)).last().unwrap()
    }
}

/// A filter with a full array, settled at `start`, and the number of readings that it took.
fn settled(weight: u16, size: u8, start: f64) -> (OutputFilter<1>, u32) {
    let mut filter = OutputFilter::INITIAL;
    filter.tune(weight, size);
    for _ in 0..50 {
        assert_eq!(filter.step([angle(start)]), [angle(start)]);
    }
    (filter, 50)
}

/// The largest difference from the reference in deg.
fn worst(weight: u16, size: u8, inputs: impl Iterator<Item = f64>) -> f64 {
    let mut inputs = inputs.peekable();
    let start = *inputs.peek().unwrap();
    let (mut filter, before) = settled(weight, size, start);
    let mut reference = Reference::at(weight, size, start);
    let mut worst = 0.0_f64;
    for (number, input) in inputs.enumerate() {
        let [output] = filter.step([angle(input)]);
        let expected = reference.reading(before + 1 + number as u32, input);
        let error = degrees(output - angle(expected)).abs();
        worst = worst.max(error);
    }
    worst
}

fn step_response() -> impl Iterator<Item = f64> {
    core::iter::once(0.0).chain(core::iter::repeat_n(100.0, 1000))
}

/// The seconds in which a step goes from 10 to 90 %, interpolated between the readings.
fn rise_time(weight: u16, size: u8) -> f64 {
    let (mut filter, _) = settled(weight, size, 0.0);
    let mut outputs = vec![0.0];
    outputs.extend((0..2000).map(|_| {
        let [output] = filter.step([angle(100.0)]);
        degrees(output)
    }));
    let crossing = |level: f64| {
        let place = outputs.iter().position(|output| *output >= level).unwrap();
        let (before, after) = (outputs[place - 1], outputs[place]);
        place as f64 + (level - after) / (after - before)
    };
    (crossing(90.0) - crossing(10.0)) / 200.0
}

#[test]
fn recursive_filter_alone_is_the_formula_of_the_manual() {
    for weight in [1, 10, 500, 900, 990, 998, 999] {
        let error = worst(weight, 0, step_response());
        assert!(error < 2e-5, "{weight}: {error:e} deg");
    }
}

#[test]
fn moving_average_alone_is_the_mean_of_the_array() {
    for size in [1, 6, 7, 8, 9, 50, 100, 249, 250] {
        let error = worst(0, size, step_response());
        assert!(error < 1e-5, "{size}: {error:e} deg");
    }
}

/// Only the oldest entry is not exact: of a part of its cycles, the mean of all is used.
#[test]
fn both_filters_in_series_are_those_of_the_manual() {
    for (weight, size, limit) in [
        (500, 20, 2.0),
        (900, 250, 0.3),
        (990, 100, 0.1),
        (999, 50, 0.02),
    ] {
        let error = worst(weight, size, step_response());
        assert!(error < limit, "{weight}, {size}: {error:e} deg of 100 deg");
    }
}

#[test]
fn rise_times_of_a_step_are_those_of_the_formulas() {
    for (size, seconds) in [(250, 0.140), (100, 0.056)] {
        let error = rise_time(0, size) / seconds - 1.0;
        assert!(error.abs() < 0.01, "{size}: {error}");
    }
    for weight in [980, 990, 995, 999] {
        let seconds = 9_f64.ln() / (1428.0 * -(f64::from(weight) / 1000.0).ln());
        let error = rise_time(weight, 0) / seconds - 1.0;
        assert!(error.abs() < 0.01, "{weight}: {error}");
    }
}

/// A reading is the input of all cycles since the one before, so the delay is 2.5 ms shorter than that of the formula of the manual.
#[test]
fn ramp_is_late_by_the_delay_of_the_formulas_minus_half_a_reading() {
    let cycle = 1000.0 / 1428.0;
    for (weight, size, delay) in [
        (0, 0, 0.0),
        (0, 100, 50.0 * cycle - 2.5),
        (0, 250, 125.0 * cycle - 2.5),
        (990, 0, -cycle / 0.99_f64.ln() - 2.5),
        (998, 0, -cycle / 0.998_f64.ln() - 2.5),
    ] {
        let (mut filter, _) = settled(weight, size, 0.0);
        // 0.05 deg in 5 ms, the mean of the last 2 s.
        let late = (1..=1600).map(|n| {
            let input = 0.05 * f64::from(n);
            input - degrees(filter.step([angle(input)])[0])
        });
        let late = late.skip(1200).sum::<f64>() / 400.0 / 0.05 * 5.0;
        assert!(
            (late - delay).abs() < 0.2,
            "{weight} {size}: {late} ms, {delay} ms"
        );
    }
}

#[test]
fn filters_that_are_off_change_nothing() {
    let mut filter = OutputFilter::INITIAL;
    filter.tune(0, 0);
    for input in [1, 0x8000_0000, u32::MAX, 0, 12_345].map(Angle) {
        assert_eq!(filter.step([input]), [input]);
    }
}

#[test]
fn weight_1000_holds_the_output() {
    let (mut filter, _) = settled(1000, 0, 12.34);
    for _ in 0..10_000 {
        assert_eq!(filter.step([angle(-70.0)]), [angle(12.34)]);
    }
    filter.tune(0, 0);
    assert_eq!(filter.step([angle(-70.0)]), [angle(-70.0)]);
    filter.tune(1000, 100);
    assert_eq!(filter.step([angle(5.0)]), [angle(-70.0)]);
}

/// An integer state of 0.01 deg would stop at 118.46 deg.
#[test]
fn slowest_filter_reaches_the_exact_angle_and_stays_there() {
    for (weight, size) in [(999, 0), (999, 250), (998, 7), (0, 250), (500, 3)] {
        let (mut filter, _) = settled(weight, size, 0.0);
        let target = angle(123.45);
        for _ in 0..6000 {
            filter.step([target]);
        }
        for _ in 0..100_000 {
            assert_eq!(filter.step([target]), [target], "{weight}, {size}");
        }
        assert_eq!(filter.axes[0].sum, 0);
        assert_eq!(filter.axes[0].oldest, 0);
    }
}

#[test]
fn step_across_360_degrees_is_a_small_step() {
    for (weight, size) in [(900, 0), (0, 250), (990, 100)] {
        let (mut filter, _) = settled(weight, size, -0.1);
        for _ in 0..200 {
            let [output] = filter.step([angle(0.1)]);
            assert!(degrees(output).abs() <= 0.1 + UNIT, "{weight}, {size}");
        }
    }
}

#[test]
fn axes_are_independent() {
    let mut both = OutputFilter::<2>::INITIAL;
    let mut single = [OutputFilter::<1>::INITIAL, OutputFilter::<1>::INITIAL];
    both.tune(950, 30);
    single.iter_mut().for_each(|filter| filter.tune(950, 30));
    for n in 0..100 {
        let inputs = [angle(f64::from(n)), angle(-2.0 * f64::from(n % 7))];
        let [x, y] = &mut single;
        let [[a], [b]] = [x.step([inputs[0]]), y.step([inputs[1]])];
        assert_eq!(both.step(inputs), [a, b]);
    }
}

#[test]
fn new_settings_keep_the_output() {
    let (mut filter, _) = settled(900, 250, 40.0);
    for (weight, size) in [
        (0, 100),
        (999, 1),
        (0, 250),
        (10, 0),
        (0, 50),
        (1000, 250),
        (0, 0),
    ] {
        filter.tune(weight, size);
        for _ in 0..60 {
            assert_eq!(filter.step([angle(40.0)]), [angle(40.0)]);
        }
    }
}

#[test]
fn smaller_array_is_the_mean_of_its_newest_cycles() {
    let (mut filter, _) = settled(0, 250, 0.0);
    for _ in 0..10 {
        filter.step([angle(10.0)]);
    }
    filter.tune(0, 7);
    assert_eq!(filter.step([angle(10.0)]), [angle(10.0)]);
}

proptest! {
    /// Rotations of up to half a turn between two readings, and changes of the size.
    #[test]
    fn sum_is_exact_after_any_inputs(
        inputs in proptest::collection::vec((any::<u32>(), 0..=255_u8, 0..=1100_u16), 1..200),
        end: u32,
    ) {
        let mut filter = OutputFilter::<1>::INITIAL;
        for (input, size, weight) in inputs {
            if size % 8 == 0 {
                filter.tune(weight, size);
            }
            filter.step([Angle(input)]);
            let entries: u32 = (1..filter.count)
                .map(|place| filter.entries[after(filter.first, place)].cycles)
                .sum();
            prop_assert_eq!(filter.filled, if filter.count == 0 { 0 } else { filter.rest + entries });
            prop_assert!(filter.filled <= filter.size && filter.count < ENTRIES);
        }
        filter.tune(0, 250);
        let outputs: Vec<_> = (0..50).map(|_| filter.step([Angle(end)])).collect();
        prop_assert_eq!(outputs[49], [Angle(end)]);
        prop_assert_eq!(filter.axes[0].sum, 0);
    }
}

#[test]
fn first_reading_after_a_gap_is_the_state() {
    for (weight, size) in [(999, 0), (0, 250), (998, 250)] {
        let (mut filter, _) = settled(weight, size, 10.0);
        assert_ne!(filter.step([angle(50.0)]), [angle(50.0)]);
        filter.restart();
        for _ in 0..100 {
            assert_eq!(filter.step([angle(-30.0)]), [angle(-30.0)]);
        }
    }
    let (mut filter, _) = settled(1000, 50, 10.0);
    filter.restart();
    assert_eq!(filter.step([angle(50.0)]), [angle(10.0)], "held");
}
