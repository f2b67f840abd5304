//! The groups with process data of an inclination sensor: SSI2, SSI, ARI and ACCS.
//!
//! ```text
//!  byte           0                2    3            4            6       6           7         8
//!                 +---------------------+-------------------------+-------------------+---------+
//!  SSI2 (61481)   | pitch (24 bits)     | roll (24 bits)          | quality           | latency |
//!                 +----------------+----+------------+------------+-------------------+---------+
//!  SSI  (61459)   | pitch          | roll            | pitch rate | quality           | latency |
//!  ARI  (61482)   | pitch rate     | roll rate       | yaw rate   | quality           | FFh     |
//!  ACCS (61485)   | lateral (Y)    | longitudinal (X)| vertical(Z)| quality           | FFh     |
//!                 +----------------+-----------------+------------+-------------------+---------+
//! ```
//!
//! Quality has two bits for each figure of merit and each compensation. The sources contradict each other about the values 0 and 1 of a
//! compensation. So the sensor always sends 3, not available.

use super::signal::{Contents, Field, Group, Motion, Signal, Source, compose, fields};
use crate::j1939::identifier::Pgn;

/// The number of groups in this file.
pub const COUNT: usize = 4;

/// The names of the groups, in the order of [`GROUPS`].
pub const NAMES: [&str; COUNT] = ["SSI2", "SSI", "ARI", "ACCS"];

/// Slope sensor information 2. [`ssi2`] returns its data.
pub const SSI2: Group = Group::new(NAMES[0], 61_481, &SSI2_SIGNALS);
/// Slope sensor information. [`ssi`] returns its data.
pub const SSI: Group = Group::new(NAMES[1], 61_459, &SSI_SIGNALS);
/// Angular rate information. [`ari`] returns its data.
pub const ARI: Group = Group::new(NAMES[2], 61_482, &ARI_SIGNALS);
/// Acceleration sensor. [`accs`] returns its data.
pub const ACCS: Group = Group::new(NAMES[3], 61_485, &ACCS_SIGNALS);

/// The groups, in the order of [`NAMES`].
pub const GROUPS: [Group; COUNT] = [SSI2, SSI, ARI, ACCS];

/// The suspect parameter number of the pitch angle in SSI2.
pub const PITCH_SPN: u32 = 4976;
/// The suspect parameter number of the roll angle in SSI2.
pub const ROLL_SPN: u32 = 4977;

const SSI2_SIGNALS: [Signal; 7] = [
    fine_angle("PitchAngleExRange", PITCH_SPN, 0, Source::Pitch),
    fine_angle("RollAngleExRange", ROLL_SPN, 24, Source::Roll),
    compensation("PitchAngleExRangeCompensation", 4978, 48),
    merit("PitchAngleExRangeFigureOfMerit", 4979, 50, Source::Pitch),
    compensation("RollAngleExRangeCompensation", 4980, 52),
    merit("RollAngleExRangeFigureOfMerit", 4981, 54, Source::Roll),
    latency("RollAndPitchExRangeLatency", 4982),
];

const SSI_SIGNALS: [Signal; 8] = [
    angle("PitchAngle", 3318, 0, Source::Pitch),
    angle("RollAngle", 3319, 16, Source::Roll),
    value(
        "PitchRate",
        3322,
        32,
        Source::PitchRate,
        ((2, 1000), -64, "deg/s"),
    ),
    merit("PitchAngleFigureOfMerit", 3323, 48, Source::Pitch),
    merit("RollAngleFigureOfMerit", 3324, 50, Source::Roll),
    merit("PitchRateFigureOfMerit", 3325, 52, Source::PitchRate),
    compensation("PitchAndRollCompensated", 3326, 54),
    latency("RollAndPitchMeasurementLatency", 3327),
];

const ARI_SIGNALS: [Signal; 8] = [
    rate("PitchRateExRange", 0, Source::PitchRate),
    rate("RollRateExRange", 16, Source::RollRate),
    rate("YawRateExRange", 32, Source::YawRate),
    merit("PitchRateExRangeFigureOfMerit", 0, 48, Source::PitchRate),
    merit("RollRateExRangeFigureOfMerit", 0, 50, Source::RollRate),
    merit("YawRateExRangeFigureOfMerit", 0, 52, Source::YawRate),
    compensation("AngularRateCompensation", 0, 54),
    unknown_latency("AngularRateMeasurementLatency", 56),
];

