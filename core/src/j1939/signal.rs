//! The description of the broadcast groups: their signals, and the compact form in the device.
//!
//! A [`Group`] describes a parameter group by its [`Signal`]s, with names, resolutions and offsets. It is the source of the descriptor
//! (DBC) and of documents on a PC. The device uses the [`Field`]s that are derived from it.
//!
//! A number beyond its valid range is never sent limited: all its bits are 1 and its figure of merit is 3.

use super::identifier::Pgn;
use crate::mistake::{Mistake, Origin};
use crate::walk::{each, put};

/// The quality of a value, as a figure of merit.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
#[repr(u8)]
pub enum Merit {
    /// The value is within its specification.
    Good = 0,
    /// The value is outside the range in which the sensor is specified.
    Degraded = 1,
    /// The sensor is defective: all bytes of the value are FEh.
    Error = 2,
    /// Not available: all bits of the value are 1.
    #[default]
    Unavailable = 3,
}

/// A value of the application with its quality.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Measured {
    /// The number in the unit of its [`Source`].
    pub number: i32,
    /// Whether the number can be used.
    pub merit: Merit,
}

/// The value that a signal sends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Source {
    /// The angle of pitch, in 1/32768 deg.
    Pitch,
    /// The angle of roll, in 1/32768 deg.
    Roll,
    /// The rate at which pitch grows, in 0.001 deg/s.
    PitchRate,
    /// The rate at which roll grows, in 0.001 deg/s.
    RollRate,
    /// The rate about the vertical axis of a level sensor, in 0.001 deg/s.
    YawRate,
    /// The specific force along X, in 0.001 g.
    ForceX,
    /// The specific force along Y, in 0.001 g.
    ForceY,
    /// The specific force along Z, in 0.001 g.
    ForceZ,
}

/// The number of different [`Source`]s.
pub const SOURCES: usize = 8;

/// The units in 1/32768 deg, 0.001 deg/s and 0.001 g (9.80665 m/s^2): a fraction of deg, deg/s or m/s^2.
const fn unit_of(source: Source) -> (u64, u64) {
    match source {
        Source::Pitch | Source::Roll => (1, 32_768),
        Source::PitchRate | Source::RollRate | Source::YawRate => (1, 1000),
        Source::ForceX | Source::ForceY | Source::ForceZ => (980_665, 100_000_000),
    }
}

/// The values of a group, and the latency.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Motion {
    /// The values in the order of [`Source`].
    pub values: [Measured; SOURCES],
    /// The delay of the angles in 0.5 ms, up to 250; 255: longer, or not available.
    pub latency: u8,
}

impl Default for Motion {
    /// No value is available.
    fn default() -> Self {
        Self {
            values: [Measured::default(); SOURCES],
            latency: u8::MAX,
        }
    }
}

/// The contents of a signal.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Contents {
    /// A measured value in the resolution of the signal.
    Value {
        /// The value that is sent.
        source: Source,
        /// The value of one bit in deg, deg/s or m/s^2, as a fraction.
        resolution: (u64, u64),
        /// The value of the number 0.
        offset: i32,
        /// The unit of resolution and offset.
        unit: &'static str,
    },
    /// A number of the product, which the function of the group passes to [`data`]; [`compose`] sends ones.
    Own {
        /// The value of one bit in `unit`, as a fraction.
        resolution: (u64, u64),
        /// The value of the number 0.
        offset: i32,
        /// The unit; empty without one.
        unit: &'static str,
    },
    /// The figure of merit of a value.
    Merit(Source),
    /// Whether a value is compensated for acceleration. Always 3, not available.
    Compensation,
    /// The latency of the angles in 0.5 ms.
    Latency,
    /// A latency that is not known: all ones.
    UnknownLatency,
}

/// A signal of a group.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Signal {
    /// The name in the database (DBC) of the tools.
    pub name: &'static str,
    /// The suspect parameter number; 0 if it is not known.
    pub spn: u32,
    /// The first bit, 0 to 63.
    pub start: u8,
    /// The number of bits, from `start` on.
    pub bits: u8,
    /// What the bits of the signal contain.
    pub contents: Contents,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

