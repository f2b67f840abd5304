//! The measurement and actions of the JN2101: angles, temperature and heating of the measuring cell, faults and self-test.

use super::Jn2101Product;
use super::measuring::{Measuring, Scale, reference_frame, store_reference_frame};
use super::parameters::{ABSOLUTE, RELATIVE, SWITCH, id};
use crate::angle::Angle;
use crate::application::{Application, Effect, Faults, Outputs, Readout, Values};
use crate::heater::{HeatedCell, Settings};
use crate::measure::self_test::{LIMIT, Working};
use crate::measure::supply::{Limits, Monitor};
use crate::measure::teach::ReferenceFrame;
use crate::measure::{Calibration, I32x3, RANGE, Reading};
use crate::param::{DataType, ParameterId, Parameters, Quantity, Refused, ValueId, meaning};
use crate::time::{Deadline, Instant};

/// The ids of the published values.
pub mod value {
    crate::ids! { pub ValueId:
        /// Longitudinal in 16 bits (6010h), limited to the range of 16 bits.
        X16,
        /// Lateral in 16 bits (6020h), limited to the range of 16 bits.
        Y16,
        /// Longitudinal in 32 bits (6110h).
        X32,
        /// Lateral in 32 bits (6120h).
        Y32,
        /// Temperature of the measuring cell in 0.1 degC (4080h).
        TEMPERATURE,
        /// Heating power in mW (4081h).
        HEATING_POWER,
        /// 1 while a self-test is running, otherwise 0 (4004h:01).
        SELF_TEST_ACTIVE,
        /// The result of the last self-test (4004h:02): bit 2, the X axis works; bit 1, the Y axis works.
        SELF_TEST_RESULT,
    }
}

/// The heater of the measuring cell.
const HEATER: Settings = Settings {
    set_point: 50_00,
    proportional: 50,
    integral_time: 60,
    derivative_time: 20,
    full_power: 1500,
    tolerance: 50,
    steady_after: 30,
};

/// The temperature limits of the measuring cell for the emergency, in 0.01 degC.
const TEMPERATURES: (i16, i16) = (-40_00, 85_00);
/// The hysteresis of the temperature limits for the end of the emergency, in 0.01 K.
const TEMPERATURE_HYSTERESIS: i16 = 2_00;

/// Self-test register: the X axis works.
const X_WORKS: u8 = 1 << 2;
/// Self-test register: the Y axis works.
const Y_WORKS: u8 = 1 << 1;

/// The published values, and the angles from which a zero point is calculated.
#[derive(Clone, Copy, Debug)]
pub struct Inclination {
    /// The angles in units of the resolution.
    angles: [i32; 2],
    /// The angles without zero point.
    measured: [Angle; 2],
    /// The filtered up vector in the coordinate frame of the sensor; None while nothing valid is measured.
    up: Option<I32x3>,
    /// The temperature of the measuring cell in 0.1 degC.
    temperature: i32,
    /// The heating power in mW.
    power: u16,
    self_test_active: bool,
    self_test_result: u8,
    faults: Faults,
    outputs: Outputs,
}

impl Values for Inclination {
    const INITIAL: Self = Self {
        angles: [0; 2],
        measured: [Angle::ZERO; 2],
        up: None,
        temperature: 0,
        power: 0,
        self_test_active: false,
        self_test_result: 0,
        faults: Faults::NONE,
        outputs: Outputs::NONE,
    };

    fn number(&self, id: ValueId) -> u32 {
        let [x, y] = self.angles;
        match id {
            value::X16 => saturated(x) as u32,
            value::Y16 => saturated(y) as u32,
            value::X32 => x as u32,
            value::Y32 => y as u32,
            value::TEMPERATURE => self.temperature as u32,
            value::HEATING_POWER => self.power.into(),
            value::SELF_TEST_ACTIVE => self.self_test_active.into(),
            value::SELF_TEST_RESULT => self.self_test_result.into(),
            _ => 0,
        }
    }

    fn faults(&self) -> Faults {
        self.faults
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }
}

/// The application of the JN2101.
pub struct Jn2101Application {
    measuring: Measuring,
    /// An axis is inclined beyond its range.
    is_beyond: bool,
    cell: HeatedCell,
    supply: Monitor,
    /// The temperature of the measuring cell in 0.1 degC (4080h).
    temperature: i32,
    faults: Faults,
    axes_failed: bool,
    /// The last value of the counter of self-test requests.
    tests: u32,
    /// The time limit of the running self-test; unset: no self-test is running.
    test_until: Deadline,
    test_result: u8,
    outputs: Outputs,
}

