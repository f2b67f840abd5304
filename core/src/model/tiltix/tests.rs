//! Tests of the words, the preset and the conversions of the TILTIX, without a protocol.

use super::tiltix080::Tiltix080Product;
use super::tiltix360::Tiltix360Product;
use super::*;
use crate::application::{Application, Faults, Values};
use crate::devicenet::Product;
use crate::measure::{I32x3, ONE_G, Reading};
use crate::param::{DataType, ParameterId, Parameters, Refused};
use crate::time::Instant;

const NOW: Instant = Instant::from_ticks(0);

/// An application with its parameters, as a node has them.
struct Sensor<X: Axes> {
    application: Tiltix<X>,
    parameters: Parameters<X>,
    values: Inclination,
}

impl<X: Axes> Sensor<X> {
    fn new() -> Self {
        let mut sensor = Self {
            application: Tiltix::INITIAL,
            parameters: Parameters::factory(),
            values: Inclination::INITIAL,
        };
        sensor.values = sensor.application.apply(NOW, &sensor.parameters);
        sensor.set(id::SIZE, 0).unwrap();
        sensor
    }

    fn set(&mut self, id: ParameterId, value: i32) -> Result<(), Refused> {
        let size = Parameters::<X>::row(id).unwrap().size();
        let raw = value as u32 & (u32::MAX >> (32 - 8 * u32::from(size)));
        Parameters::<X>::check(id, raw)?;
        Tiltix::<X>::write(id, raw, &self.values, &mut self.parameters)?;
        self.values = self.application.apply(NOW, &self.parameters);
        Ok(())
    }

    fn get(&self, id: ParameterId) -> i64 {
        let row = Parameters::<X>::row(id).unwrap();
        row.data_type().value(self.parameters.get(id))
    }

    /// At rest with these angles in deg.
    fn tilt(&mut self, up: [f64; 3]) -> &mut Self {
        let [x, y, z] = up.map(|part| (part * f64::from(ONE_G)).round() as i32);
        let reading = Reading {
            acceleration: I32x3 { x, y, z },
            ..Reading::default()
        };
        self.values = self.application.sample(NOW, &reading);
        self
    }

    /// Both words as a master reads them, and both diagnostic values.
    fn words(&self) -> [i64; 4] {
        let types = [
            X::RANGE.word(),
            X::RANGE.word(),
            DataType::I32,
            DataType::I32,
        ];
        let ids = value::SLOPE.into_iter().chain(value::DIAGNOSTIC);
        let mut words = [0; 4];
        for ((word, id), data_type) in words.iter_mut().zip(ids).zip(types) {
            let raw = self.values.number(id) & (u32::MAX >> (32 - 8 * u32::from(data_type.size())));
            *word = data_type.value(raw);
        }
        words
    }
}

/// The up vector of a 2-axis sensor with these perpendicular angles in deg.
fn two(x: f64, y: f64) -> [f64; 3] {
    let (x, y) = (x.to_radians().sin(), y.to_radians().sin());
    [-x, y, (1.0 - x * x - y * y).sqrt()]
}

/// The up vector of a 1-axis sensor with this angle in deg.
fn one(angle: f64) -> [f64; 3] {
    let (x, y) = angle.to_radians().sin_cos();
    [x, y, 0.0]
}

type Tiltix080 = Sensor<Tiltix080Product>;
type Tiltix360 = Sensor<Tiltix360Product>;

#[test]
fn words_follow_the_resolution_with_halves_away_from_zero() {
    let mut sensor = Tiltix080::new();
    sensor.tilt(two(12.34, -5.67));
    assert_eq!(sensor.words(), [1234, -567, 1234, -567]);
    sensor.set(id::RESOLUTION, 100).unwrap();
    assert_eq!(sensor.words(), [123, -57, 1234, -567]);
    sensor.set(id::RESOLUTION, 1000).unwrap();
    assert_eq!(sensor.words(), [12, -6, 1234, -567]);
    sensor.tilt(two(12.50, -12.50));
    assert_eq!(sensor.words(), [13, -13, 1250, -1250]);
    sensor.tilt(two(12.49, -12.49));
    assert_eq!(sensor.words(), [12, -12, 1249, -1249]);
}

