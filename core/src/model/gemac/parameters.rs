//! The device parameters of the GEMAC sensors (tables 17 to 19, section 9.10).

use crate::can::BitRate;
use crate::fsc::wire::IDENTIFIERS;
use crate::measure::low_pass::Kind;
use crate::param::{Coding, Constraint, DataType, Parameter, ParameterId, Permitted, Relation};

/// The ids of the parameters: their indices in the tables. They also define the order in the stored image.
pub mod id {
    crate::ids! { pub ParameterId:
        /// Set-Parameter-ID: the identifier of requests.
        SET_ID,
        /// Reply-Parameter-ID: the identifier of replies.
        REPLY_ID,
        /// Sync-ID: the identifier of sync frames.
        SYNC_ID,
        /// The code of the baud rate; 0: automatic detection.
        BAUD_RATE,
        /// Whether the node leaves bus-off automatically.
        BUS_OFF_RECOVERY,
        /// The time between two messages in cyclic mode, in ms.
        CYCLIC_TIME,
        /// Whether cyclic mode is on.
        CYCLIC_MODE,
        /// The cut-off frequency of the digital filter in mHz.
        CUT_OFF,
        /// The code of the filter type; 0: off.
        FILTER_TYPE,
        /// Zero offset, or zero offset X.
        ZERO_X,
        /// Zero offset Y; 2-axis sensors only.
        ZERO_Y,
    }
}

/// The codes of the baud rate (section 9.10.3); None: automatic detection.
const BAUD_RATE_CODING: Coding<Option<BitRate>, 11> = Coding([
    (0, "automatic detection", None),
    (1, BitRate::K10.name(), Some(BitRate::K10)),
    (2, BitRate::K20.name(), Some(BitRate::K20)),
    (3, BitRate::K50.name(), Some(BitRate::K50)),
    (4, BitRate::K100.name(), Some(BitRate::K100)),
    (5, BitRate::K125.name(), Some(BitRate::K125)),
    (6, BitRate::K250.name(), Some(BitRate::K250)),
    (7, BitRate::K500.name(), Some(BitRate::K500)),
    (8, BitRate::K800.name(), Some(BitRate::K800)),
    (9, BitRate::M1.name(), Some(BitRate::M1)),
    (10, BitRate::K62_5.name(), Some(BitRate::K62_5)),
]);

/// The codes of the baud rate in the form that the device uses.
pub(super) static BAUD_RATES: [Option<BitRate>; 11] = BAUD_RATE_CODING.sequence();

/// The code of the critically damped filter. It has its own highest cut-off frequency.
const CRITICALLY_DAMPED: u16 = 2;

/// The codes of the filter type (section 9.10.5).
const FILTER_CODING: Coding<Kind, 3> = Coding([
    (0, "off", Kind::Analog),
    (1, "Butterworth", Kind::Butterworth),
    (
        CRITICALLY_DAMPED,
        "critically damped",
        Kind::CriticallyDamped,
    ),
]);

/// The codes of the filter type in the form that the device uses.
pub(super) static FILTER_KINDS: [Kind; 3] = FILTER_CODING.sequence();

/// The constraints between parameters: the identifiers are different (section 9.10.2), and the cut-off frequency is in the range
/// of the filter type (section 9.10.5).
pub(super) const CONSTRAINTS: &[Constraint] = &[
    Constraint::different(id::SET_ID, id::REPLY_ID),
    Constraint::different(id::SET_ID, id::SYNC_ID),
    Constraint::different(id::REPLY_ID, id::SYNC_ID),
    Constraint::new(Relation::AtMost {
        parameter: id::CUT_OFF,
        high: *Kind::CriticallyDamped.cutoffs().end(),
        other: id::FILTER_TYPE,
        number: CRITICALLY_DAMPED,
    }),
];

#[track_caller]
const fn identifier(id: ParameterId, name: &'static str, factory: u32) -> Parameter {
    Parameter {
        id,
        name,
        data_type: DataType::U32,
        permitted: Permitted::Ranges(&IDENTIFIERS),
        factory,
        ..Parameter::plain()
    }
}

