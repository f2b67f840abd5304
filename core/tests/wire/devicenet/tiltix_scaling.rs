//! The angles of the TILTIX compared with the formulas of the manual (5.1, "Implementation of scaling and inversion") and of the
//! decisions T10, T12, T14 and T15: inversion, scaling, preset, differential offset, and a change of the resolution.

use crate::tester::Tester;
use crate::tester::tiltix::{tiltix080, tiltix360};
use plumbline::node::Node;

/// The attributes of both axes.
const OPERATING: [u8; 2] = [0x73, 0x7B];
const PRESET: [u8; 2] = [0x74, 0x7C];
const ENABLE: [u8; 2] = [0x75, 0x7D];
const OFFSET: [u8; 2] = [0x76, 0x7E];
const DIFFERENTIAL: [u8; 2] = [0x77, 0x7F];
const DIAGNOSTIC: [u8; 2] = [0x78, 0x80];
const SLOPE: [u8; 2] = [0x72, 0x7A];
const RESOLUTION: u8 = 0x71;
const DELTA: u8 = 0x88;

const INVERT: u8 = 1;
const SCALE: u8 = 2;

const RESOLUTIONS: [i64; 3] = [10, 100, 1000];

/// The quotient to the nearest number, halves away from zero (T14).
fn round(number: i64, by: i64) -> i64 {
    number.signum() * ((2 * number.abs() + by) / (2 * by))
}

/// A sensor at rest, and the numbers that its angles follow from.
struct Sensor<N> {
    tester: Tester<N>,
    circular: bool,
    /// The measured angles in 0.01 deg.
    measured: [i64; 2],
    /// The resolution in 0.001 deg.
    resolution: i64,
    mode: [u8; 2],
    /// In units of the resolution.
    offset: [i64; 2],
    differential: [i64; 2],
}

impl<N: Node> Sensor<N> {
    fn new(tester: Tester<N>, circular: bool, measured: [i64; 2]) -> Self {
        Self {
            tester,
            circular,
            measured,
            resolution: 10,
            mode: [0; 2],
            offset: [0; 2],
            differential: [0; 2],
        }
    }

    fn put(&mut self, attribute: u8, size: usize, value: i64) {
        let bytes = value.to_le_bytes();
        let data: String = bytes[..size].iter().map(|it| format!("{it:02X}")).collect();
        let result = self.tester.set(attribute, &data);
        assert_eq!(result, Ok(()), "{attribute:02X} = {value}");
    }

    fn number(&mut self, attribute: u8) -> i64 {
        let text = self.tester.get(attribute).expect("an attribute");
        let byte = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).expect("a byte");
        let bytes: Vec<u8> = (0..text.len()).step_by(2).map(byte).collect();
        match *bytes {
            [a] => a.into(),
            [a, b] if self.circular => u16::from_le_bytes([a, b]).into(),
            [a, b] => i16::from_le_bytes([a, b]).into(),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]).into(),
            _ => panic!("{text}"),
        }
    }

    /// The lowest and the highest preset and differential offset (T6).
    fn limits(&self) -> (i64, i64) {
        if self.circular {
            (0, 360_000 / self.resolution - 1)
        } else {
            (-80_000 / self.resolution, 80_000 / self.resolution)
        }
    }

    /// A sum in a resolution as a word (T10).
    fn wrap(&self, sum: i64, resolution: i64) -> i64 {
        if self.circular {
            sum.rem_euclid(360_000 / resolution)
        } else {
            sum.clamp(-32_768, 32_767)
        }
    }

    /// The measured angle with its inversion, in 0.01 deg.
    fn angle(&self, axis: usize) -> i64 {
        if self.mode[axis] & INVERT != 0 {
            -self.measured[axis]
        } else {
            self.measured[axis]
        }
    }

    /// Offset, slope and diagnostic slope.
    fn expected(&self, axis: usize) -> [i64; 3] {
        let mut added = 0;
        if self.mode[axis] & SCALE != 0 {
            added = self.offset[axis] + self.differential[axis];
        }
        let sum = round(self.angle(axis) * 10, self.resolution) + added;
        let exact = self.angle(axis) + added * self.resolution / 10;
        let slope = self.wrap(sum, self.resolution);
        let diagnostic = if self.circular {
            self.wrap(exact, 10)
        } else if slope == sum {
            exact
        } else {
            slope * self.resolution / 10
        };
        [self.offset[axis], slope, diagnostic]
    }

    #[track_caller]
    fn check(&mut self, what: &str) {
        for axis in 0..2 {
            let attributes = [OFFSET[axis], SLOPE[axis], DIAGNOSTIC[axis]];
            let found = attributes.map(|attribute| self.number(attribute));
            assert_eq!(found, self.expected(axis), "axis {axis}, {what}");
        }
    }

    fn set_mode(&mut self, axis: usize, mode: u8) {
        self.put(OPERATING[axis], 1, mode.into());
        self.mode[axis] = mode;
    }

    /// Sets the preset value, and preset enable from 0 to 1 (T12).
    fn preset(&mut self, axis: usize, value: i64) {
        self.put(PRESET[axis], 2, value);
        self.put(ENABLE[axis], 1, 0);
        self.put(ENABLE[axis], 1, 1);
        let offset = value - round(self.angle(axis) * 10, self.resolution);
        self.offset[axis] = self.wrap(offset, self.resolution);
    }

    fn set_differential(&mut self, axis: usize, value: i64) {
        self.put(DIFFERENTIAL[axis], 2, value);
        self.differential[axis] = value;
    }

    /// Converts a number into another resolution (T14).
    fn converted(&self, number: i64, resolution: i64) -> i64 {
        self.wrap(round(number * self.resolution, resolution), resolution)
    }

    fn set_resolution(&mut self, resolution: i64) {
        self.put(RESOLUTION, 2, resolution);
        self.offset = self.offset.map(|it| self.converted(it, resolution));
        self.differential = self.differential.map(|it| self.converted(it, resolution));
        self.resolution = resolution;
    }
}