#[test]
fn words_of_the_360_model_are_unsigned_and_wrap_after_rounding() {
    let mut sensor = Tiltix360::new();
    assert_eq!(sensor.tilt(one(123.47)).words(), [12_347, 0, 12_347, 0]);
    assert_eq!(sensor.tilt(one(327.68)).words(), [32_768, 0, 32_768, 0]);
    sensor.set(id::RESOLUTION, 100).unwrap();
    assert_eq!(sensor.tilt(one(123.47)).words(), [1235, 0, 12_347, 0]);
    assert_eq!(sensor.tilt(one(359.96)).words(), [0, 0, 35_996, 0]);
    assert_eq!(sensor.tilt(one(359.94)).words(), [3599, 0, 35_994, 0]);
    sensor.set(id::RESOLUTION, 1000).unwrap();
    assert_eq!(sensor.tilt(one(327.68)).words(), [328, 0, 32_768, 0]);
    assert_eq!(sensor.tilt(one(359.5)).words(), [0, 0, 35_950, 0]);
}

#[test]
fn inversion_negates_the_measured_angle() {
    let mut sensor = Tiltix080::new();
    sensor.tilt(two(12.34, -5.67));
    sensor.set(id::OPERATING[0], 1).unwrap();
    assert_eq!(sensor.words(), [-1234, -567, -1234, -567]);
    let mut sensor = Tiltix360::new();
    sensor.tilt(one(123.47));
    sensor.set(id::OPERATING[0], 1).unwrap();
    assert_eq!(sensor.words(), [23_653, 0, 23_653, 0]);
    sensor.set(id::OPERATING[1], 1).unwrap();
    assert_eq!(sensor.tilt(one(0.0)).words(), [0; 4]);
}

#[test]
fn change_from_0_to_1_sets_the_offset_from_the_inverted_angle() {
    let mut sensor = Tiltix080::new();
    sensor.tilt(two(10.0, -20.0));
    sensor.set(id::OPERATING[0], 3).unwrap();
    sensor.set(id::PRESET[0], 500).unwrap();
    assert_eq!(sensor.get(id::OFFSET[0]), 0);
    sensor.set(id::PRESET_ENABLE[0], 1).unwrap();
    // 5.00 - 10.00 * -1
    assert_eq!(sensor.get(id::OFFSET[0]), 1500);
    assert_eq!(sensor.words(), [500, -2000, 500, -2000]);
    sensor.set(id::DIFFERENTIAL[0], -125).unwrap();
    assert_eq!(sensor.words()[0], 375);
    // 1 to 1 and 1 to 0 do nothing.
    sensor.tilt(two(20.0, 0.0));
    for value in [1, 0] {
        sensor.set(id::PRESET_ENABLE[0], value).unwrap();
        assert_eq!(sensor.get(id::PRESET_ENABLE[0]), value.into());
        assert_eq!(sensor.get(id::OFFSET[0]), 1500);
    }
    // Repeated: the preset value plus the differential offset again (T12).
    sensor.set(id::PRESET_ENABLE[0], 1).unwrap();
    assert_eq!(sensor.get(id::OFFSET[0]), 2500);
    assert_eq!(sensor.words()[0], 375);
}

#[test]
fn offsets_count_only_with_scaling() {
    let mut sensor = Tiltix080::new();
    sensor.tilt(two(10.0, -20.0));
    sensor.set(id::DIFFERENTIAL[1], 300).unwrap();
    sensor.set(id::PRESET_ENABLE[1], 1).unwrap();
    assert_eq!(sensor.get(id::OFFSET[1]), 2000);
    assert_eq!(sensor.words(), [1000, -2000, 1000, -2000]);
    sensor.set(id::OPERATING[1], 2).unwrap();
    assert_eq!(sensor.words(), [1000, 300, 1000, 300]);
}

