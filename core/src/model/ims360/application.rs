//! The measurement and actions of the IMS360: angles, raw values, temperature, supply voltage, faults and automatic zero.

use super::Ims360Product;
use super::measuring::{Measuring, measured};
use super::parameters::{HIGHEST_CRITICALLY_DAMPED, are_consistent, has_two_axes, id};
use super::range::{Beyond, RangeFault};
use crate::angle::Angle;
use crate::application::{Application, Effect, Faults, Readout, Values};
use crate::measure::supply::{Limits, Monitor};
use crate::measure::{Calibration, Reading};
use crate::param::{DataType, ParameterId, Parameters, Quantity, Refused, ValueId};
use crate::time::Instant;

/// The ids of the published values.
pub mod value {
    crate::ids! { pub ValueId:
        /// Longitudinal in 0.01 deg (6110h).
        X,
        /// Lateral in 0.01 deg (6120h).
        Y,
        /// Specific force X, Y, Z in 0.001 g (3011h to 3013h).
        FORCE32[3],
        /// Angular rate X, Y, Z in 0.001 deg/s (3021h to 3023h).
        RATE32[3],
        /// Supply voltage in mV; 0: not measured (2020h:01).
        SUPPLY,
        /// Temperature of the measuring cell in degC (6511h).
        TEMPERATURE,
        /// Specific force X, Y, Z in 0.001 g, limited to the range of 16 bits (3010h).
        FORCE16[3],
        /// Angular rate X, Y, Z in 0.1 deg/s, limited to the range of 16 bits (3020h).
        RATE16[3],
    }
}

/// The number of published values of 32 bits: the first ids, before those of at most 16 bits.
const LONG: usize = 9;

/// The limits of the supply voltage for the emergency 3100h.
pub(super) const SUPPLY: Limits = Limits::VEHICLE;

/// The largest angle of a 2-axis sensor in 0.01 deg.
pub(super) const RANGE: i32 = 90_00;

/// Auto zero (3200h): the first axis.
pub(super) const ZERO_X: u32 = 1;
/// Auto zero: the second axis.
pub(super) const ZERO_Y: u32 = 2;

/// The published values, and the angles from which a zero offset is calculated. They are small, because a frame that is received while they
/// are copied waits.
#[derive(Clone, Copy, Debug)]
pub struct Inclination {
    /// The values of 32 bits in the order of their ids.
    long: [i32; LONG],
    /// The values of at most 16 bits in the order of their ids.
    short: [i16; 7],
    /// The angles without offset, not rounded.
    fine: [Angle; 2],
    /// There was a sample.
    has_measured: bool,
    /// How the angles are out of range.
    beyond: [Beyond; 2],
    /// The angles may become a zero point.
    is_valid: bool,
    faults: Faults,
}

impl Inclination {
    /// The angles without offset, not rounded; None before the first sample.
    pub(super) fn fine(&self) -> Option<[Angle; 2]> {
        self.has_measured.then_some(self.fine)
    }

    /// How the angles are out of range.
    pub(super) fn beyond(&self) -> [Beyond; 2] {
        self.beyond
    }
}

impl Values for Inclination {
    const INITIAL: Self = Self {
        long: [0; LONG],
        short: [0; 7],
        fine: [Angle::ZERO; 2],
        has_measured: false,
        beyond: [Beyond::No; 2],
        is_valid: false,
        faults: Faults::NONE,
    };

    fn number(&self, id: ValueId) -> u32 {
        let place = usize::from(id.0);
        let number = match place.checked_sub(LONG) {
            None => self.long.get(place).copied(),
            Some(place) => self.short.get(place).copied().map(i32::from),
        };
        number.unwrap_or(0) as u32
    }

    fn faults(&self) -> Faults {
        self.faults
    }
}

/// The application of the IMS360.
pub struct Ims360Application {
    measuring: Measuring,
    /// The range faults of both angles (5010h, 5020h).
    ranges: [RangeFault; 2],
    supply: Monitor,
    /// The temperature of the measuring cell in degC.
    temperature: i8,
}