const ACCS_SIGNALS: [Signal; 8] = [
    force("LateralAcceleration", 0, Source::ForceY),
    force("LongitudinalAcceleration", 16, Source::ForceX),
    force("VerticalAcceleration", 32, Source::ForceZ),
    merit("LateralAccelFigureOfMerit", 0, 48, Source::ForceY),
    merit("LongitudinalAccelFigureOfMerit", 0, 50, Source::ForceX),
    merit("VerticalAccelFigureOfMerit", 0, 52, Source::ForceZ),
    compensation("AccelerationCompensation", 0, 54),
    unknown_latency("AccelerationMeasurementLatency", 56),
];

/// The value of one bit as a fraction, the value of the number 0, and the unit of both.
type Scale = ((u64, u64), i32, &'static str);

#[track_caller]
const fn value(name: &'static str, spn: u32, start: u8, source: Source, scale: Scale) -> Signal {
    let (resolution, offset, unit) = scale;
    let contents = Contents::Value {
        source,
        resolution,
        offset,
        unit,
    };
    Signal::new(name, spn, start, 16, contents)
}

#[track_caller]
const fn fine_angle(name: &'static str, spn: u32, start: u8, source: Source) -> Signal {
    Signal {
        bits: 24,
        ..value(name, spn, start, source, ((1, 32_768), -250, "deg"))
    }
}

#[track_caller]
const fn angle(name: &'static str, spn: u32, start: u8, source: Source) -> Signal {
    value(name, spn, start, source, ((2, 1000), -64, "deg"))
}

#[track_caller]
const fn rate(name: &'static str, start: u8, source: Source) -> Signal {
    value(name, 0, start, source, ((1, 128), -250, "deg/s"))
}

#[track_caller]
const fn force(name: &'static str, start: u8, source: Source) -> Signal {
    value(name, 0, start, source, ((1, 100), -320, "m/s^2"))
}

#[track_caller]
const fn merit(name: &'static str, spn: u32, start: u8, source: Source) -> Signal {
    Signal::new(name, spn, start, 2, Contents::Merit(source))
}

#[track_caller]
const fn compensation(name: &'static str, spn: u32, start: u8) -> Signal {
    Signal::new(name, spn, start, 2, Contents::Compensation)
}

#[track_caller]
const fn latency(name: &'static str, spn: u32) -> Signal {
    Signal::new(name, spn, 56, 8, Contents::Latency)
}

#[track_caller]
const fn unknown_latency(name: &'static str, start: u8) -> Signal {
    Signal::new(name, 0, start, 8, Contents::UnknownLatency)
}

static SSI2_FIELDS: [Field; SSI2_SIGNALS.len()] = fields(&SSI2_SIGNALS);
static SSI_FIELDS: [Field; SSI_SIGNALS.len()] = fields(&SSI_SIGNALS);
static ARI_FIELDS: [Field; ARI_SIGNALS.len()] = fields(&ARI_SIGNALS);
static ACCS_FIELDS: [Field; ACCS_SIGNALS.len()] = fields(&ACCS_SIGNALS);

/// The place of a group in [`GROUPS`].
pub fn place(pgn: Pgn) -> Option<usize> {
    GROUPS.iter().position(|group| group.pgn == pgn)
}

/// The data of SSI2 (slope sensor information 2).
pub fn ssi2(motion: &Motion) -> [u8; 8] {
    compose(&SSI2_FIELDS, motion)
}

/// The data of SSI (slope sensor information).
pub fn ssi(motion: &Motion) -> [u8; 8] {
    compose(&SSI_FIELDS, motion)
}

/// The data of ARI (angular rate information).
pub fn ari(motion: &Motion) -> [u8; 8] {
    compose(&ARI_FIELDS, motion)
}

/// The data of ACCS (acceleration sensor).
pub fn accs(motion: &Motion) -> [u8; 8] {
    compose(&ACCS_FIELDS, motion)
}

#[cfg(test)]
mod tests;