impl Jn2101Application {
    fn values(&mut self) -> Inclination {
        self.outputs = self.outputs.with_heater(self.cell.heater().duty());
        Inclination {
            angles: self.measuring.outputs(),
            measured: self.measuring.angles(),
            up: self.measuring.up(),
            temperature: self.temperature,
            power: self.cell.heater().power(),
            self_test_active: self.test_until.is_set(),
            self_test_result: self.test_result,
            faults: self.faults,
            outputs: self.outputs,
        }
    }

    /// Updates the temperature of the measuring cell and its fault (9.9).
    fn take_temperature(&mut self, temperature: i16) {
        self.temperature = (i32::from(temperature) + 5).div_euclid(10);
        let margin = if self.faults.intersects(Faults::TEMPERATURE) {
            TEMPERATURE_HYSTERESIS
        } else {
            0
        };
        let (coldest, hottest) = TEMPERATURES;
        let beyond = temperature < coldest + margin || temperature > hottest - margin;
        self.faults = self.faults.set(Faults::TEMPERATURE, beyond);
    }

    fn end_test(&mut self, result: Working) -> Inclination {
        self.test_until = Deadline::NEVER;
        let bit = |works: bool, bit: u8| if works { bit } else { 0 };
        self.test_result = bit(result.x, X_WORKS) | bit(result.y, Y_WORKS);
        self.axes_failed = self.test_result != X_WORKS | Y_WORKS;
        self.values()
    }
}

impl Application for Jn2101Application {
    type Table = Jn2101Product;
    type Values = Inclination;