#[test]
fn sums_of_the_360_model_are_modulo_360_degrees() {
    let mut sensor = Tiltix360::new();
    sensor.tilt(one(350.0));
    sensor.set(id::OPERATING[0], 2).unwrap();
    sensor.set(id::PRESET[0], 10_00).unwrap();
    sensor.set(id::PRESET_ENABLE[0], 1).unwrap();
    assert_eq!(sensor.get(id::OFFSET[0]), 20_00);
    assert_eq!(sensor.words()[0], 10_00);
    sensor.set(id::DIFFERENTIAL[0], 35_999).unwrap();
    assert_eq!(sensor.words(), [9_99, 0, 9_99, 0]);
    assert_eq!(sensor.tilt(one(330.0)).words()[0], 34_999);
    // The parameters of the lateral axis work.
    sensor.set(id::OPERATING[1], 2).unwrap();
    sensor.set(id::PRESET[1], 45_00).unwrap();
    sensor.set(id::PRESET_ENABLE[1], 1).unwrap();
    assert_eq!(sensor.words()[1..], [45_00, 34_999, 45_00]);
}

#[test]
fn new_resolution_converts_all_numbers_with_its_unit() {
    let mut sensor = Tiltix080::new();
    sensor.tilt(two(0.06, -0.04));
    sensor.set(id::PRESET[0], 1234).unwrap();
    sensor.set(id::PRESET[1], -1235).unwrap();
    sensor.set(id::DIFFERENTIAL[0], 8000).unwrap();
    sensor.set(id::DIFFERENTIAL[1], -4).unwrap();
    sensor.set(id::COS_DELTA, 45).unwrap();
    sensor.set(id::PRESET_ENABLE[0], 1).unwrap();
    let numbers = |sensor: &Tiltix080| {
        let [a, b] = id::PRESET.map(|id| sensor.get(id));
        let [c, d] = id::DIFFERENTIAL.map(|id| sensor.get(id));
        [
            a,
            b,
            c,
            d,
            sensor.get(id::OFFSET[0]),
            sensor.get(id::COS_DELTA),
        ]
    };
    assert_eq!(numbers(&sensor), [1234, -1235, 8000, -4, 1228, 45]);
    sensor.set(id::RESOLUTION, 100).unwrap();
    assert_eq!(numbers(&sensor), [123, -124, 800, 0, 123, 5]);
    sensor.set(id::RESOLUTION, 10).unwrap();
    assert_eq!(numbers(&sensor), [1230, -1240, 8000, 0, 1230, 50]);
    sensor.set(id::COS_DELTA, 4).unwrap();
    sensor.set(id::RESOLUTION, 100).unwrap();
    assert_eq!(sensor.get(id::COS_DELTA), 0);
    sensor.set(id::RESOLUTION, 1000).unwrap();
    assert_eq!(numbers(&sensor), [12, -12, 80, 0, 12, 0]);
    let mut circle = Tiltix360::new();
    circle.set(id::PRESET[0], 35_999).unwrap();
    circle.set(id::RESOLUTION, 100).unwrap();
    assert_eq!(circle.get(id::PRESET[0]), 0);
}

