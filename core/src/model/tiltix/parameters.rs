//! The parameters of the TILTIX (manual 5.1): those of the DeviceNet object and those of the angle object.

use crate::can::BitRate;
use crate::devicenet::identifiers::MAC_MAX;
use crate::measure::output_filter::{SIZE_MAX, WEIGHT_MAX};
use crate::param::{
    Coding, DataType, Meaning, Parameter, ParameterId, Parameters, Permitted, Persistence, Refused,
    Table,
};
use crate::walk::at;

/// The ids of the parameters: their indices in the table. They also define the order in the stored image.
pub mod id {
    use crate::param::ParameterId;

    /// MAC ID (class 3, attribute 1).
    pub const MAC_ID: ParameterId = ParameterId(0);
    /// Baud rate (class 3, attribute 2).
    pub const BAUD_RATE: ParameterId = ParameterId(1);
    /// Bus-off interrupt (class 3, attribute 3).
    pub const BUS_OFF_INTERRUPT: ParameterId = ParameterId(2);
    /// Resolution of the angles (attribute 71h).
    pub const RESOLUTION: ParameterId = ParameterId(3);
    /// Operating parameter of each axis (73h, 7Bh).
    pub const OPERATING: [ParameterId; 2] = [ParameterId(4), ParameterId(8)];
    /// Preset value of each axis (74h, 7Ch).
    pub const PRESET: [ParameterId; 2] = [ParameterId(5), ParameterId(9)];
    /// Offset of each axis (76h, 7Eh).
    pub const OFFSET: [ParameterId; 2] = [ParameterId(6), ParameterId(10)];
    /// Differential offset of each axis (77h, 7Fh).
    pub const DIFFERENTIAL: [ParameterId; 2] = [ParameterId(7), ParameterId(11)];
    /// Instance of the assembly in poll responses (81h).
    pub const POLLED_ASSEMBLY: ParameterId = ParameterId(12);
    /// Instance of the assembly in cyclic and COS messages (82h).
    pub const CYCLIC_ASSEMBLY: ParameterId = ParameterId(13);
    /// Size of the moving average filter (84h).
    pub const SIZE: ParameterId = ParameterId(14);
    /// Weighting factor of the recursive filter (85h).
    pub const WEIGHT: ParameterId = ParameterId(15);
    /// Whether the terminal resistor is on (87h).
    pub const TERMINATION: ParameterId = ParameterId(16);
    /// The least change that causes a COS message (88h).
    pub const COS_DELTA: ParameterId = ParameterId(17);
    /// Preset enable of each axis (75h, 7Dh): at the end, because older firmware did not store it.
    pub const PRESET_ENABLE: [ParameterId; 2] = [ParameterId(18), ParameterId(19)];
}

/// The number of parameters of each product.
pub(super) const COUNT: usize = 20;

/// Operating parameter, bit 0: the angle is inverted.
pub(super) const INVERSION: u32 = 1;
/// Operating parameter, bit 1: both offsets are added.
pub(super) const SCALING: u32 = 1 << 1;

const BAUD_RATE_CODING: Coding<BitRate, 3> = Coding([
    (0, BitRate::K125.name(), BitRate::K125),
    (1, BitRate::K250.name(), BitRate::K250),
    (2, BitRate::K500.name(), BitRate::K500),
]);

const BAUD_RATES: &[Meaning] = &BAUD_RATE_CODING.meanings();

/// The bit rates in the form that the device uses.
pub(super) static BIT_RATES: [BitRate; 3] = BAUD_RATE_CODING.sequence();

/// The resolutions with the number of 0.01 deg in a unit.
const RESOLUTION_CODING: Coding<Resolution, 3> = Coding([
    (10, "0.01 deg", Resolution(1)),
    (100, "0.1 deg", Resolution(10)),
    (1000, "1 deg", Resolution(100)),
]);

const RESOLUTION_NAMES: &[Meaning] = &RESOLUTION_CODING.meanings();

static RESOLUTIONS: [(u16, Resolution); 3] = RESOLUTION_CODING.codes();

/// The unit of the angles, in 0.01 deg.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Resolution(u32);

impl Resolution {
    /// The highest resolution, 0.01 deg.
    pub const HIGHEST: Self = Self(1);
    /// The resolution before the parameters are applied.
    pub const UNKNOWN: Self = Self(0);

    /// The resolution that the parameters contain.
    pub fn of<T: Table>(parameters: &Parameters<T>) -> Self {
        Self::with_code(parameters.get(id::RESOLUTION))
    }

    /// The resolution with a value of the parameter.
    pub fn with_code(number: u32) -> Self {
        crate::param::decode(&RESOLUTIONS, number).unwrap_or(Self::HIGHEST)
    }

    /// A number of 0.01 deg in this unit: the nearest one, halves away from zero.
    pub fn round(self, angle: i32) -> i32 {
        let Self(unit) = self;
        let size = angle.unsigned_abs().wrapping_add(unit / 2) / unit.max(1);
        if angle < 0 {
            (size as i32).wrapping_neg()
        } else {
            size as i32
        }
    }

