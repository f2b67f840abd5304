//! The parameters of the JN2101 (manual 7.6, 7.7, 9 and 14).

use super::Jn2101Product;
use crate::canopen::profile;
use crate::measure::fir::Cutoff;
use crate::param::{Coding, DataType, Parameter, ParameterId, Permitted, Persistence, Table};

/// The ids of the parameters: their indices in the table. They also define the order in the stored image.
pub mod id {
    crate::ids! { pub ParameterId:
        /// COB-ID of the SYNC (1005h).
        SYNC_COB_ID,
        /// Guard time in ms (100Ch); 0: no life guarding.
        GUARD_TIME,
        /// Life time factor (100Dh); the life time is this number of guard times.
        LIFE_TIME_FACTOR,
        /// COB-ID of the EMCY (1014h).
        EMCY_COB_ID,
        /// Inhibit time of the EMCY (1015h).
        EMCY_INHIBIT_TIME,
        /// Producer heartbeat time in ms (1017h); 0: off.
        HEARTBEAT_TIME,
        /// Error behaviour: the NMT state after a communication error (1029h:01).
        ERROR_BEHAVIOUR,
        /// The first of four parameters of the first TPDO (1800h).
        TPDO0(4),
        /// The first of four parameters of the second TPDO (1801h).
        TPDO1(4),
        /// NMT start-up: whether the node becomes operational by itself (1F80h).
        START_UP,
        /// Node-ID, 1 to 127 (2000h).
        NODE_ID,
        /// Baud rate in kbit/s (2001h).
        BAUD_RATE,
        /// Quadrant correction: the range of the angles (2040h).
        QUADRANT,
        /// Whether the heater is on (2041h).
        HEATING,
        /// Teach index: no change, relative or absolute measurement (2042h).
        TEACH,
        /// Cut-off frequency of the FIR filter, as a code (2043h).
        FILTER,
        /// Angle calculation: the definition of the angles (2044h).
        DEFINITION,
        /// Whether the terminating resistor is on (2045h).
        TERMINATION,
        /// Zero point: unchanged, relative or absolute measurement (2046h).
        ZERO,
        /// Resolution of the angles in 0.001 deg (6000h).
        RESOLUTION,
        /// The longitudinal angle of the zero point, as a binary angle; not an object.
        ZERO_X,
        /// The lateral angle of the zero point, as a binary angle; not an object.
        ZERO_Y,
        /// The four numbers of the reference frame; not objects.
        REFERENCE_FRAME[4],
        /// Self-test (4004h:01): counts the requests.
        SELF_TEST,
    }
}

/// How the angles follow from the up vector (2044h).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Definition {
    Perpendicular,
    Euler,
    GimbalX,
    GimbalY,
}

/// The range of an angle (2040h).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Quadrants {
    /// -90 to +90 deg.
    Two,
    /// -180 to +180 deg.
    FourSigned,
    /// 0 to 360 deg, without sign.
    FourUnsigned,
}

const QUADRANT_CODING: Coding<Quadrants, 3> = Coding([
    (0, "off", Quadrants::Two),
    (1, "+-180 deg", Quadrants::FourSigned),
    (2, "0 to 360 deg", Quadrants::FourUnsigned),
]);
const FILTER_CODING: Coding<Cutoff, 5> = Coding([
    (0, "off", Cutoff::Off),
    (1, "10 Hz", Cutoff::TenHertz),
    (2, "5 Hz", Cutoff::FiveHertz),
    (3, "1 Hz", Cutoff::OneHertz),
    (4, "0.5 Hz", Cutoff::HalfHertz),
]);
const DEFINITION_CODING: Coding<Definition, 4> = Coding([
    (0, "perpendicular", Definition::Perpendicular),
    (1, "Euler", Definition::Euler),
    (2, "gimbal X", Definition::GimbalX),
    (3, "gimbal Y", Definition::GimbalY),
]);
const SWITCH_CODING: Coding<bool, 2> = Coding([(0, "off", false), (1, "on", true)]);

/// The codings in the form that the device uses.
pub(super) static QUADRANTS: [Quadrants; 3] = QUADRANT_CODING.sequence();
pub(super) static FILTERS: [Cutoff; 5] = FILTER_CODING.sequence();
pub(super) static DEFINITIONS: [Definition; 4] = DEFINITION_CODING.sequence();
pub(super) static SWITCH: [bool; 2] = SWITCH_CODING.sequence();