impl Ims360Application {
    fn values(&self) -> Inclination {
        let [x, y] = self.measuring.angles();
        let [fx, fy, fz] = self.measuring.force();
        let [rx, ry, rz] = self.measuring.rate(1000);
        let [force_x, force_y, force_z] = [fx, fy, fz].map(limited);
        let [rate_x, rate_y, rate_z] = self.measuring.rate(10).map(limited);
        Inclination {
            long: [
                x,
                y,
                fx,
                fy,
                fz,
                rx,
                ry,
                rz,
                self.supply.millivolts().into(),
            ],
            short: [
                self.temperature.into(),
                force_x,
                force_y,
                force_z,
                rate_x,
                rate_y,
                rate_z,
            ],
            fine: self.measuring.fine(),
            has_measured: self.measuring.has_measured(),
            beyond: self.ranges.map(RangeFault::state),
            is_valid: self.measuring.validity().is_valid(),
            faults: self.faults(),
        }
    }

    /// Judges the present angles (S36).
    fn judge(&mut self, now: Instant) {
        if !self.measuring.has_measured() {
            return;
        }
        let two_axes = self.measuring.has_two_axes();
        let validity = self.measuring.validity();
        let overturned = two_axes && validity.is_overturned();
        let clips = validity.clips();
        for (range, angle) in self.ranges.iter_mut().zip(self.measuring.angles()) {
            let beyond = match angle {
                _ if two_axes && angle > RANGE => Beyond::Above,
                _ if two_axes && angle < -RANGE => Beyond::Below,
                _ if overturned => range.side(angle),
                _ if clips => Beyond::Clips,
                _ => Beyond::No,
            };
            range.step(now, beyond);
        }
    }

    fn faults(&self) -> Faults {
        let [x, y] = self.ranges.map(|range| range.state() != Beyond::No);
        let defective = self.measuring.validity().is_defective();
        Faults::SUPPLY
            .when(self.supply.is_faulty())
            .and(Faults::X.when(x))
            .and(Faults::Y.when(y))
            .and(Faults::X_DEFECTIVE.when(defective))
            .and(Faults::Y_DEFECTIVE.when(defective && self.measuring.has_two_axes()))
    }
}

impl Application for Ims360Application {
    type Table = Ims360Product;
    type Values = Inclination;