/// The identifier of requests. Factory value 300h.
pub const SET_ID: Parameter = identifier(id::SET_ID, "Set-Parameter-ID", 0x300);

/// The identifier of replies. Factory value 301h.
pub const REPLY_ID: Parameter = identifier(id::REPLY_ID, "Reply-Parameter-ID", 0x301);

/// The identifier of sync frames. Factory value 100h.
pub const SYNC_ID: Parameter = identifier(id::SYNC_ID, "Sync-ID", 0x100);

/// Baud rate. Factory value 0 (automatic detection).
pub const BAUD_RATE: Parameter = Parameter {
    id: id::BAUD_RATE,
    name: "Baud Rate",
    permitted: Permitted::Named,
    meanings: &BAUD_RATE_CODING.meanings(),
    ..Parameter::plain()
};

/// Automatic bus-off recovery. Factory value 0 (stays in bus-off).
pub const BUS_OFF_RECOVERY: Parameter = Parameter {
    id: id::BUS_OFF_RECOVERY,
    name: "Automatic Bus-Off Recovery",
    permitted: Permitted::Named,
    meanings: &[(0, "stays in bus-off"), (1, "recovers")],
    ..Parameter::plain()
};

/// Cyclic time, 1 to 65535 ms. Factory value 250 ms.
pub const CYCLIC_TIME: Parameter = Parameter {
    id: id::CYCLIC_TIME,
    name: "Cyclic Time",
    data_type: DataType::U16,
    unit: "ms",
    permitted: Permitted::Range(1, 65_535),
    factory: 250,
    ..Parameter::plain()
};

/// Cyclic mode. Factory value 0 (off).
pub const CYCLIC_MODE: Parameter = Parameter {
    id: id::CYCLIC_MODE,
    name: "Cyclic Mode",
    permitted: Permitted::Named,
    meanings: &[(0, "off"), (1, "on")],
    ..Parameter::plain()
};

/// Cut-off frequency, 100 to 25000 mHz; at most 8000 mHz for the critically damped filter. Factory value 2000 mHz.
pub const CUT_OFF: Parameter = Parameter {
    id: id::CUT_OFF,
    name: "Cut-off Frequency",
    data_type: DataType::U16,
    unit: "mHz",
    permitted: Permitted::Range(
        *Kind::Butterworth.cutoffs().start() as i64,
        *Kind::Butterworth.cutoffs().end() as i64,
    ),
    factory: 2000,
    ..Parameter::plain()
};

/// Filter type. Factory value 2 (critically damped).
pub const FILTER_TYPE: Parameter = Parameter {
    id: id::FILTER_TYPE,
    name: "Filter Type",
    permitted: Permitted::Named,
    meanings: &FILTER_CODING.meanings(),
    factory: CRITICALLY_DAMPED as u32,
    ..Parameter::plain()
};

/// The parameters that all sensors have, in the order of their ids.
pub(super) const COMMON: [Parameter; 9] = [
    SET_ID,
    REPLY_ID,
    SYNC_ID,
    BAUD_RATE,
    BUS_OFF_RECOVERY,
    CYCLIC_TIME,
    CYCLIC_MODE,
    CUT_OFF,
    FILTER_TYPE,
];

/// A zero offset of -90 to +90 deg (2-axis sensors).
#[track_caller]
pub(super) const fn signed_offset(id: ParameterId, name: &'static str) -> Parameter {
    Parameter {
        id,
        name,
        data_type: DataType::I16,
        unit: "deg",
        decimals: 2,
        permitted: Permitted::Range(-90_00, 90_00),
        ..Parameter::plain()
    }
}

/// A zero offset of 0 to 359.99 deg (1-axis sensors).
#[track_caller]
pub(super) const fn unsigned_offset(id: ParameterId, name: &'static str) -> Parameter {
    Parameter {
        id,
        name,
        data_type: DataType::U16,
        unit: "deg",
        decimals: 2,
        permitted: Permitted::Range(0, 35_999),
        ..Parameter::plain()
    }
}
