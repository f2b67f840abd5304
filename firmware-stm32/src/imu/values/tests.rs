//! At the figures of the ISM330DHCX: 4098 counts per g, 833 values per second, noise with a standard deviation of 5 counts.

use super::Values;
use crate::imu::ism330dhcx::counts::{self, FLOOR, FRACTION, WIDTH};
use crate::imu::mounting::Mounting;
use plumbline::angle::Angle;
use plumbline::measure::definition::perpendicular;
use plumbline::measure::low_pass::{Kind, LowPass};
use plumbline::measure::resampler::Resampler;
use std::f64::consts::TAU;

/// Counts per g.
const G: f64 = 4098.36;

/// Values per second.
const RATE: f64 = 833.375;

/// Random numbers.
struct Random(u64);

impl Random {
    /// Uniform, 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Noise of the part in counts.
    fn noise(&mut self) -> f64 {
        5.0 * ((0..12).map(|_| self.uniform()).sum::<f64>() - 6.0)
    }

    /// A value of this acceleration in g, with the noise.
    fn value(&mut self, g: [f64; 3]) -> [i32; 3] {
        g.map(|g| (g * G + self.noise()).round().clamp(-32768.0, 32767.0) as i32)
    }
}

/// 10 and 5 degrees.
const TILTED: [f64; 3] = [-0.1736, 0.0872, 0.9809];

/// X, Y, Z, and all of them.
const DIRECTIONS: [[f64; 3]; 4] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.6, 0.5, 0.62],
];

/// The angle in degrees that an error of 1 g in X or Y is near the horizontal.
const DEGREES: f64 = 57.3;

/// What is received of a value with a wrong bit in this axis.
fn inverted(mut value: [i32; 3], axis: usize, bit: u32) -> [i32; 3] {
    value[axis] = (value[axis] as i16 ^ 1 << bit).into();
    value
}

/// The values without wrong bits. The last two can be missing.
fn corrected(values: &[[i32; 3]]) -> Vec<[i32; 3]> {
    judged(values).0
}

/// The same, and the number of the value with which the values are known to be wrong.
fn judged(values: &[[i32; 3]]) -> (Vec<[i32; 3]>, Option<usize>) {
    let mut judged = Values::<FLOOR, WIDTH>::INITIAL;
    let (mut outputs, mut told) = (Vec::new(), None);
    for (number, value) in values.iter().enumerate() {
        assert!(!judged.push(*value), "no axis is stuck");
        if judged.are_wrong(false) {
            told = told.or(Some(number));
        }
        outputs.extend(std::iter::from_fn(|| judged.release()));
    }
    (outputs, told)
}

/// The difference of the sums of the values before and after, as an acceleration of the mean in g. The values are not wrong.
fn bias(values: &[[i32; 3]]) -> [f64; 3] {
    let mut sums = [0; 3];
    let (outputs, told) = judged(values);
    assert_eq!(told, None, "the values are right");
    for (output, value) in outputs.iter().zip(values) {
        for (sum, (output, value)) in sums.iter_mut().zip(output.iter().zip(value)) {
            *sum += i64::from(output - value);
        }
    }
    sums.map(|sum| sum as f64 / G / values.len() as f64)
}

/// Values with this vibration in g at this frequency in Hz, and what is received of them: each hundredth has a wrong bit, 0 to 15 in turn.
fn disturbed(g: f64, frequency: f64) -> [Vec<[i32; 3]>; 2] {
    let mut random = Random(1);
    let values: Vec<_> = (0..48_000)
        .map(|number| {
            let swing = g * (TAU * frequency * f64::from(number) / RATE).sin();
            random.value([TILTED[0] + swing, TILTED[1], TILTED[2] - swing])
        })
        .collect();
    let received = values.iter().enumerate().map(|(number, value)| {
        let (axis, bit) = (number / 100 % 3, number as u32 / 300 % 16);
        match number % 100 {
            50 => inverted(*value, axis, bit),
            _ => *value,
        }
    });
    let received = received.collect();
    [values, received]
}

