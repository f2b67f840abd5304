//! The measurement of the TILTIX: calibration, angles, recursive filter and moving average, inversion, preset and offsets.
//!
//! The filtered angle is rounded to 0.01 deg, which is the highest resolution. A word is this angle in the resolution (rounded,
//! halves away from zero), inverted if selected, plus both offsets if scaling is on (manual 5.1, "Implementation of scaling and
//! inversion").

use super::parameters::{self, INVERSION, Range, Resolution, SCALING, id};
use crate::angle::Angle;
use crate::application::{Application, Effect, Faults, Outputs, Readout, Values};
use crate::measure::output_filter::OutputFilter;
use crate::measure::{Calibration, I32x3, Reading, Validity};
use crate::param::{DataType, ParameterId, Parameters, Quantity, Refused, Table, ValueId};
use crate::time::Instant;
use core::marker::PhantomData;

/// The ids of the published values.
pub mod value {
    crate::ids! { pub ValueId:
        /// Slope long16 and slope lateral16 (72h, 7Ah), in units of the resolution.
        SLOPE[2],
        /// Diagnostic slope long and lateral (78h, 80h), in 0.01 deg.
        DIAGNOSTIC[2],
    }
}

/// The part of the measurement that depends on the number of axes.
pub trait Axes: Table {
    /// The range of the angles.
    const RANGE: Range;
    /// Whether there is a lateral angle. If not, it is constantly 0.
    const TWO: bool;

    /// The longitudinal and the lateral angle of an up vector.
    fn measure(up: I32x3) -> [Angle; 2];
}

/// The published values in the resolution, and those for displays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Inclination {
    /// The words, in units of the resolution.
    slopes: [i32; 2],
    /// The same in 0.01 deg.
    diagnostic: [i32; 2],
    /// The angles with inversion and without offsets, in 0.01 deg.
    measured: [i32; 2],
    /// The angles may become a preset.
    is_valid: bool,
    faults: Faults,
    outputs: Outputs,
}

impl Values for Inclination {
    const INITIAL: Self = Self {
        slopes: [0; 2],
        diagnostic: [0; 2],
        measured: [0; 2],
        is_valid: false,
        faults: Faults::NONE,
        outputs: Outputs::NONE,
    };

    fn number(&self, id: ValueId) -> u32 {
        let ([x, y], [long, lateral]) = (self.slopes, self.diagnostic);
        let number = match id {
            ValueId(0) => x,
            ValueId(1) => y,
            ValueId(2) => long,
            ValueId(3) => lateral,
            _ => 0,
        };
        number as u32
    }

    fn faults(&self) -> Faults {
        self.faults
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }
}

/// The settings of an axis.
#[derive(Clone, Copy, Debug)]
struct Scale {
    inverted: bool,
    /// The sum of both offsets in units of the resolution; 0 without scaling.
    offset: i32,
}

/// The application of a TILTIX with these axes.
pub struct Tiltix<X> {
    calibration: Calibration,
    filter: OutputFilter<2>,
    validity: Validity,
    resolution: Resolution,
    scales: [Scale; 2],
    /// The filtered angles in 0.01 deg.
    angles: [i32; 2],
    faults: Faults,
    outputs: Outputs,
    axes: PhantomData<X>,
}

impl<X: Axes> Tiltix<X> {
    fn values(&self) -> Inclination {
        let mut values = Inclination {
            is_valid: self.validity.is_valid(),
            faults: self.faults,
            outputs: self.outputs,
            ..Inclination::INITIAL
        };
        let angles = self.angles.iter().zip(&self.scales);
        let places = values.slopes.iter_mut().zip(&mut values.diagnostic);
        let places = places.zip(&mut values.measured);
        for ((&angle, scale), ((slope, diagnostic), measured)) in angles.zip(places) {
            let angle = if scale.inverted {
                angle.wrapping_neg()
            } else {
                angle
            };
            let exact = angle.wrapping_add(self.resolution.expand(scale.offset));
            let sum = self.resolution.round(angle).wrapping_add(scale.offset);
            *measured = angle;
            *slope = X::RANGE.word_of(sum, self.resolution);
            *diagnostic = match X::RANGE {
                // At its limit, the word and the diagnostic slope are the same angle.
                Range::Signed if *slope != sum => self.resolution.expand(*slope),
                Range::Signed => exact,
                Range::Circle => X::RANGE.word_of(exact, Resolution::HIGHEST),
            };
        }
        values
    }
}

impl<X: Axes> Application for Tiltix<X> {
    type Table = X;
    type Values = Inclination;