    /// A number in this unit in 0.01 deg.
    pub fn expand(self, number: i32) -> i32 {
        number.wrapping_mul(self.0 as i32)
    }

    /// The highest number in this unit that is not above `limit`, in 0.01 deg.
    pub fn highest(self, limit: i32) -> i32 {
        (limit as u32 / self.0.max(1)) as i32
    }
}

/// How an angle is a number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Range {
    /// -80 to 80 deg: a signed word.
    Signed,
    /// 0 to below 360 deg: an unsigned word. Sums are taken modulo 360 deg.
    Circle,
}

/// 360 deg in 0.01 deg.
const TURN: i32 = 36_000;
/// The largest COS delta in 0.01 deg.
const DELTA_MAX: i32 = 2_00;

impl Range {
    /// The lowest and highest preset and differential offset, in 0.01 deg.
    pub(super) const fn limits(self) -> (i64, i64) {
        match self {
            Self::Signed => (-80_00, 80_00),
            Self::Circle => (0, TURN as i64 - 1),
        }
    }

    /// The type of a word with an angle of this range.
    pub(super) const fn word(self) -> DataType {
        match self {
            Self::Signed => DataType::I16,
            Self::Circle => DataType::U16,
        }
    }

    /// A raw number of a parameter as a number.
    pub(super) fn number(self, raw: u32) -> i32 {
        match self {
            Self::Signed => (raw as u16 as i16).into(),
            Self::Circle => (raw as u16).into(),
        }
    }

    /// A sum of angles in a resolution as a word: modulo 360 deg if it is a circle, otherwise limited to the range of the word. A sum
    /// has at most two turns below or above the circle.
    pub(super) fn word_of(self, sum: i32, resolution: Resolution) -> i32 {
        match self {
            Self::Signed => sum.clamp(i16::MIN.into(), i16::MAX.into()),
            Self::Circle => {
                let turn = resolution.highest(TURN) as u32;
                (sum.wrapping_add(2 * TURN) as u32 % turn.max(1)) as i32
            }
        }
    }

    /// The distance between two words in a resolution; on a circle, the shorter way.
    pub(super) fn distance(self, one: u16, other: u16, resolution: Resolution) -> u16 {
        match self {
            Self::Signed => (one as i16).abs_diff(other as i16),
            Self::Circle => {
                let direct = one.abs_diff(other);
                direct.min((resolution.highest(TURN) as u16).wrapping_sub(direct))
            }
        }
    }

    /// Whether a preset or differential offset is permitted in a resolution.
    fn permits(self, raw: u32, resolution: Resolution) -> bool {
        let (low, high) = self.limits();
        let number = self.number(raw);
        let lowest = resolution.highest(low.wrapping_neg() as i32).wrapping_neg();
        lowest <= number && number <= resolution.highest(high as i32)
    }
}

/// The parameters whose unit is the resolution, except the COS delta.
const ANGLES: [ParameterId; 6] = [
    id::PRESET[0],
    id::PRESET[1],
    id::OFFSET[0],
    id::OFFSET[1],
    id::DIFFERENTIAL[0],
    id::DIFFERENTIAL[1],
];

/// The parameters whose unit is the resolution.
pub(super) const IN_RESOLUTION: [ParameterId; 7] = {
    let [a, b, c, d, e, f] = ANGLES;
    [a, b, c, d, e, f, id::COS_DELTA]
};

/// Whether the parameters are within the limits that follow from the resolution.
pub(super) fn are_consistent<T: Table>(range: Range, parameters: &Parameters<T>) -> bool {
    let limited = id::PRESET.iter().chain(&id::DIFFERENTIAL);
    let mut limited = limited.chain(core::iter::once(&id::COS_DELTA));
    limited.all(|&id| check(range, parameters, id, parameters.get(id)).is_ok())
}

/// Whether a value of a parameter is within the limits that follow from the resolution in force.
pub(super) fn check<T: Table>(
    range: Range,
    parameters: &Parameters<T>,
    id: ParameterId,
    value: u32,
) -> Result<(), Refused> {
    let resolution = Resolution::of(parameters);
    let permitted = match id {
        id::COS_DELTA => value as i32 <= resolution.highest(DELTA_MAX),
        _ if id::PRESET.contains(&id) || id::DIFFERENTIAL.contains(&id) => {
            range.permits(value, resolution)
        }
        _ => true,
    };
    if permitted {
        Ok(())
    } else {
        Err(Refused::NotPermitted)
    }
}

/// Sets the resolution and converts all parameters whose unit it is (T14).
pub(super) fn set_resolution<T: Table>(range: Range, parameters: &mut Parameters<T>, value: u32) {
    let (before, now) = (Resolution::of(parameters), Resolution::with_code(value));
    let convert = |number: i32| now.round(before.expand(number));
    for id in ANGLES {
        let number = range.word_of(convert(range.number(parameters.get(id))), now);
        parameters.set(id, number as u16 as u32);
    }
    let delta = convert(parameters.get(id::COS_DELTA) as i32);
    parameters.set(id::COS_DELTA, delta as u32);
    parameters.set(id::RESOLUTION, value);
}

