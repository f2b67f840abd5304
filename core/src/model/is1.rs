//! IS1xx360-C-xL: one axis, 360 deg, FSC on raw CAN, types of 2021.

use super::gemac::{self, *};
use crate::fsc::table::{Function, LedTable, Parameter, Rule, rules, sorted};
use crate::fsc::{self, Key, Measured, Product, Status, Version};
use crate::measure::{I32x3, definition, zero};
use crate::store::ImageId;

/// The model: tables and measurement of one axis.
pub struct OneAxis;

/// The sensor.
pub type Is1 = fsc::Sensor<OneAxis>;

static RULES: [Rule; 9] = rules(<OneAxis as fsc::Model>::PARAMETERS);

impl fsc::Model for OneAxis {
    const PARAMETERS: &'static [Parameter] = &[
        SET_ID,
        REPLY_ID,
        SYNC_ID,
        BAUD_RATE,
        BUS_OFF_RECOVERY,
        CYCLIC_TIME,
        CYCLIC_MODE,
        FILTER,
        zero_offset(Key::ZeroX, &[unsigned_offset("OF", "Zero Offset")]),
    ];
    const FUNCTIONS: &'static [Function] =
        sorted(&functions(&[unsigned_angle("Angle", "Angle"), COUNTER]));
    const STATUS_BITS: [&'static str; 8] = [
        "DefaultParam",
        "AutobaudDetection",
        "EEPROMError",
        "CmdParamError",
        "SensorError",
        "",
        "AccuracyWarning",
        "",
    ];
    const LEDS: LedTable = gemac::LEDS;
    const RULES: &'static [Rule] = &RULES;
    const AXES: u8 = 1;
    const SENSOR_ERRORS: u8 = Status::SENSOR_ERROR;

    fn measure(up: I32x3, product: &Product) -> Measured {
        let cross_slope = definition::cross_slope(up).centidegrees();
        let tilted = cross_slope.unsigned_abs() > product.limit.into();
        Measured {
            x: definition::rotation(up).centidegrees_unsigned().into(),
            y: 0,
            errors: if tilted { Status::SENSOR_ERROR } else { 0 },
        }
    }

    fn with_offset(measured: i32, offset: u32) -> i32 {
        zero::one_axis(measured as u16, offset as u16).into()
    }

    fn zero_for(measured: i32) -> u32 {
        zero::one_axis_auto(measured as u16).into()
    }
}

/// Largest cross slope without SensorError, 0.01 deg.
const CROSS_SLOPE: u16 = 4500;

/// Marks the images of this model.
const IMAGE: ImageId = ImageId(0x4701);

const fn product(name: &'static str, article: u32) -> Product {
    let version = Version::Digits {
        major: 0x03,
        minor: 0x44,
    };
    Product {
        name,
        article,
        revision: 1,
        version,
        limit: CROSS_SLOPE,
        image: IMAGE,
    }
}

/// What the older type has in common with the classic line.
pub(super) const CLASSIC: Product = product("IS1BP360-C-CL", 2_305_030);

/// Classic line, big plastic housing (PR-23050-30).
pub static BP_CL: Product = CLASSIC;
/// Basic line, aluminium housing (PR-25000-00).
pub static MA_BL: Product = product("IS1MA360-C-BL", 2_500_000);
/// Basic line, big plastic housing (PR-25050-30).
pub static BP_BL: Product = product("IS1BP360-C-BL", 2_505_030);
/// Basic line, small plastic housing, M8 connector (PR-23060-00).
pub static SP_BL: Product = product("IS1SP360-C-BL", 2_306_000);
/// Basic line, small plastic housing, cable (PR-23060-10).
pub static SP_BL_10: Product = product("IS1SP360-C-BL-10", 2_306_010);

/// All products of this model.
pub static PRODUCTS: [&Product; 5] = [&BP_CL, &MA_BL, &BP_BL, &SP_BL, &SP_BL_10];