    const QUANTITIES: &'static [Quantity] = &[
        slope(value::SLOPE[0], "Slope long16", X::RANGE),
        slope(value::SLOPE[1], "Slope lateral16", X::RANGE),
        diagnostic(value::DIAGNOSTIC[0], "Diagnostic slope long", X::RANGE),
        diagnostic(value::DIAGNOSTIC[1], "Diagnostic slope lateral", X::RANGE),
    ];
    const HAS_OUTPUTS: bool = true;

    const INITIAL: Self = Self {
        calibration: Calibration::IDENTITY,
        filter: OutputFilter::INITIAL,
        validity: Validity::INITIAL,
        resolution: Resolution::UNKNOWN,
        scales: [Scale {
            inverted: false,
            offset: 0,
        }; 2],
        angles: [0; 2],
        faults: Faults::NONE,
        outputs: Outputs::NONE,
        axes: PhantomData,
    };

    fn start(&mut self, calibration: Calibration) {
        self.calibration = calibration;
    }

    fn apply(&mut self, _now: Instant, parameters: &Parameters<X>) -> Inclination {
        let number = |id| X::RANGE.number(parameters.get(id));
        self.resolution = Resolution::of(parameters);
        let axes = self.scales.iter_mut().zip(id::OPERATING);
        for ((scale, operating), (offset, differential)) in
            axes.zip(id::OFFSET.into_iter().zip(id::DIFFERENTIAL))
        {
            let operating = parameters.get(operating);
            let sum = number(offset).wrapping_add(number(differential));
            scale.inverted = operating & INVERSION != 0;
            scale.offset = if operating & SCALING != 0 { sum } else { 0 };
        }
        let weight = parameters.get(id::WEIGHT) as u16;
        self.filter.tune(weight, parameters.get(id::SIZE) as u8);
        let connected = parameters.get(id::TERMINATION) != 0;
        self.outputs = Outputs::NONE.with_termination(connected);
        self.values()
    }

    fn sample(&mut self, _now: Instant, reading: &Reading) -> Inclination {
        let up = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        self.validity.step(up, reading.clipped);
        self.angles = self
            .filter
            .step(X::measure(up))
            .map(|angle| match X::RANGE {
                Range::Signed => angle.centidegrees(),
                Range::Circle => angle.centidegrees_unsigned().into(),
            });
        let range = Faults::RANGE.when(self.validity.clips());
        self.faults = range.and(Faults::SENSOR.when(self.validity.is_defective()));
        self.values()
    }

    fn interrupt(&mut self) {
        self.filter.restart();
    }

    fn stale(&mut self) -> Inclination {
        self.filter.restart();
        self.validity.stale();
        self.faults = Faults::SENSOR;
        self.values()
    }

    fn write(
        id: ParameterId,
        value: u32,
        values: &Inclination,
        parameters: &mut Parameters<X>,
    ) -> Result<Effect, Refused> {
        parameters::check(X::RANGE, parameters, id, value)?;
        if id == id::RESOLUTION {
            parameters::set_resolution(X::RANGE, parameters, value);
            return Ok(Effect::None);
        }
        let axis = id::PRESET_ENABLE.iter().position(|enable| *enable == id);
        if let Some(axis) = axis.filter(|_| value != 0 && parameters.get(id) == 0) {
            preset(axis, values, parameters)?;
        }
        parameters.set(id, value);
        Ok(Effect::None)
    }

    fn is_consistent(parameters: &Parameters<X>) -> bool {
        parameters::are_consistent(X::RANGE, parameters)
    }

    fn readout(values: &Inclination, _parameters: &Parameters<X>) -> Readout {
        let [x, y] = values.diagnostic;
        Readout {
            x,
            y: X::TWO.then_some(y),
        }
    }
}

/// Sets the offset of an axis, so that its slope without the differential offset is the preset value (75h, 7Dh).
fn preset<X: Axes>(
    axis: usize,
    values: &Inclination,
    parameters: &mut Parameters<X>,
) -> Result<(), Refused> {
    let (Some(&measured), Some(&preset), Some(&offset)) = (
        values.measured.get(axis).filter(|_| values.is_valid),
        id::PRESET.get(axis),
        id::OFFSET.get(axis),
    ) else {
        return Err(Refused::State);
    };
    let resolution = Resolution::of(parameters);
    let preset = X::RANGE.number(parameters.get(preset));
    let difference = preset.wrapping_sub(resolution.round(measured));
    let number = X::RANGE.word_of(difference, resolution);
    parameters.set(offset, u32::from(number as u16));
    Ok(())
}

/// A quantity of this type. The sum of a 2-axis sensor is limited only by the word.
#[track_caller]
const fn quantity(id: ValueId, name: &'static str, data_type: DataType, range: Range) -> Quantity {
    let all = Quantity::new(id, name, data_type);
    match range {
        Range::Signed => all,
        Range::Circle => Quantity {
            range: range.limits(),
            ..all
        },
    }
}

#[track_caller]
const fn slope(id: ValueId, name: &'static str, range: Range) -> Quantity {
    quantity(id, name, range.word(), range)
}

#[track_caller]
const fn diagnostic(id: ValueId, name: &'static str, range: Range) -> Quantity {
    Quantity {
        unit: "0.01 deg",
        ..quantity(id, name, DataType::I32, range)
    }
}
