//! The parameters of the IMS360 (manual 7.2).

use super::{HISTORY, Ims360Product};
use crate::canopen::profile;
use crate::measure::low_pass::Kind;
use crate::model::listing::canopen::Variant;
use crate::param::{
    Coding, DataType, Parameter, ParameterId, Parameters, Permitted, Persistence, Ranges, Table,
};
use crate::walk::{at, each, put};

/// The ids of the parameters: their indices in the table. They also define the order in the stored image.
pub mod id {
    crate::ids! { pub ParameterId:
        /// Device type (1000h): that of the variant in force.
        DEVICE_TYPE,
        /// COB-ID of the SYNC (1005h).
        SYNC_COB_ID,
        /// COB-ID of the EMCY (1014h).
        EMCY_COB_ID,
        /// Producer heartbeat time in ms (1017h); 0: off.
        HEARTBEAT_TIME,
        /// The first of four parameters of each TPDO (1800h to 1803h).
        TPDO[4](4),
        /// The first of nine parameters of each mapping (1A00h to 1A03h).
        MAPPING[4](9),
        /// Baud rate in bit/s (2001h).
        BIT_RATE,
        /// Node-ID, 1 to 126 (2002h); 255 by LSS.
        NODE_ID,
        /// CAN protocol after the next restart (3100h:01).
        PROTOCOL,
        /// Whether the node leaves bus-off automatically (3100h:02).
        BUS_OFF_RECOVERY,
        /// Type of the low-pass filter (3110h:01).
        FILTER_TYPE,
        /// Whether the sensor fusion filter replaces the low-pass filter (3110h:02).
        FUSION,
        /// Cut-off frequency of the low-pass filter (3111h).
        CUT_OFF,
        /// Kalman filter (3112h): mantissa and exponent of Q.
        Q[2],
        /// Kalman filter (3112h): mantissa and exponent of R.
        R[2],
        /// Sensor configuration (3120h:01): the variant after the next restart.
        VARIANT,
        /// Auto zero (3200h): a command.
        AUTO_ZERO,
        /// Longitudinal zero offset in 0.01 deg (3210h).
        ZERO_X,
        /// Lateral zero offset in 0.01 deg (3220h).
        ZERO_Y,
        /// The requested restore (1011h); not an object.
        RESTORE_REQUEST,
        /// The first of the stored errors (1003h); not objects.
        HISTORY(8),
        /// J1939: the address that is claimed first (2102h).
        J1939_ADDRESS,
        /// J1939: transmission rates (2104h) of SSI2, SSI, ARI and ACCS.
        J1939_RATES[4],
        /// J1939: priorities (2105h) of SSI2, SSI, ARI and ACCS.
        J1939_PRIORITIES[4],
        /// J1939: the fields of the NAME (2106h), except the identity number.
        J1939_NAME[8],
    }
}

/// The device type (1000h) with one axis.
pub(super) const ONE_AXIS_TYPE: u32 = 0x0703_019A;
/// The device type with two axes.
pub(super) const TWO_AXES_TYPE: u32 = 0x0704_019A;

/// The mapping entry of 6110h.
const LONGITUDINAL: u32 = profile::entry(0x6110, 0, 32);
/// The mapping entry of 6120h.
const LATERAL: u32 = profile::entry(0x6120, 0, 32);

/// The factory values that differ with one axis (3120h:01 = 0).
pub(super) const ONE_AXIS: Variant = {
    let ParameterId(first) = id::MAPPING[0];
    Variant {
        name: "1axis",
        selector: (id::VARIANT, 0),
        mark: (id::DEVICE_TYPE, ONE_AXIS_TYPE),
        defaults: &[
            (ParameterId(first), 1),
            (ParameterId(first + 1), LONGITUDINAL),
            (ParameterId(first + 2), 0),
            (ParameterId(first + 3), 0),
            (ParameterId(first + 4), 0),
            (ParameterId(first + 5), 0),
            (ParameterId(first + 6), 0),
            (ParameterId(first + 7), 0),
            (ParameterId(first + 8), 0),
        ],
    }
};

/// Whether the variant in force has two axes.
pub(super) fn has_two_axes(parameters: &Parameters<Ims360Product>) -> bool {
    parameters.get(id::DEVICE_TYPE) != ONE_AXIS_TYPE
}

/// The parameter that selects the protocol at a restart, and its value for CANopen.
pub(super) const SELECTOR: (ParameterId, u32) = (id::PROTOCOL, CANOPEN);