    const QUANTITIES: &'static [Quantity] = &[
        slope(value::X, "Slope long32"),
        slope(value::Y, "Slope lateral32"),
        force(
            value::FORCE32[0],
            "Acceleration HiRes X axis",
            DataType::I32,
        ),
        force(
            value::FORCE32[1],
            "Acceleration HiRes Y axis",
            DataType::I32,
        ),
        force(
            value::FORCE32[2],
            "Acceleration HiRes Z axis",
            DataType::I32,
        ),
        rate(value::RATE32[0], "Gyroscope HiRes X axis", DataType::I32),
        rate(value::RATE32[1], "Gyroscope HiRes Y axis", DataType::I32),
        rate(value::RATE32[2], "Gyroscope HiRes Z axis", DataType::I32),
        Quantity::new(value::SUPPLY, "Supply voltage", DataType::U32).in_unit("mV", 0),
        Quantity::new(value::TEMPERATURE, "Device temperature", DataType::I8).in_unit("degC", 0),
        force(value::FORCE16[0], "Acceleration X axis", DataType::I16),
        force(value::FORCE16[1], "Acceleration Y axis", DataType::I16),
        force(value::FORCE16[2], "Acceleration Z axis", DataType::I16),
        rate(value::RATE16[0], "Gyroscope X axis", DataType::I16),
        rate(value::RATE16[1], "Gyroscope Y axis", DataType::I16),
        rate(value::RATE16[2], "Gyroscope Z axis", DataType::I16),
    ];
    const HAS_GYROSCOPE: bool = true;
    const MEASURES_SUPPLY: bool = true;

    const INITIAL: Self = Self {
        measuring: Measuring::INITIAL,
        ranges: [RangeFault::NONE; 2],
        supply: Monitor::NONE,
        temperature: 0,
    };

    fn start(&mut self, calibration: Calibration) {
        self.measuring.calibrate(calibration);
    }

    fn apply(&mut self, now: Instant, parameters: &Parameters<Ims360Product>) -> Inclination {
        self.measuring.configure(parameters);
        self.judge(now);
        self.values()
    }

    fn sample(&mut self, now: Instant, reading: &Reading) -> Inclination {
        self.measuring.sample(reading);
        self.judge(now);
        let degrees = (i32::from(reading.temperature) + 50).div_euclid(100);
        self.temperature = degrees.clamp(i8::MIN.into(), i8::MAX.into()) as i8;
        self.values()
    }

    fn interrupt(&mut self) {
        self.measuring.interrupt();
    }

    fn stale(&mut self) -> Inclination {
        self.measuring.invalidate();
        self.values()
    }

    fn supply(&mut self, millivolts: u16) -> Option<Inclination> {
        self.supply.step(millivolts, &SUPPLY).then(|| self.values())
    }

    fn write(
        id: ParameterId,
        value: u32,
        values: &Inclination,
        parameters: &mut Parameters<Ims360Product>,
    ) -> Result<Effect, Refused> {
        match id {
            id::AUTO_ZERO => zero(value, values, parameters)?,
            id::FILTER_TYPE => {
                parameters.set(id, value);
                // A tool writes the cut-off frequency after the type.
                if !are_consistent(parameters) {
                    parameters.set(id::CUT_OFF, HIGHEST_CRITICALLY_DAMPED);
                }
            }
            id::CUT_OFF => {
                let before = parameters.get(id);
                parameters.set(id, value);
                if !are_consistent(parameters) {
                    parameters.set(id, before);
                    return Err(Refused::NotPermitted);
                }
            }
            _ => parameters.set(id, value),
        }
        Ok(Effect::None)
    }

    fn is_consistent(parameters: &Parameters<Ims360Product>) -> bool {
        are_consistent(parameters)
    }

    fn readout(values: &Inclination, parameters: &Parameters<Ims360Product>) -> Readout {
        let [x, y, ..] = values.long;
        Readout {
            x,
            y: has_two_axes(parameters).then_some(y),
        }
    }
}

/// Sets the offsets for which the present angles are 0 (7.2.41).
fn zero(
    axes: u32,
    values: &Inclination,
    parameters: &mut Parameters<Ims360Product>,
) -> Result<(), Refused> {
    if axes != ZERO_X && !has_two_axes(parameters) {
        return Err(Refused::NotPermitted);
    }
    let fine = values.fine().filter(|_| values.is_valid);
    let [x, y] = measured(fine.ok_or(Refused::State)?, has_two_axes(parameters));
    if axes & ZERO_X != 0 {
        parameters.set(id::ZERO_X, x.wrapping_neg() as u32);
    }
    if axes & ZERO_Y != 0 {
        parameters.set(id::ZERO_Y, y.wrapping_neg() as u32);
    }
    Ok(())
}

#[track_caller]
const fn slope(id: ValueId, name: &'static str) -> Quantity {
    Quantity::new(id, name, DataType::I32).in_unit("deg", 2)
}

#[track_caller]
const fn force(id: ValueId, name: &'static str, data_type: DataType) -> Quantity {
    Quantity::new(id, name, data_type).in_unit("g", 3)
}

#[track_caller]
const fn rate(id: ValueId, name: &'static str, data_type: DataType) -> Quantity {
    let decimals = if data_type.size() == 4 { 3 } else { 1 };
    Quantity::new(id, name, data_type).in_unit("deg/s", decimals)
}

/// A number limited to 16 bits.
fn limited(number: i32) -> i16 {
    number.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