    const QUANTITIES: &'static [Quantity] = &[
        slope(value::X16, "Slope long16", DataType::I16),
        slope(value::Y16, "Slope lateral16", DataType::I16),
        slope(value::X32, "Slope long32", DataType::I32),
        slope(value::Y32, "Slope lateral32", DataType::I32),
        Quantity::new(value::TEMPERATURE, "MEMS temperature", DataType::I32)
            .in_unit("0.1 degC", 0)
            .within(i16::MIN as i64 / 10, i16::MAX as i64 / 10),
        Quantity::new(value::HEATING_POWER, "Heating power", DataType::U16)
            .in_unit("mW", 0)
            .within(0, HEATER.full_power as i64),
        Quantity::new(value::SELF_TEST_ACTIVE, "Activate self-test", DataType::U8).within(0, 1),
        Quantity::new(value::SELF_TEST_RESULT, "Self-test register", DataType::U8)
            .within(0, (X_WORKS | Y_WORKS) as i64),
    ];
    const HEATER: Option<&'static Settings> = Some(&HEATER);
    const HAS_SELF_TEST: bool = true;
    const MEASURES_SUPPLY: bool = true;

    const INITIAL: Self = Self {
        measuring: Measuring::INITIAL,
        is_beyond: false,
        cell: HeatedCell::UNHEATED,
        supply: Monitor::NONE,
        temperature: 0,
        faults: Faults::NONE,
        axes_failed: false,
        tests: 0,
        test_until: Deadline::NEVER,
        test_result: 0,
        outputs: Outputs::NONE,
    };

    fn start(&mut self, calibration: Calibration) {
        self.measuring.calibrate(calibration);
        self.cell = HeatedCell::new(&HEATER);
    }

    fn resume(&mut self, kept: u32) {
        self.cell.resume(kept);
    }

    fn kept(&self) -> u32 {
        self.cell.kept()
    }

    fn apply(&mut self, now: Instant, parameters: &Parameters<Jn2101Product>) -> Inclination {
        let switch = |id| meaning(&SWITCH, parameters.get(id)).unwrap_or(false);
        self.measuring.configure(parameters);
        self.cell.enable(switch(id::HEATING));
        self.outputs = self.outputs.with_termination(switch(id::TERMINATION));
        let tests = parameters.get(id::SELF_TEST);
        // A reset of the node sets the count to 0.
        if tests != self.tests && tests != 0 && !self.test_until.is_set() {
            self.test_until = Deadline::after(now, LIMIT);
            self.outputs = self.outputs.with_self_test();
        }
        self.tests = tests;
        self.values()
    }

    fn sample(&mut self, now: Instant, reading: &Reading) -> Inclination {
        if self.cell.take(now, reading.temperature) {
            self.take_temperature(reading.temperature);
        }
        // The test deflects the element: nothing is measured.
        if self.test_until.is_set() {
            return self.values();
        }
        let up = self.measuring.sample(reading);
        self.is_beyond = is_beyond_range(up, self.is_beyond);
        let validity = self.measuring.validity();
        let overturned = validity.is_overturned() && !self.measuring.measures_overturned();
        let failed = validity.clips() || validity.is_defective() || self.axes_failed;
        self.faults = self
            .faults
            .set(Faults::SENSOR, failed)
            .set(Faults::RANGE, self.is_beyond || overturned);
        self.values()
    }

    fn stale(&mut self) -> Inclination {
        self.measuring.invalidate();
        self.cell.stop();
        self.faults = self.faults.set(Faults::SENSOR, true);
        self.values()
    }

    fn supply(&mut self, millivolts: u16) -> Option<Inclination> {
        let changed = self.supply.step(millivolts, &Limits::VEHICLE);
        changed.then(|| {
            self.faults = self.faults.set(Faults::SUPPLY, self.supply.is_faulty());
            self.values()
        })
    }

    fn tested(&mut self, result: Working) -> Option<Inclination> {
        self.test_until.is_set().then(|| self.end_test(result))
    }

    fn deadline(&self) -> Deadline {
        self.test_until
    }

    fn tick(&mut self, _now: Instant) -> Inclination {
        self.end_test(Working::default())
    }

    fn write(
        id: ParameterId,
        value: u32,
        values: &Inclination,
        parameters: &mut Parameters<Jn2101Product>,
    ) -> Result<Effect, Refused> {
        match (id, value) {
            (id::TEACH | id::ZERO | id::SELF_TEST, 0) => return Ok(Effect::None),
            // Nothing is measured.
            (id::TEACH | id::ZERO, RELATIVE) if values.self_test_active => {
                return Err(Refused::State);
            }
            (id::TEACH, RELATIVE) => {
                let up = values.up.ok_or(Refused::State)?;
                let frame = ReferenceFrame::new(up).ok_or(Refused::State)?;
                store_reference_frame(&frame, parameters);
                // The new reference is 0/0 (9.5).
                parameters.set(id::ZERO, ABSOLUTE);
            }
            (id::ZERO, RELATIVE) => {
                values.up.ok_or(Refused::State)?;
                let [x, y] = values.measured;
                parameters.set(id::ZERO_X, x.0);
                parameters.set(id::ZERO_Y, y.0);
            }
            (id::SELF_TEST, _) => {
                let tests = parameters.get(id::SELF_TEST);
                parameters.set(id::SELF_TEST, tests.wrapping_add(1));
                return Ok(Effect::None);
            }
            _ => {}
        }
        parameters.set(id, value);
        Ok(match id {
            id::TEACH | id::ZERO => Effect::Store,
            _ => Effect::None,
        })
    }

    fn is_consistent(parameters: &Parameters<Jn2101Product>) -> bool {
        let taught = match parameters.get(id::TEACH) {
            RELATIVE => reference_frame(parameters).is_some(),
            index => index == ABSOLUTE,
        };
        taught && parameters.get(id::ZERO) != 0
    }

    fn readout(values: &Inclination, parameters: &Parameters<Jn2101Product>) -> Readout {
        let hundredths = Scale::of(parameters).with_turn(36_000);
        let [x, y] = hundredths.apply(values.measured);
        Readout { x, y: Some(y) }
    }
}

/// A slope in units of the resolution (6000h), 0.001 to 1 deg.
#[track_caller]
const fn slope(id: ValueId, name: &'static str, data_type: DataType) -> Quantity {
    Quantity::new(id, name, data_type).in_unit("0.001 deg x 6000h", 0)
}

/// A number limited to 16 bits.
fn saturated(number: i32) -> i32 {
    number.clamp(i16::MIN.into(), i16::MAX.into())
}

/// Whether the X or Y axis is inclined by more than 45 deg. If it already was, the limit is 44 deg.
///
/// The sine of an inclination is the axis's component over the length: sin^2 is 1/2 and 0.4844.
fn is_beyond_range(up: I32x3, was: bool) -> bool {
    // The upper half of a square is enough: 2^20 for 1 g.
    let square = |component: i32| ((i64::from(component) * i64::from(component)) >> 32) as i32;
    let [x, y, z] = up
        .to_array()
        .map(|component| square(component.clamp(-RANGE, RANGE)));
    let squares = x + y + z;
    let limit = squares / 2 - if was { squares >> 6 } else { 0 };
    x.max(y) > limit
}