#[test]
fn wrong_bit_leaves_an_error_of_the_floor_at_rest_and_a_small_one_under_vibration() {
    // In counts; 4098 are 1 g.
    let cases = [(0.0, 1.0, FLOOR), (1.0, 10.0, 256), (0.1, 50.0, 256)];
    for (g, frequency, limit) in cases.into_iter().chain([(0.5, 50.0, 512)]) {
        let [values, received] = disturbed(g, frequency);
        let mut largest = 0;
        for (output, value) in corrected(&received).iter().zip(values) {
            for (output, value) in output.iter().zip(value) {
                largest = largest.max((output - value).abs());
            }
        }
        println!("{g} g, {frequency} Hz: {largest} counts");
        assert!(largest <= limit, "{g} g, {frequency} Hz: {largest}");
    }
}

/// The angles in degrees behind a filter.
fn angles(values: &[[i32; 3]], kind: Kind, cutoff: u16) -> Vec<[f64; 2]> {
    let mut filter = LowPass::new();
    filter.tune(kind, cutoff).expect("a permitted frequency");
    let mut resampler = Resampler::<i16, FRACTION>::new();
    resampler.start(counts::data_rate(0));
    let outputs = values
        .iter()
        .filter_map(|value| resampler.push(value.map(|count| count as i16)));
    let ups = outputs.map(|output| filter.step(counts::acceleration(output, Mounting::ALIGNED)));
    ups.map(|up| {
        let angles = perpendicular(up);
        let degrees = |angle: Angle| f64::from(angle.0 as i32) * 360.0 / 2_f64.powi(32);
        [degrees(angles.x), degrees(angles.y)]
    })
    .collect()
}

/// Each filter of the GEMAC sensors at its fastest; the others average over more.
#[test]
fn wrong_bit_at_rest_changes_the_angle_by_0_06_degrees_at_most() {
    let filters = [
        (Kind::Butterworth, 25_000),
        (Kind::Butterworth, 2_000),
        (Kind::CriticallyDamped, 8_000),
        (Kind::Analog, 25_000),
    ];
    for (kind, cutoff) in filters {
        let mut largest = [0.0_f64; 2];
        for (corrects, largest) in [false, true].into_iter().zip(&mut largest) {
            for (axis, bit) in (0..3).flat_map(|axis| (0..16).map(move |bit| (axis, bit))) {
                let mut random = Random(7);
                let values: Vec<_> = (0..600).map(|_| random.value(TILTED)).collect();
                let mut received = values.clone();
                received[150] = inverted(values[150], axis, bit);
                if corrects {
                    received = self::corrected(&received);
                }
                let angles = [values, received].map(|values| angles(&values, kind, cutoff));
                for (right, wrong) in angles[0].iter().zip(&angles[1]) {
                    for (right, wrong) in right.iter().zip(wrong) {
                        *largest = largest.max((right - wrong).abs());
                    }
                }
            }
        }
        let [before, after] = largest;
        println!("{kind:?} {cutoff} mHz: {after:.3} deg, without correction {before:.1} deg");
        assert!(after <= 0.06, "{kind:?} {cutoff}: {after}");
    }
}

#[test]
fn vibration_keeps_the_angle_of_its_mean() {
    let mut random = Random(3);
    for g in [0.01, 0.1, 0.5, 2.0, 6.0] {
        for frequency in [3.0, 20.0, 77.0, 138.9, 208.3, 277.8, 400.0, 416.0] {
            for direction in DIRECTIONS {
                let values: Vec<_> = (0..8330)
                    .map(|number| {
                        let time = f64::from(number) / RATE;
                        // It begins and ends ten times.
                        let on = f64::from(u8::from(time % 1.0 < 0.5));
                        let swing = g * on * (TAU * frequency * time).sin();
                        let g = [0, 1, 2].map(|axis| TILTED[axis] + direction[axis] * swing);
                        random.value(g)
                    })
                    .collect();
                // The filters are tested with 0.5 g.
                let limit = if g > 0.5 { 0.03 * g } else { 0.02 };
                for bias in bias(&values).map(f64::abs) {
                    assert!(
                        bias * DEGREES <= limit,
                        "{direction:?}, {g} g, {frequency} Hz: {bias}"
                    );
                }
            }
        }
    }
}