/// A group that is sent to all nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Group {
    /// The acronym of the standard.
    pub name: &'static str,
    /// The number of the group in identifiers and requests.
    pub pgn: Pgn,
    /// Its signals. The figure of merit of a value comes after the value.
    pub signals: &'static [Signal],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Group {
    /// A group with these signals.
    #[track_caller]
    pub const fn new(name: &'static str, pgn: Pgn, signals: &'static [Signal]) -> Self {
        Self {
            name,
            pgn,
            signals,
            origin: Origin::here(),
        }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::group(self.pgn, self.name).at(self.origin)
    }
}

impl Signal {
    /// A signal with these contents in `bits` bits from bit `start` on.
    #[track_caller]
    pub const fn new(
        name: &'static str,
        spn: u32,
        start: u8,
        bits: u8,
        contents: Contents,
    ) -> Self {
        Self {
            name,
            spn,
            start,
            bits,
            contents,
            origin: Origin::here(),
        }
    }

    /// A mistake in this signal of a group.
    pub(super) const fn mistake<'a>(&'a self, group: &'a Group) -> Mistake<'a> {
        Mistake::signal(group.pgn, group.name, self.name).at(self.origin)
    }
}

/// The fraction bits of [`Field::scale`].
const FRACTION: u32 = 24;

/// A [`Signal`] in the form that the device uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// Number of the source: the raw number is its product with this, divided by 2^24, plus `offset`. 0 for another kind.
    scale: i32,
    /// The raw number of the value 0.
    offset: i32,
    start: u8,
    bits: u8,
    kind: Kind,
    source: u8,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
enum Kind {
    Value,
    Own,
    Merit,
    Latency,
    Ones,
}

/// Projects the signals of a group. Another number of signals, a signal that does not fit into the frame, or whose scale has more than 31
/// bits, is a compile error.
#[track_caller]
pub const fn fields<const N: usize>(signals: &[Signal]) -> [Field; N] {
    Mistake::item("fields").unless(signals.len() == N, "there is one for each signal");
    let mut fields = [Field {
        scale: 0,
        offset: 0,
        start: 0,
        bits: 0,
        kind: Kind::Ones,
        source: 0,
    }; N];
    each!(place, signal in signals => { put(&mut fields, place, field(Mistake::item(signal.name).at(signal.origin), signal)) });
    fields
}

/// Projects and checks a signal.
#[track_caller]
pub(super) const fn field(mistake: Mistake, signal: &Signal) -> Field {
    mistake.unless(
        signal.start as u32 + signal.bits as u32 <= 64,
        "the signal does not fit into the frame",
    );
    mistake.unless(signal.bits <= 32, "a signal has at most 32 bits");
    let (kind, source, scale, offset) = match signal.contents {
        Contents::Value {
            source,
            resolution: (value, divisor),
            offset,
            ..
        } => {
            mistake.unless(signal.bits >= 8, "a value has 8 to 32 bits");
            mistake.unless(value > 0 && divisor > 0, NO_FRACTION);
            let (unit, part) = unit_of(source);
            let (high, low) = ((unit * divisor) << FRACTION, part * value);
            let scale = (high + low / 2) / low;
            mistake.unless(scale < 1 << 31, "the resolution is too fine");
            let zero = zero(mistake, (value, divisor), offset);
            (Kind::Value, source as u8, scale as i32, zero)
        }
        Contents::Merit(source) => (Kind::Merit, source as u8, 0, 0),
        Contents::Latency => (Kind::Latency, 0, 0, 0),
        Contents::Own {
            resolution, offset, ..
        } => (Kind::Own, 0, 0, zero(mistake, resolution, offset)),
        Contents::Compensation | Contents::UnknownLatency => (Kind::Ones, 0, 0, 0),
    };
    Field {
        scale,
        offset,
        start: signal.start,
        bits: signal.bits,
        kind,
        source,
    }
}

const NO_FRACTION: &str = "the resolution is no fraction";

/// The raw number of the value 0.
#[track_caller]
const fn zero(mistake: Mistake, (value, divisor): (u64, u64), offset: i32) -> i32 {
    mistake.unless(value > 0 && divisor > 0, NO_FRACTION);
    let zero = -(offset as i128) * divisor as i128 / value as i128;
    mistake.unless(
        zero.unsigned_abs() < 1 << 31,
        "the offset is too large for the resolution",
    );
    zero as i32
}

/// The data of a group with numbers of the product, for [`Contents::Own`]: one for each signal, in the resolution of its signal. A number
/// that is None or beyond the valid range is sent as ones: not available. Bits without a signal are 1.
pub fn data<const N: usize>(fields: &[Field; N], numbers: [Option<i32>; N]) -> [u8; 8] {
    let mut data = u64::MAX;
    for (field, number) in fields.iter().zip(numbers) {
        if let Some(raw) = number.and_then(|number| field.own(number)) {
            data = field.put(data, raw);
        }
    }
    data.to_le_bytes()
}

