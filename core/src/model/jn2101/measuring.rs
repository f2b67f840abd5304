//! The angles from the acceleration (manual 8, 9.2 to 9.6): calibration, filter, reference frame, angle definition, zero point,
//! quadrant correction and resolution, in this order.

use super::Jn2101Product;
use super::parameters::{DEFINITIONS, Definition, FILTERS, QUADRANTS, Quadrants, RELATIVE, id};
use crate::angle::Angle;
use crate::measure::definition::{self, Euler, Gimbal, Perpendicular};
use crate::measure::fir::{Cutoff, Fir};
use crate::measure::teach::{self, ReferenceFrame};
use crate::measure::{Calibration, I32x3, Reading, Validity};
use crate::param::{Parameters, meaning};

/// 360 deg in 0.001 deg, the finest resolution.
const TURN: u32 = 360_000;

/// The path of a sample.
pub(super) struct Measuring {
    calibration: Calibration,
    validity: Validity,
    filter: Fir,
    /// The reference frame of the teach-in; None: the coordinate frame of the sensor.
    reference_frame: Option<ReferenceFrame>,
    definition: Definition,
    scale: Scale,
    /// The filtered up vector in the coordinate frame of the sensor; None without a valid sample.
    up: Option<I32x3>,
    /// The angles of the selected definition, without zero point.
    angles: [Angle; 2],
    /// The output angles in units of the resolution.
    outputs: [i32; 2],
}

impl Measuring {
    /// The state before calibration and configuration.
    pub const INITIAL: Self = Self {
        calibration: Calibration::IDENTITY,
        validity: Validity::INITIAL,
        filter: Fir::new(),
        reference_frame: None,
        definition: Definition::Perpendicular,
        scale: Scale {
            zero: [Angle::ZERO; 2],
            lateral: Quadrants::Two,
            turn: 0,
        },
        up: None,
        angles: [Angle::ZERO; 2],
        outputs: [0; 2],
    };

    /// Sets the calibration of the device.
    pub fn calibrate(&mut self, calibration: Calibration) {
        self.calibration = calibration;
    }

    /// Applies the parameters and updates the angles.
    pub fn configure(&mut self, parameters: &Parameters<Jn2101Product>) {
        let filter = meaning(&FILTERS, parameters.get(id::FILTER));
        self.filter.tune(filter.unwrap_or(Cutoff::Off));
        self.definition = definition_of(parameters);
        self.scale = Scale::of(parameters);
        self.reference_frame = reference_frame(parameters);
        self.update();
    }

    /// Processes a reading. Returns the filtered up vector in the coordinate frame of the sensor.
    pub fn sample(&mut self, reading: &Reading) -> I32x3 {
        let corrected = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        self.validity.step(corrected, reading.clipped);
        let up = self.filter.step(corrected);
        self.up = Some(up);
        self.update();
        up
    }

    /// Marks the samples as not valid.
    pub fn invalidate(&mut self) {
        self.validity.stale();
        self.filter.forget();
        self.up = None;
    }

    fn update(&mut self) {
        let Some(up) = self.up else { return };
        let up = self.reference_frame.map_or(up, |frame| frame.apply(up));
        self.angles = match self.definition {
            Definition::Perpendicular => {
                let Perpendicular { x, y } = definition::perpendicular(up);
                [x, y]
            }
            Definition::Euler => {
                let Euler { slope, direction } = definition::euler(up);
                [slope, direction]
            }
            Definition::GimbalX => {
                let Gimbal { x, y } = definition::gimbal_x(up);
                [x, y]
            }
            Definition::GimbalY => {
                let Gimbal { x, y } = definition::gimbal_y(up);
                [x, y]
            }
        };
        self.outputs = self.scale.apply(self.angles);
    }

    /// The angles in units of the resolution.
    pub fn outputs(&self) -> [i32; 2] {
        self.outputs
    }

    /// The angles without zero point.
    pub fn angles(&self) -> [Angle; 2] {
        self.angles
    }