#[test]
fn limits_follow_the_resolution() {
    let limits = [
        (10, 8000, 35_999, 200),
        (100, 800, 3599, 20),
        (1000, 80, 359, 2),
    ];
    for (resolution, signed, circle, delta) in limits {
        let mut sensor = Tiltix080::new();
        let mut round = Tiltix360::new();
        sensor.set(id::RESOLUTION, resolution).unwrap();
        round.set(id::RESOLUTION, resolution).unwrap();
        for id in id::PRESET.into_iter().chain(id::DIFFERENTIAL) {
            for good in [signed, -signed] {
                assert_eq!(sensor.set(id, good), Ok(()));
                assert!(sensor.set(id, good + good.signum()).is_err());
                assert_eq!(sensor.get(id), good.into());
            }
            assert_eq!(round.set(id, circle), Ok(()));
            assert!(round.set(id, circle + 1).is_err());
            assert_eq!(round.get(id), circle.into());
        }
        assert_eq!(sensor.set(id::COS_DELTA, delta), Ok(()));
        assert!(sensor.set(id::COS_DELTA, delta + 1).is_err());
        assert!(Tiltix::is_consistent(&sensor.parameters));
    }
}

/// A stored image from which the resolution is taken alone.
#[test]
fn parameters_beyond_the_limits_of_the_resolution_are_inconsistent() {
    for id in [id::PRESET[1], id::DIFFERENTIAL[0], id::COS_DELTA] {
        let mut parameters = Parameters::<Tiltix080Product>::factory();
        parameters.set(id, 81);
        assert!(Tiltix::is_consistent(&parameters));
        parameters.set(id::RESOLUTION, 1000);
        assert!(!Tiltix::is_consistent(&parameters));
    }
}

#[test]
fn distance_of_the_360_model_is_the_shorter_way() {
    let signed = Parameters::<Tiltix080Product>::factory();
    assert_eq!(Tiltix080Product::distance(&signed, -5_i16 as u16, 5), 10);
    assert_eq!(Tiltix080Product::distance(&signed, 5, -5_i16 as u16), 10);
    let mut circle = Parameters::<Tiltix360Product>::factory();
    assert_eq!(Tiltix360Product::distance(&circle, 35_999, 1), 2);
    assert_eq!(Tiltix360Product::distance(&circle, 0, 18_000), 18_000);
    circle.set(id::RESOLUTION, 1000);
    assert_eq!(Tiltix360Product::distance(&circle, 1, 358), 3);
}

#[test]
fn preset_without_a_reading_is_refused() {
    let mut sensor = Tiltix080::new();
    assert_eq!(sensor.set(id::PRESET_ENABLE[0], 1), Err(Refused::State));
    assert_eq!(sensor.get(id::PRESET_ENABLE[0]), 0);
    assert_eq!(
        sensor.tilt(two(1.0, 2.0)).set(id::PRESET_ENABLE[0], 1),
        Ok(())
    );
    sensor.values = sensor.application.stale();
    assert_eq!(sensor.values.faults(), Faults::SENSOR);
    assert_eq!(sensor.set(id::PRESET_ENABLE[1], 1), Err(Refused::State));
    assert_eq!(sensor.words(), [100, 200, 100, 200]);
}

#[test]
fn terminal_resistor_is_an_output() {
    let mut sensor = Tiltix080::new();
    assert_eq!(sensor.values.outputs().termination(), Some(false));
    sensor.set(id::TERMINATION, 1).unwrap();
    assert_eq!(sensor.values.outputs().termination(), Some(true));
    assert!(sensor.set(id::TERMINATION, 2).is_err());
}

#[test]
fn angle_object_has_the_22_attributes_of_the_manual() {
    let [object] = Tiltix080Product::OBJECTS else {
        panic!("one object")
    };
    let numbers = object.attributes.iter().map(|attribute| attribute.number);
    let manual = [0x01]
        .into_iter()
        .chain(0x71..=0x78)
        .chain(0x7A..=0x82)
        .chain([0x84, 0x85, 0x87, 0x88]);
    assert!(numbers.eq(manual));
    let read_only = object.attributes.iter().filter(|it| !it.settable);
    let read_only = read_only.map(|attribute| attribute.number);
    assert!(read_only.eq([0x01, 0x72, 0x76, 0x78, 0x7A, 0x7E, 0x80]));
}