/// The value of 3100h:01 for CANopen.
const CANOPEN: u32 = 2;

/// Whether the node leaves bus-off automatically (3100h:02).
pub(super) fn recovers(parameters: &Parameters<Ims360Product>) -> bool {
    parameters.get(id::BUS_OFF_RECOVERY) != 0
}

/// The value of 3110h:01 for the critically damped filter.
const CRITICALLY_DAMPED: u16 = 2;

const FILTER_CODING: Coding<Kind, 3> = Coding([
    (0, "filter disabled", Kind::Off),
    (1, "Butterworth 8th order", Kind::Butterworth),
    (
        CRITICALLY_DAMPED,
        "critically damped 8th order",
        Kind::CriticallyDamped,
    ),
]);

/// The types of the low-pass filter in the form that the device uses.
pub(super) static FILTER_KINDS: [Kind; 3] = FILTER_CODING.sequence();

/// Whether the parameters fit each other: the cut-off frequency is in the range of the filter type (7.2.38).
pub(super) fn are_consistent(parameters: &Parameters<Ims360Product>) -> bool {
    let kind = parameters.get(id::FILTER_TYPE);
    kind != CRITICALLY_DAMPED.into() || parameters.get(id::CUT_OFF) <= HIGHEST_CRITICALLY_DAMPED
}

/// The highest cut-off frequency of the critically damped filter.
pub(super) const HIGHEST_CRITICALLY_DAMPED: u32 = *Kind::CriticallyDamped.cutoffs().end() as u32;

/// Off, or a period in ms.
const PERIODS: Ranges = Ranges {
    text: "0, 10..65535",
    ignored_bits: 0,
    ranges: &[(0, 0), (10, 65_535)],
};

/// The transmission rate of a J1939 group.
#[track_caller]
const fn rate(place: usize, name: &'static str, factory: u32) -> Parameter {
    Parameter {
        unit: "ms",
        permitted: Permitted::Ranges(&PERIODS),
        factory,
        ..Parameter::new(*at(&id::J1939_RATES, place), name, DataType::U16)
    }
}

/// The priority of a J1939 group.
#[track_caller]
const fn priority(place: usize, name: &'static str) -> Parameter {
    Parameter::new(*at(&id::J1939_PRIORITIES, place), name, DataType::U8).within(0, 7, 3)
}

/// A field of the J1939 NAME.
#[track_caller]
const fn field(place: usize, name: &'static str, high: i64, factory: i32) -> Parameter {
    Parameter::new(*at(&id::J1939_NAME, place), name, DataType::U8).within(0, high, factory)
}

/// The parameters that only J1939 uses.
const J1939: [Parameter; 17] = [
    Parameter::new(id::J1939_ADDRESS, "Preferred address", DataType::U8).within(0, 253, 128),
    rate(0, "Transmission rate SSI2", 10),
    rate(1, "Transmission rate SSI", 0),
    rate(2, "Transmission rate ARI", 0),
    rate(3, "Transmission rate ACCS", 0),
    priority(0, "Priority SSI2"),
    priority(1, "Priority SSI"),
    priority(2, "Priority ARI"),
    priority(3, "Priority ACCS"),
    field(0, "Arbitrary address capable", 1, 1),
    field(1, "Industry group", 7, 0),
    field(2, "Vehicle system instance", 15, 0),
    field(3, "Vehicle system", 127, 0),
    field(4, "Function", 255, 145),
    field(5, "Function instance", 31, 0),
    field(6, "ECU instance", 7, 0),
    Parameter::new(id::J1939_NAME[7], "Manufacturer code", DataType::U16).within(0, 2047, 2047),
];

/// A parameter with named values.
#[track_caller]
const fn named(
    id: ParameterId,
    name: &'static str,
    meanings: &'static [(u32, &'static str)],
    factory: u32,
) -> Parameter {
    Parameter {
        permitted: Permitted::Named,
        meanings,
        factory,
        ..Parameter::new(id, name, DataType::U8)
    }
}

/// A mantissa or exponent of the Kalman filter.
#[track_caller]
const fn digit(
    id: ParameterId,
    name: &'static str,
    low: i64,
    high: i64,
    factory: i32,
) -> Parameter {
    Parameter::new(id, name, DataType::I8).within(low, high, factory)
}

const ERRORS: [&str; HISTORY] = [
    "Error 1", "Error 2", "Error 3", "Error 4", "Error 5", "Error 6", "Error 7", "Error 8",
];