/// Runs a test with both models, which are inclined.
macro_rules! both {
    ($test:expr) => {{
        let mut tester = tiltix080(1);
        tester.tilt(12.34, -5.67);
        $test(Sensor::new(tester, false, [1234, -567]));
        let mut tester = tiltix360(1);
        tester.turn(123.47);
        $test(Sensor::new(tester, true, [12_347, 0]));
    }};
}

#[test]
fn operating_parameters_of_both_axes_are_independent() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for resolution in RESOLUTIONS {
            sensor.set_resolution(resolution);
            for axis in 0..2 {
                sensor.set_differential(axis, 10_000 / resolution);
            }
            for modes in 0..16 {
                sensor.set_mode(0, modes & 3);
                sensor.set_mode(1, modes >> 2);
                sensor.check(&format!("{resolution}, {modes}"));
            }
        }
    }
    both!(test);
}

#[test]
fn preset_sets_the_slope_at_every_resolution_and_in_every_mode() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for resolution in RESOLUTIONS {
            sensor.set_resolution(resolution);
            let (low, high) = sensor.limits();
            for (axis, slope) in SLOPE.into_iter().enumerate() {
                for mode in [0, SCALE, SCALE | INVERT, INVERT, SCALE] {
                    sensor.set_mode(axis, mode);
                    for value in [0, high, low, high / 2, 1] {
                        sensor.preset(axis, value);
                        sensor.check(&format!("{resolution}, mode {mode}, preset {value}"));
                        if mode & SCALE != 0 {
                            assert_eq!(sensor.number(slope), value);
                        }
                    }
                }
            }
        }
    }
    both!(test);
}

/// T10: a preset at one end of the range, the position at the other, and the differential offset. The diagnostic slope is then the
/// same angle as the word.
#[test]
fn sum_beyond_the_word_is_limited() {
    for (side, word, diagnostic) in [(1, "FF7F", "FF7F0000"), (-1, "0080", "0080FFFF")] {
        for (axis, turned) in [[89.0, 0.0], [0.0, 89.0]].into_iter().enumerate() {
            let tilt = |tester: &mut Tester<_>, side: i32| {
                let [x, y] = turned.map(|angle: f64| angle * f64::from(side));
                tester.tilt(x, y);
            };
            let mut tester = tiltix080(1);
            tilt(&mut tester, -side);
            let hundredths = |angle: f64| (angle * 100.0) as i64;
            let measured = turned.map(|angle| hundredths(angle) * i64::from(-side));
            let mut sensor = Sensor::new(tester, false, measured);
            sensor.set_mode(axis, SCALE);
            sensor.preset(axis, i64::from(side) * 8000);
            sensor.set_differential(axis, i64::from(side) * 8000);
            tilt(&mut sensor.tester, side);
            sensor.measured = measured.map(|angle| -angle);
            sensor.check("beyond the word");
            assert_eq!(sensor.tester.get(SLOPE[axis]).as_deref(), Ok(word));
            let read = sensor.tester.get(DIAGNOSTIC[axis]);
            assert_eq!(read.as_deref(), Ok(diagnostic));
            for resolution in RESOLUTIONS {
                sensor.set_resolution(resolution);
                sensor.check(&format!("{resolution}"));
            }
        }
    }
}

