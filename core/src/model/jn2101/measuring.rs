//! What the JN2101 measures: from the acceleration to the angles in the units in which they are read (manual 8, 9.2 to 9.6).
//!
//! Calibration, filter, taught frame, angle definition, zero point, quadrant, resolution: in this order.

use super::slots;
use crate::angle::Angle;
use crate::canopen::Values;
use crate::measure::definition::{self, Euler, Gimbal, Perpendicular};
use crate::measure::fir::{Cutoff, Fir};
use crate::measure::teach::{self, Teach};
use crate::measure::{Calibration, I32x3, Reading};
use crate::node::Readout;

/// A full turn in 0.001 deg, the finest resolution.
const TURN: u32 = 360_000;

/// The numbers that can be read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Output {
    /// Longitudinal in 16 bits (6010h); at the ends of the range it stays there.
    X16,
    /// Lateral in 16 bits (6020h).
    Y16,
    /// Longitudinal in 32 bits (6110h).
    X32,
    /// Lateral in 32 bits (6120h).
    Y32,
    /// Temperature in 0.1 degC (4080h).
    Temperature,
    /// Heating power in mW (4081h).
    HeatingPower,
}

/// The angle definition (2044h).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Definition {
    Perpendicular,
    Euler,
    GimbalX,
    GimbalY,
}

/// What an angle's numbers range over.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Quadrants {
    /// Half a turn: -90 to 90 deg.
    Two,
    /// -180 to 180 deg.
    FourSigned,
    /// 0 to 360 deg.
    FourUnsigned,
}

/// The path of a sample.
pub(super) struct Measuring {
    pub calibration: Calibration,
    filter: Fir,
    frame: Teach,
    definition: Definition,
    quadrants: Quadrants,
    zero: [Angle; 2],
    /// A full turn in units of the resolution.
    turn: u32,
    /// The filtered up vector in the sensor's own frame; None without a sample.
    up: Option<I32x3>,
    /// The angles of the definition in force, without zero point.
    angles: [Angle; 2],
    /// What is read, in units of the resolution.
    outputs: [i32; 2],
}

impl Measuring {
    pub fn new(calibration: Calibration) -> Self {
        Self {
            calibration,
            filter: Fir::new(),
            frame: Teach::IDENTITY,
            definition: Definition::Perpendicular,
            quadrants: Quadrants::FourSigned,
            zero: [Angle::ZERO; 2],
            turn: TURN,
            up: None,
            angles: [Angle::ZERO; 2],
            outputs: [0; 2],
        }
    }

    /// Puts the values into force; what is measured follows at once.
    pub fn configure(&mut self, values: &Values) {
        self.filter.tune(match values.at(slots::FILTER) {
            1 => Cutoff::TenHertz,
            2 => Cutoff::FiveHertz,
            3 => Cutoff::OneHertz,
            4 => Cutoff::HalfHertz,
            _ => Cutoff::Off,
        });
        self.definition = match values.at(slots::DEFINITION) {
            1 => Definition::Euler,
            2 => Definition::GimbalX,
            3 => Definition::GimbalY,
            _ => Definition::Perpendicular,
        };
        self.quadrants = match values.at(slots::QUADRANT) {
            0 => Quadrants::Two,
            1 => Quadrants::FourSigned,
            _ => Quadrants::FourUnsigned,
        };
        self.frame = frame(values).unwrap_or(Teach::IDENTITY);
        let relative = values.at(slots::ZERO) == 1;
        self.zero = [slots::ZERO_X, slots::ZERO_Y]
            .map(|slot| Angle(if relative { values.at(slot) } else { 0 }));
        self.turn = TURN / values.at(slots::RESOLUTION).max(1);
        self.update();
    }

    /// Takes a reading in; returns the filtered up vector in the sensor's own frame.
    pub fn sample(&mut self, reading: &Reading) -> I32x3 {
        let corrected = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        let up = self.filter.step(corrected);
        self.up = Some(up);
        self.update();
        up
    }

    /// There are no readings any more.
    pub fn lose(&mut self) {
        self.up = None;
    }

    fn update(&mut self) {
        let Some(up) = self.up else { return };
        let up = self.frame.apply(up);
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
        self.outputs = self.in_units(self.turn);
    }

    /// The angles with zero point and quadrant correction; `turn` is a full turn in the unit wanted.
    fn in_units(&self, turn: u32) -> [i32; 2] {
        let [x, y] = self.angles;
        let [zero_x, zero_y] = self.zero;
        // The lateral Euler angle is the only one that can be more than half a turn (9.6).
        let lateral = match self.definition {
            Definition::Euler => self.quadrants,
            _ => Quadrants::FourSigned,
        };
        [
            scaled(x - zero_x, turn, Quadrants::FourSigned),
            scaled(y - zero_y, turn, lateral),
        ]
    }

    /// The number in an output of the angles.
    pub fn angle(&self, longitudinal: bool) -> i32 {
        let [x, y] = self.outputs;
        if longitudinal { x } else { y }
    }

    /// The zero point that makes both angles 0; None without a sample.
    pub fn zero_point(&self) -> Option<[Angle; 2]> {
        self.up.map(|_| self.angles)
    }

    /// The frame in which the present position is level; None without a sample, and when the X axis is upright (9.5).
    pub fn teach(&self) -> Option<Teach> {
        Teach::new(self.up?)
    }

    pub fn readout(&self) -> Readout {
        let [x, y] = self.in_units(36_000);
        Readout { x, y: Some(y) }
    }
}

/// The frame that was taught in; None when there is none, and when its numbers make none.
pub(super) fn frame(values: &Values) -> Option<Teach> {
    if values.at(slots::TEACH) != 1 {
        return None;
    }
    let mut bytes = [0; teach::SIZE];
    for (place, slot) in bytes.as_chunks_mut().0.iter_mut().zip(slots::FRAME..) {
        *place = values.at(slot).to_le_bytes();
    }
    Teach::decode(&bytes)
}

/// Keeps a frame in the values.
pub(super) fn keep_frame(frame: &Teach, values: &mut Values) {
    for (number, slot) in frame.encode().as_chunks().0.iter().zip(slots::FRAME..) {
        values.set(slot, u32::from_le_bytes(*number));
    }
}

/// An angle in units of which `turn` make a full turn, rounded to nearest.
fn scaled(angle: Angle, turn: u32, quadrants: Quadrants) -> i32 {
    let round = |value: i32| ((i64::from(value) * i64::from(turn) + (1 << 31)) >> 32) as i32;
    match quadrants {
        // Doubled and halved, half a turn drops out.
        Quadrants::Two => round((angle.0 << 1) as i32 >> 1),
        // Through the negative angle, so that half a turn is 180 deg and not -180 deg (the table in 8.5).
        Quadrants::FourSigned => -round((-angle).0 as i32),
        Quadrants::FourUnsigned => {
            let rounded = ((u64::from(angle.0) * u64::from(turn) + (1 << 31)) >> 32) as u32;
            if rounded == turn { 0 } else { rounded as i32 }
        }
    }
}