    /// The filtered up vector in the coordinate frame of the sensor; None while nothing valid is measured.
    pub fn up(&self) -> Option<I32x3> {
        self.up.filter(|_| self.validity.is_valid())
    }

    /// Detects a dead or wrong accelerometer.
    pub fn validity(&self) -> &Validity {
        &self.validity
    }

    /// Whether the lateral angle has more than two quadrants, so that the sensor also measures on its back (9.6).
    pub fn measures_overturned(&self) -> bool {
        self.definition == Definition::Euler && self.scale.lateral != Quadrants::Two
    }
}

/// The conversion of the angles of the definition to the output numbers.
pub(super) struct Scale {
    zero: [Angle; 2],
    /// The range of the lateral angle.
    lateral: Quadrants,
    /// 360 deg in units of the resolution.
    turn: u32,
}

impl Scale {
    /// The conversion set by the parameters.
    pub fn of(parameters: &Parameters<Jn2101Product>) -> Self {
        let relative = parameters.get(id::ZERO) == RELATIVE;
        let zero = |id| Angle(if relative { parameters.get(id) } else { 0 });
        let quadrants = meaning(&QUADRANTS, parameters.get(id::QUADRANT));
        Self {
            zero: [zero(id::ZERO_X), zero(id::ZERO_Y)],
            // Only the lateral Euler angle can exceed 180 deg (9.6).
            lateral: match definition_of(parameters) {
                Definition::Euler => quadrants.unwrap_or(Quadrants::FourSigned),
                _ => Quadrants::FourSigned,
            },
            turn: TURN / parameters.get(id::RESOLUTION).max(1),
        }
    }

    /// The same conversion with other units: `turn` units are 360 deg.
    pub fn with_turn(self, turn: u32) -> Self {
        Self { turn, ..self }
    }

    /// The output numbers of these angles.
    pub fn apply(&self, angles: [Angle; 2]) -> [i32; 2] {
        let [x, y] = angles;
        let [zero_x, zero_y] = self.zero;
        [
            scaled(x - zero_x, self.turn, Quadrants::FourSigned),
            scaled(y - zero_y, self.turn, self.lateral),
        ]
    }
}

fn definition_of(parameters: &Parameters<Jn2101Product>) -> Definition {
    let definition = meaning(&DEFINITIONS, parameters.get(id::DEFINITION));
    definition.unwrap_or(Definition::Perpendicular)
}

/// The reference frame of the teach-in; None if there is none, or if its numbers are not valid.
pub(super) fn reference_frame(parameters: &Parameters<Jn2101Product>) -> Option<ReferenceFrame> {
    if parameters.get(id::TEACH) != RELATIVE {
        return None;
    }
    let mut bytes = [0; teach::SIZE];
    for (place, id) in bytes.as_chunks_mut().0.iter_mut().zip(id::REFERENCE_FRAME) {
        *place = parameters.get(id).to_le_bytes();
    }
    ReferenceFrame::decode(&bytes)
}

/// Writes a reference frame into the parameters.
pub(super) fn store_reference_frame(
    frame: &ReferenceFrame,
    parameters: &mut Parameters<Jn2101Product>,
) {
    for (number, id) in frame.encode().as_chunks().0.iter().zip(id::REFERENCE_FRAME) {
        parameters.set(id, u32::from_le_bytes(*number));
    }
}

/// An angle in units of 360 deg / `turn`, rounded to nearest.
fn scaled(angle: Angle, turn: u32, quadrants: Quadrants) -> i32 {
    let round = |value: i32| ((i64::from(value) * i64::from(turn) + (1 << 31)) >> 32) as i32;
    match quadrants {
        // Doubling and halving gives the angle modulo 180 deg.
        Quadrants::Two => round((angle.0 << 1) as i32 >> 1),
        // Negated twice, so that 180 deg is 180 deg and not -180 deg (the table in 8.5).
        Quadrants::FourSigned => -round((-angle).0 as i32),
        Quadrants::FourUnsigned => {
            let rounded = ((u64::from(angle.0) * u64::from(turn) + (1 << 31)) >> 32) as u32;
            if rounded == turn { 0 } else { rounded as i32 }
        }
    }
}
