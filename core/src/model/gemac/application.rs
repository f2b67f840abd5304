//! The measurement of the GEMAC sensors: calibration, low-pass, angles and zero offset, and the heater of the reference line.

use super::parameters::{FILTER_KINDS, id};
use crate::application::{Application, Faults, Outputs, Readout, Values};
use crate::heater::{HeatedCell, Settings};
use crate::measure::low_pass::Kind;
use crate::measure::{Calibration, I32x3, Inclinometer, Reading};
use crate::param::{ParameterId, Parameters, Quantity, Table, ValueId, meaning};
use crate::time::Instant;
use core::marker::PhantomData;

/// The heater of the measuring cell of the reference line.
///
/// The temperature of the cell must be independent of the operating temperature (section 9.3), which is at most +80 degC (table
/// 1). A heater cannot cool, so the set point is above that. The accelerometer is specified up to 85 degC. The power is the peak
/// power of 4.8 W (table 1) minus the power of the electronics. With a cell of 150 K temperature rise and 90 s time constant, the
/// temperature is steady after two minutes from 25 degC and after four minutes from -20 degC. The overshoot is at most 0.2 K.
const HEATER: Settings = Settings {
    set_point: 82_00,
    proportional: 100,
    integral_time: 45,
    derivative_time: 20,
    full_power: 4000,
    tolerance: 50,
    steady_after: 30,
};

/// The part of the measurement that depends on the number of axes.
pub trait Axes: Table {
    /// The published angles: one or two.
    const QUANTITIES: &'static [Quantity];
    /// The faults of all angles.
    const ANGLES: Faults;

    /// The angles of a filtered up vector in 0.01 deg, and the faults of the angles beyond `limit` (0.01 deg).
    fn measure(up: I32x3, limit: u16) -> ([i32; 2], Faults);
    /// A measured angle with the zero offset applied, in 0.01 deg.
    fn with_offset(measured: i32, offset: u32) -> i32;
    /// The zero offset that makes a measured angle 0.
    fn zero_for(measured: i32) -> u32;
}

/// The published values: angles in 0.01 deg.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Inclination {
    /// The angles with zero offset.
    angles: [i32; 2],
    /// The angles without zero offset, from which a zero point is calculated.
    measured: [i32; 2],
    /// The angles may become a zero point.
    is_valid: bool,
    faults: Faults,
    outputs: Outputs,
}

impl Values for Inclination {
    const INITIAL: Self = Self {
        angles: [0; 2],
        measured: [0; 2],
        is_valid: false,
        faults: Faults::NONE,
        outputs: Outputs::NONE,
    };

    fn number(&self, id: ValueId) -> u32 {
        let angle = self.angles.get(usize::from(id.0));
        angle.copied().unwrap_or(0) as u32
    }

    fn faults(&self) -> Faults {
        self.faults
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }
}

/// The application of a sensor with these axes, with or without a heated measuring cell.
pub struct Gemac<X, const HEATED: bool> {
    /// 1-axis: the largest cross slope; 2-axis: the largest inclination without a fault; in 0.01 deg.
    limit: u16,
    inclinometer: Inclinometer,
    cell: HeatedCell,
    zero: [u32; 2],
    measured: [i32; 2],
    faults: Faults,
    axes: PhantomData<X>,
}

impl<X: Axes, const HEATED: bool> Gemac<X, HEATED> {
    /// Sets the largest cross slope or inclination in 0.01 deg.
    pub fn set_limit(&mut self, limit: u16) {
        self.limit = limit;
    }

    fn values(&self) -> Inclination {
        let [x, y] = self.measured;
        let [zero_x, zero_y] = self.zero;
        let (mut faults, mut outputs) = (self.faults, Outputs::NONE);
        if HEATED {
            faults = faults.and(Faults::WARM_UP.when(!self.cell.heater().is_steady()));
            outputs = outputs.with_heater(self.cell.heater().duty());
        }
        Inclination {
            angles: [X::with_offset(x, zero_x), X::with_offset(y, zero_y)],
            measured: self.measured,
            is_valid: self.inclinometer.validity.is_valid(),
            faults,
            outputs,
        }
    }
}

impl<X: Axes, const HEATED: bool> Application for Gemac<X, HEATED> {
    type Table = X;
    type Values = Inclination;

    const QUANTITIES: &'static [Quantity] = X::QUANTITIES;
    const HEATER: Option<&'static Settings> = if HEATED { Some(&HEATER) } else { None };

    const INITIAL: Self = Self {
        limit: 0,
        inclinometer: Inclinometer::INITIAL,
        cell: HeatedCell::UNHEATED,
        zero: [0; 2],
        measured: [0; 2],
        faults: Faults::NONE,
        axes: PhantomData,
    };

    fn start(&mut self, calibration: Calibration) {
        self.inclinometer.calibration = calibration;
        self.cell = Self::HEATER.map_or(HeatedCell::UNHEATED, HeatedCell::new);
    }

    fn resume(&mut self, kept: u32) {
        self.cell.resume(kept);
    }

    fn kept(&self) -> u32 {
        self.cell.kept()
    }

    fn apply(&mut self, _now: Instant, parameters: &Parameters<X>) -> Inclination {
        let kind = meaning(&FILTER_KINDS, parameters.get(id::FILTER_TYPE)).unwrap_or(Kind::Analog);
        let cut_off = parameters.get(id::CUT_OFF) as u16;
        // The permitted values are always valid for the filter.
        let _ = self.inclinometer.low_pass.tune(kind, cut_off);
        self.zero = [id::ZERO_X, id::ZERO_Y].map(|id| parameters.get(id));
        self.values()
    }

    fn sample(&mut self, now: Instant, reading: &Reading) -> Inclination {
        let up = self.inclinometer.sample(reading);
        let (measured, beyond) = X::measure(up, self.limit);
        self.measured = measured;
        let validity = &self.inclinometer.validity;
        // The angles of one axis have the whole circle.
        let overturned = X::ANGLES.intersects(Faults::Y) && validity.is_overturned();
        self.faults = if validity.clips() || validity.is_defective() || overturned {
            X::ANGLES
        } else {
            beyond
        };
        if HEATED {
            self.cell.take(now, reading.temperature);
        }
        self.values()
    }

    fn stale(&mut self) -> Inclination {
        if HEATED {
            self.cell.stop();
        }
        self.inclinometer.stale();
        self.faults = X::ANGLES;
        self.values()
    }

    fn derive(id: ParameterId, values: &Inclination) -> Option<u32> {
        if !values.is_valid {
            return None;
        }
        let [x, y] = values.measured;
        match id {
            id::ZERO_X => Some(X::zero_for(x)),
            id::ZERO_Y => Some(X::zero_for(y)),
            _ => None,
        }
    }

    fn readout(values: &Inclination, _parameters: &Parameters<X>) -> Readout {
        let [x, y] = values.angles;
        let two = X::ANGLES.intersects(Faults::Y);
        Readout {
            x,
            y: two.then_some(y),
        }
    }
}