/// The data of a group.
pub fn compose(fields: &[Field], motion: &Motion) -> [u8; 8] {
    let mut merits = motion.values.map(|value| value.merit);
    // Unused bits are 1.
    let mut data = u64::MAX;
    for field in fields {
        let place = usize::from(field.source);
        let raw = match (field.kind, merits.get_mut(place)) {
            (Kind::Value, Some(merit)) => {
                let number = motion.values.get(place).map_or(0, |value| value.number);
                let (raw, own) = field.raw(number, *merit);
                *merit = own;
                raw
            }
            (Kind::Merit, Some(merit)) => *merit as u32,
            (Kind::Latency, _) => motion.latency.into(),
            _ => u32::MAX,
        };
        data = field.put(data, raw);
    }
    data.to_le_bytes()
}

impl Field {
    /// Data that is 1 at the place of the signal, with this raw number there.
    fn put(&self, data: u64, raw: u32) -> u64 {
        let ones = (1_u64 << self.bits) - 1;
        data & (!(ones << self.start) | (u64::from(raw) & ones) << self.start)
    }

    /// The raw number of a number of the product.
    fn own(&self, number: i32) -> Option<u32> {
        let raw = i64::from(number) + i64::from(self.offset);
        // FAh in the most significant byte is the last valid value; in shorter numbers all values are valid.
        let valid = match self.bits.checked_sub(8) {
            Some(low) => 0xFB_u32 << low,
            None => 1 << self.bits,
        };
        let raw = u32::try_from(raw).ok();
        raw.filter(|raw| self.kind == Kind::Own && *raw < valid)
    }

    /// The raw number and the figure of merit of a value.
    fn raw(&self, number: i32, merit: Merit) -> (u32, Merit) {
        const ERROR: u32 = 0xFEFE_FEFE;
        match merit {
            Merit::Unavailable => return (u32::MAX, merit),
            Merit::Error => return (ERROR, merit),
            Merit::Good | Merit::Degraded => {}
        }
        let half = 1 << (FRACTION - 1);
        let scaled = (i64::from(number) * i64::from(self.scale) + half) >> FRACTION;
        let raw = scaled + i64::from(self.offset);
        // FAh in the most significant byte is the last valid value.
        let valid = 0xFBu32 << (self.bits - 8);
        match u32::try_from(raw) {
            Ok(raw) if raw < valid => (raw, merit),
            _ => (u32::MAX, Merit::Unavailable),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn own(start: u8, bits: u8, resolution: (u64, u64), offset: i32) -> Signal {
        Signal::new(
            "Own",
            0,
            start,
            bits,
            Contents::Own {
                resolution,
                offset,
                unit: "",
            },
        )
    }

    #[test]
    fn numbers_of_a_product_are_at_the_place_of_their_signals_and_ones_beyond_the_valid_range() {
        // 0.01 deg from -300 deg; a state; 2 K from -40 K.
        const FIELDS: [Field; 3] = fields(&[
            own(8, 16, (1, 100), -300),
            own(24, 2, (1, 1), 0),
            own(32, 8, (2, 1), -40),
        ]);
        let cases = [
            ([Some(0), Some(0), Some(0)], 0xFFFF_FF14_FC75_30FF),
            ([Some(-500), Some(1), Some(-20)], 0xFFFF_FF00_FD73_3CFF),
            ([None, None, None], u64::MAX),
            ([Some(1), Some(3), None], 0xFFFF_FFFF_FF75_31FF),
            ([Some(-30_000), None, None], 0xFFFF_FFFF_FF00_00FF),
            ([Some(-30_001), None, None], u64::MAX),
            // FAFFh is the last valid number.
            ([Some(0xFAFF - 30_000), None, None], 0xFFFF_FFFF_FFFA_FFFF),
            ([Some(0xFB00 - 30_000), None, None], u64::MAX),
            ([Some(i32::MIN), Some(4), Some(i32::MAX)], u64::MAX),
        ];
        for (numbers, expected) in cases {
            let data = u64::from_le_bytes(data(&FIELDS, numbers));
            assert_eq!(data, expected, "{numbers:?}: {data:016X}");
        }
    }
}