/// Teach index and zero point: relative measurement.
pub(super) const RELATIVE: u32 = 1;
/// Teach index and zero point: absolute measurement.
pub(super) const ABSOLUTE: u32 = 2;

/// A parameter with named values.
#[track_caller]
const fn named(
    id: ParameterId,
    name: &'static str,
    meanings: &'static [(u32, &'static str)],
    factory: u32,
) -> Parameter {
    Parameter {
        id,
        name,
        permitted: Permitted::Named,
        meanings,
        factory,
        ..Parameter::plain()
    }
}

/// A number that is stored with teach index or zero point.
#[track_caller]
const fn hidden(id: ParameterId, name: &'static str) -> Parameter {
    Parameter {
        id,
        name,
        data_type: DataType::U32,
        persistence: Persistence::AtOnce,
        ..Parameter::plain()
    }
}

impl Table for Jn2101Product {
    /// In the order of the objects; parameters that are not objects come last.
    const PARAMETERS: &'static [Parameter] = crate::parameters![
        [
            profile::sync_cob_id(id::SYNC_COB_ID),
            profile::guard_time(id::GUARD_TIME),
            profile::life_time_factor(id::LIFE_TIME_FACTOR),
            profile::emcy_cob_id(id::EMCY_COB_ID),
            profile::emcy_inhibit_time(id::EMCY_INHIBIT_TIME),
            Parameter {
                name: "Heartbeat interval time",
                ..profile::heartbeat_time(id::HEARTBEAT_TIME)
            },
            Parameter {
                persistence: Persistence::Volatile,
                ..profile::error_behaviour(id::ERROR_BEHAVIOUR)
            }
        ],
        profile::tpdo_communication(id::TPDO0, 0x180),
        profile::tpdo_communication(id::TPDO1, 0x280),
        [
            profile::nmt_start_up(id::START_UP),
            Parameter {
                name: "Node ID",
                ..profile::node_id(id::NODE_ID, 10)
            },
            Parameter {
                name: "Baud rate",
                ..profile::bit_rate(id::BAUD_RATE, 125)
            },
            named(
                id::QUADRANT,
                "Quadrant correction",
                &QUADRANT_CODING.meanings(),
                1,
            ),
            named(id::HEATING, "Heating", &SWITCH_CODING.meanings(), 1),
            Parameter {
                persistence: Persistence::AtOnce,
                ..named(
                    id::TEACH,
                    "Teach index",
                    &[
                        (0, "no change"),
                        (RELATIVE, "relative measurement"),
                        (ABSOLUTE, "absolute measurement"),
                    ],
                    ABSOLUTE,
                )
            },
            named(id::FILTER, "FIR filter", &FILTER_CODING.meanings(), 2),
            named(
                id::DEFINITION,
                "Angle calculation",
                &DEFINITION_CODING.meanings(),
                0,
            ),
            named(
                id::TERMINATION,
                "Terminating resistor",
                &SWITCH_CODING.meanings(),
                1,
            ),
            Parameter {
                persistence: Persistence::AtOnce,
                ..named(
                    id::ZERO,
                    "Zero point",
                    &[
                        (0, "unchanged"),
                        (RELATIVE, "relative measurement"),
                        (ABSOLUTE, "absolute measurement"),
                    ],
                    ABSOLUTE,
                )
            },
            Parameter {
                id: id::RESOLUTION,
                name: "Resolution",
                data_type: DataType::U16,
                unit: "0.001 deg",
                permitted: Permitted::OneOf(&[1, 10, 100, 1000]),
                factory: 10,
                ..Parameter::plain()
            },
            hidden(id::ZERO_X, "Zero point X"),
            hidden(id::ZERO_Y, "Zero point Y"),
            hidden(id::REFERENCE_FRAME[0], "Reference frame: sine of roll"),
            hidden(id::REFERENCE_FRAME[1], "Reference frame: cosine of roll"),
            hidden(id::REFERENCE_FRAME[2], "Reference frame: sine of pitch"),
            hidden(id::REFERENCE_FRAME[3], "Reference frame: cosine of pitch"),
            Parameter {
                id: id::SELF_TEST,
                name: "Activate self-test",
                permitted: Permitted::Range(0, 1),
                persistence: Persistence::Volatile,
                ..Parameter::plain()
            }
        ],
    ];
    crate::project!(parameters);
}