#[test]
fn only_the_change_of_preset_enable_from_0_to_1_sets_the_offset() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for axis in 0..2 {
            sensor.set_mode(axis, SCALE);
            sensor.put(PRESET[axis], 2, 500);
            sensor.check("the value alone");
            sensor.put(ENABLE[axis], 1, 0);
            sensor.check("0 to 0");
            sensor.preset(axis, 500);
            sensor.check("0 to 1");
            sensor.put(PRESET[axis], 2, 700);
            for value in [1, 0] {
                sensor.put(ENABLE[axis], 1, value);
                sensor.check("1 to 1, 1 to 0");
                assert_eq!(sensor.number(ENABLE[axis]), value);
            }
            sensor.set_differential(axis, 30);
            sensor.preset(axis, 700);
            sensor.check("repeated");
            assert_eq!(sensor.number(SLOPE[axis]), 730);
            sensor.set_mode(axis, SCALE | INVERT);
            sensor.check("the inversion keeps the offset");
            sensor.preset(axis, 700);
            sensor.check("with inversion");
            for mode in [0, SCALE] {
                sensor.set_mode(axis, mode);
                sensor.check("scaling off and on");
            }
        }
    }
    both!(test);
}

#[test]
fn differential_offset_is_added_over_its_whole_range() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for resolution in RESOLUTIONS {
            sensor.set_resolution(resolution);
            let (low, high) = sensor.limits();
            for axis in 0..2 {
                sensor.set_mode(axis, SCALE);
                // The last three: 360 deg.
                let turn = 360_000 / resolution - round(sensor.angle(axis) * 10, resolution);
                let values = [low, low / 2, -1, 0, 1, high / 3, high / 2, high - 1, high];
                for value in values.into_iter().chain([turn - 1, turn, turn + 1]) {
                    if (low..=high).contains(&value) {
                        sensor.set_differential(axis, value);
                        sensor.check(&format!("{resolution}: {value}"));
                    }
                }
                sensor.set_differential(axis, 0);
            }
        }
    }
    both!(test);
}

/// The ways from 0.01 deg through other resolutions.
const WAYS: [&[i64]; 4] = [
    &[100, 10],
    &[1000, 10],
    &[100, 1000, 100, 10],
    &[1000, 100, 10],
];

#[test]
fn new_resolution_rounds_presets_and_differential_offsets() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        let mut values = vec![
            0, 1, 4, 5, 6, 14, 15, 49, 50, 1234, 1235, 1244, 1245, 1250, 1251, 7949, 7950, 7999,
            8000,
        ];
        if sensor.circular {
            values.extend([
                12_345, 32_767, 32_768, 35_949, 35_950, 35_994, 35_995, 35_999,
            ]);
        } else {
            values.extend(values.clone().iter().map(|it| -it));
        }
        let attributes = [PRESET[0], PRESET[1], DIFFERENTIAL[0], DIFFERENTIAL[1]];
        for value in values {
            for way in WAYS {
                for attribute in attributes {
                    sensor.put(attribute, 2, value);
                }
                let mut expected = value;
                for &resolution in way {
                    expected = sensor.converted(expected, resolution);
                    sensor.put(RESOLUTION, 2, resolution);
                    sensor.resolution = resolution;
                    let found = attributes.map(|attribute| sensor.number(attribute));
                    assert_eq!(found, [expected; 4], "{value}: {way:?}");
                }
            }
        }
    }
    both!(test);
}

#[test]
fn new_resolution_rounds_the_cos_delta() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for value in 0..=200 {
            for way in WAYS {
                sensor.put(DELTA, 1, value);
                let mut expected = value;
                for &resolution in way {
                    expected = round(expected * sensor.resolution, resolution);
                    sensor.put(RESOLUTION, 2, resolution);
                    sensor.resolution = resolution;
                    assert_eq!(sensor.number(DELTA), expected, "{value}: {way:?}");
                }
            }
        }
    }
    both!(test);
}

#[test]
fn new_resolution_converts_the_offset_of_a_preset() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for axis in 0..2 {
            sensor.set_mode(axis, SCALE);
            for value in [0, 4567, 7995] {
                sensor.preset(axis, value);
                for resolution in [100, 1000, 10] {
                    sensor.set_resolution(resolution);
                    sensor.check(&format!("preset {value}, {resolution}"));
                }
            }
        }
    }
    both!(test);
}

#[test]
fn converted_limit_is_within_the_limits() {
    fn test<N: Node>(mut sensor: Sensor<N>) {
        for (first, second) in RESOLUTIONS
            .iter()
            .flat_map(|it| RESOLUTIONS.map(|to| (*it, to)))
        {
            for end in 0..2 {
                sensor.set_resolution(first);
                let limits = sensor.limits();
                sensor.put(PRESET[0], 2, [limits.0, limits.1][end]);
                sensor.set_resolution(second);
                let (low, high) = sensor.limits();
                let preset = sensor.number(PRESET[0]);
                assert!((low..=high).contains(&preset), "{first} {second} {preset}");
            }
        }
    }
    both!(test);
}