/// A byte that is stored when it is written.
#[track_caller]
const fn byte(id: ParameterId, name: &'static str, low: i64, high: i64, factory: i32) -> Parameter {
    Parameter {
        persistence: Persistence::AtOnce,
        ..Parameter::new(id, name, DataType::U8).within(low, high, factory)
    }
}

/// A byte with named values.
#[track_caller]
const fn named(id: ParameterId, name: &'static str, meanings: &'static [Meaning]) -> Parameter {
    Parameter {
        permitted: Permitted::Named,
        meanings,
        persistence: Persistence::AtOnce,
        ..Parameter::new(id, name, DataType::U8)
    }
}

const SWITCH: &[Meaning] = &[(0, "off"), (1, "on")];

/// A parameter that contains the instance of an assembly.
#[track_caller]
const fn assembly(id: ParameterId, name: &'static str) -> Parameter {
    Parameter {
        factory: 103,
        ..named(
            id,
            name,
            &[
                (101, "slope long16"),
                (102, "slope lateral16"),
                (103, "slope long16, slope lateral16"),
            ],
        )
    }
}

/// The names of the parameters of an axis: operating parameter, preset value, offset, differential offset.
type Names = [&'static str; 4];

const LONGITUDINAL: Names = [
    "Slope long16 operating parameter",
    "Slope long16 preset value",
    "Slope long16 offset",
    "Differential slope long16 offset",
];

const LATERAL: Names = [
    "Slope lateral16 operating parameter",
    "Slope lateral16 preset value",
    "Slope lateral16 offset",
    "Differential slope lateral16 offset",
];

/// An angle in the resolution, with its limits at the factory resolution.
#[track_caller]
const fn angle(id: ParameterId, name: &'static str, range: Range) -> Parameter {
    let (low, high) = range.limits();
    Parameter {
        persistence: Persistence::AtOnce,
        ..Parameter::new(id, name, range.word()).within(low, high, 0)
    }
}

/// The parameters of an axis, except preset enable.
#[track_caller]
const fn axis(axis: usize, names: Names, range: Range) -> [Parameter; 4] {
    let [operating, preset, offset, differential] = names;
    [
        named(
            *at(&id::OPERATING, axis),
            operating,
            &[
                (0, "off"),
                (INVERSION, "inversion"),
                (SCALING, "scaling"),
                (INVERSION | SCALING, "inversion and scaling"),
            ],
        ),
        angle(*at(&id::PRESET, axis), preset, range),
        Parameter {
            permitted: match range {
                Range::Signed => Permitted::Any,
                Range::Circle => Permitted::Range(0, TURN as i64 - 1),
            },
            ..angle(*at(&id::OFFSET, axis), offset, range)
        },
        angle(*at(&id::DIFFERENTIAL, axis), differential, range),
    ]
}

/// All parameters, in the order of the stored image.
#[track_caller]
pub(super) const fn parameters(range: Range) -> [Parameter; COUNT] {
    let [x0, x1, x2, x3] = axis(0, LONGITUDINAL, range);
    let [y0, y1, y2, y3] = axis(1, LATERAL, range);
    let [enable_x, enable_y] = id::PRESET_ENABLE;
    [
        byte(id::MAC_ID, "MAC ID", 0, MAC_MAX as i64, MAC_MAX as i32),
        named(id::BAUD_RATE, "Baud rate", BAUD_RATES),
        named(id::BUS_OFF_INTERRUPT, "BOI (bus-off interrupt)", SWITCH),
        Parameter {
            unit: "0.001 deg",
            permitted: Permitted::Named,
            meanings: RESOLUTION_NAMES,
            factory: 10,
            persistence: Persistence::AtOnce,
            ..Parameter::new(id::RESOLUTION, "Resolution", DataType::U16)
        },
        x0,
        x1,
        x2,
        x3,
        y0,
        y1,
        y2,
        y3,
        assembly(id::POLLED_ASSEMBLY, "Polled assembly instance"),
        assembly(id::CYCLIC_ASSEMBLY, "Cyclic/COS assembly instance"),
        byte(
            id::SIZE,
            "Size of moving average filter",
            0,
            SIZE_MAX as i64,
            100,
        ),
        Parameter {
            persistence: Persistence::AtOnce,
            ..Parameter::new(
                id::WEIGHT,
                "Weighting factor recursive filter",
                DataType::U16,
            )
            .within(0, WEIGHT_MAX as i64, 0)
        },
        named(id::TERMINATION, "Terminal resistor", SWITCH),
        byte(id::COS_DELTA, "COS delta", 0, DELTA_MAX as i64, 0),
        named(enable_x, "Slope long16 preset enable", SWITCH),
        named(enable_y, "Slope lateral16 preset enable", SWITCH),
    ]
}