/// The parameters that keep the history (1003h).
#[track_caller]
const fn errors() -> [Parameter; HISTORY] {
    let mut errors = [Parameter::plain(); HISTORY];
    each!(place, name in &ERRORS => {
        let id = ParameterId(id::HISTORY.0 + place as u8);
        put(&mut errors, place, Parameter::new(id, name, DataType::U16));
    });
    errors
}

impl Table for Ims360Product {
    /// The image for the Blue Pill has no room for it.
    const KEEPS_USAGE: bool = false;
    /// In the order of the objects, then parameters that are not objects, then those of later versions.
    const PARAMETERS: &'static [Parameter] = crate::parameters![
        [
            Parameter {
                permitted: Permitted::OneOf(&[ONE_AXIS_TYPE, TWO_AXES_TYPE]),
                factory: TWO_AXES_TYPE,
                ..Parameter::new(id::DEVICE_TYPE, "Device type", DataType::U32)
            },
            profile::sync_cob_id(id::SYNC_COB_ID),
            Parameter {
                persistence: Persistence::OnSave,
                ..profile::emcy_cob_id(id::EMCY_COB_ID)
            },
            Parameter {
                permitted: Permitted::Ranges(&PERIODS),
                ..profile::heartbeat_time(id::HEARTBEAT_TIME)
            },
        ],
        profile::stored_tpdo_communication(id::TPDO[0], 0x180),
        profile::stored_tpdo_communication(id::TPDO[1], 0x8000_0280),
        profile::stored_tpdo_communication(id::TPDO[2], 0x8000_0380),
        profile::stored_tpdo_communication(id::TPDO[3], 0x8000_0480),
        profile::mapping_parameters(id::MAPPING[0], &[LONGITUDINAL, LATERAL]),
        profile::mapping_parameters(id::MAPPING[1], &[]),
        profile::mapping_parameters(id::MAPPING[2], &[]),
        profile::mapping_parameters(id::MAPPING[3], &[]),
        [
            Parameter {
                unit: "bit/s",
                permitted: Permitted::OneOf(&[125_000, 250_000, 500_000, 800_000, 1_000_000]),
                factory: 125_000,
                ..Parameter::new(id::BIT_RATE, "Baud rate", DataType::U32)
            },
            profile::lss_node_id(id::NODE_ID, 50),
            Parameter {
                // Another error than that of a range.
                permitted: Permitted::OneOf(&[1, CANOPEN]),
                ..named(
                    id::PROTOCOL,
                    "CAN protocol",
                    &[(1, "SAE J1939"), (CANOPEN, "CANopen")],
                    CANOPEN,
                )
            },
            named(
                id::BUS_OFF_RECOVERY,
                "Automatic bus-off recovery",
                &[(0, "disabled"), (1, "enabled")],
                1,
            ),
            named(
                id::FILTER_TYPE,
                "Low-pass filter type",
                &FILTER_CODING.meanings(),
                CRITICALLY_DAMPED as u32,
            ),
            named(
                id::FUSION,
                "Sensor fusion filter",
                &[(0, "low-pass filter"), (1, "sensor fusion filter")],
                0,
            ),
            Parameter::new(id::CUT_OFF, "Low-pass filter frequency", DataType::U16)
                .in_unit("mHz", 0)
                .within(100, 25_000, 2_000),
            digit(id::Q[0], "Q mantissa", 1, 127, 1),
            digit(id::Q[1], "Q exponent", -10, 10, -3),
            digit(id::R[0], "R mantissa", 1, 127, 1),
            digit(id::R[1], "R exponent", -10, 10, 1),
            Parameter {
                data_type: DataType::I8,
                ..named(
                    id::VARIANT,
                    "Sensor configuration",
                    &[
                        (0, "1-axis sensor (0 to 360 deg)"),
                        (1, "2-axis sensor (+-90 deg)"),
                    ],
                    1,
                )
            },
            Parameter {
                permitted: Permitted::OneOf(&[1, 2, 3]),
                factory: 1,
                persistence: Persistence::Volatile,
                ..Parameter::new(id::AUTO_ZERO, "Auto zero", DataType::I8)
            },
            Parameter::new(id::ZERO_X, "Slope long zero offset", DataType::I32).in_unit("deg", 2),
            Parameter::new(id::ZERO_Y, "Slope lateral zero offset", DataType::I32)
                .in_unit("deg", 2),
            Parameter::new(id::RESTORE_REQUEST, "Requested restore", DataType::U8),
        ],
        errors(),
        J1939,
    ];
    crate::project!(parameters);
}