/// Ten shocks a second, each a half sine of 1.5 to 20 ms: the shortest ones move one or two values. 0.06 degrees are left of those of 3 ms and
/// longer.
#[test]
fn shocks_of_3_ms_keep_the_angle_of_their_mean_and_shorter_ones_change_it_by_0_18_degrees_at_most()
{
    let mut random = Random(5);
    let durations = [(1.5, 0.18), (3.0, 0.06), (5.0, 0.06), (20.0, 0.06)];
    let shocks = DIRECTIONS.map(|direction| durations.map(|duration| (direction, duration)));
    for (direction, (milliseconds, limit)) in shocks.into_iter().flatten() {
        for g in [-6.0, -4.0, -1.0, 0.25, 0.5, 1.0, 2.0, 3.3, 4.0, 6.0] {
            let values: Vec<_> = (0..83_300)
                .map(|number| {
                    let time = f64::from(number) / RATE * 1000.0 % 100.3;
                    let shock = if time < milliseconds {
                        g * (TAU / 2.0 * time / milliseconds).sin()
                    } else {
                        0.0
                    };
                    random.value([0, 1, 2].map(|axis| TILTED[axis] + direction[axis] * shock))
                })
                .collect();
            for bias in bias(&values).map(f64::abs) {
                assert!(
                    bias * DEGREES <= limit,
                    "{direction:?}, {g} g, {milliseconds} ms: {bias}"
                );
            }
        }
    }
}

/// Each bit from 0.1 g on.
#[test]
fn wrong_bit_in_each_second_value_and_more_than_16_corrections_in_a_second_are_told() {
    for (period, latest) in [(2, 140), (12, 300), (20, 650)] {
        for (axis, bit) in (0..3).flat_map(|axis| (9..16).map(move |bit| (axis, bit))) {
            let mut random = Random(11);
            let mut received: Vec<_> = (0..1000).map(|_| random.value(TILTED)).collect();
            for value in received.iter_mut().skip(20).step_by(period) {
                *value = inverted(*value, axis, bit);
            }
            let told = judged(&received).1.unwrap_or(usize::MAX);
            assert!(told <= 20 + latest, "{period}, {axis}, {bit}: {told}");
        }
    }
}

#[test]
fn wrong_bit_in_each_axis_of_one_value_is_corrected() {
    for bits in [[14, 14, 14], [9, 12, 15], [13, 10, 11]] {
        let mut random = Random(13);
        let right: Vec<_> = (0..60).map(|_| random.value(TILTED)).collect();
        let mut received = right.clone();
        for (axis, bit) in bits.into_iter().enumerate() {
            received[30] = inverted(received[30], axis, bit);
        }
        for (output, value) in corrected(&received).iter().zip(&right) {
            for (output, value) in output.iter().zip(value) {
                assert!(output.abs_diff(*value) <= FLOOR as u32, "{bits:?}");
            }
        }
    }
}

/// Each run of bytes of a value, in the order of the line, at rest.
#[test]
fn value_with_bytes_of_an_open_line_is_corrected() {
    for (level, first) in [0x00, 0xFF].into_iter().flat_map(|level| {
        let all = 0..6;
        all.map(move |first| (level, first))
    }) {
        for last in first..6 {
            let mut random = Random(17);
            let right: Vec<_> = (0..60).map(|_| random.value(TILTED)).collect();
            let mut received = right.clone();
            for byte in first..=last {
                let value = &mut received[30][byte / 2];
                let mut bytes = (*value as i16).to_le_bytes();
                bytes[byte % 2] = level;
                *value = i16::from_le_bytes(bytes).into();
            }
            for (output, value) in corrected(&received).iter().zip(&right) {
                for (output, value) in output.iter().zip(value) {
                    // The curve has the noise of the values beside it.
                    let is_right = output.abs_diff(*value) <= FLOOR as u32 * 3 / 2;
                    assert!(is_right, "{level:02X}h, bytes {first} to {last}");
                }
            }
        }
    }
}

#[test]
fn value_that_is_held_is_not_used_after_a_gap() {
    let mut judged = Values::<FLOOR, WIDTH>::INITIAL;
    for value in [[0; 3], [1; 3], [9000; 3]] {
        judged.push(value);
        judged.release();
    }
    judged.restart();
    judged.push([5000; 3]);
    assert_eq!(judged.release(), Some([5000; 3]));
    assert_eq!(judged.release(), None);
}

#[test]
fn each_axis_that_does_not_change_is_told() {
    for stuck in 0..3 {
        let mut judged = Values::<FLOOR, WIDTH>::INITIAL;
        let found = (1..100).find(|number| {
            let mut value = [*number, -number, 2 * number];
            value[stuck] = 0;
            let found = judged.push(value);
            while judged.release().is_some() {}
            found
        });
        assert_eq!(found, Some(32), "axis {stuck}");
    }
}
