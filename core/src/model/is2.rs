//! IS2xx090-C-xL: two axes, +-90 deg, FSC on raw CAN, types of 2021.

use super::gemac::{self, *};
use crate::angle::Angle;
use crate::fsc::table::{Function, LedTable, Parameter, Rule, rules, sorted};
use crate::fsc::{self, Key, Measured, Product, Status, Version};
use crate::measure::definition::{self, Perpendicular};
use crate::measure::{I32x3, zero};
use crate::store::ImageId;

/// The model: tables and measurement of two axes.
pub struct TwoAxes;

/// The sensor.
pub type Is2 = fsc::Sensor<TwoAxes>;

static RULES: [Rule; 10] = rules(<TwoAxes as fsc::Model>::PARAMETERS);

impl fsc::Model for TwoAxes {
    const PARAMETERS: &'static [Parameter] = &[
        SET_ID,
        REPLY_ID,
        SYNC_ID,
        BAUD_RATE,
        BUS_OFF_RECOVERY,
        CYCLIC_TIME,
        CYCLIC_MODE,
        FILTER,
        zero_offset(Key::ZeroX, &[signed_offset("OFX", "Zero Offset X")]),
        zero_offset(Key::ZeroY, &[signed_offset("OFY", "Zero Offset Y")]),
    ];
    const FUNCTIONS: &'static [Function] = sorted(&functions(&[
        signed_angle("AngleX", "Angle X"),
        signed_angle("AngleY", "Angle Y"),
        COUNTER,
    ]));
    const STATUS_BITS: [&'static str; 8] = [
        "DefaultParam",
        "AutobaudDetection",
        "EEPROMError",
        "CmdParamError",
        "SensorErrorX",
        "SensorErrorY",
        "AccuracyWarning",
        "",
    ];
    const LEDS: LedTable = gemac::LEDS;
    const RULES: &'static [Rule] = &RULES;
    const AXES: u8 = 2;
    const SENSOR_ERRORS: u8 = Status::SENSOR_ERROR_X | Status::SENSOR_ERROR_Y;

    fn measure(up: I32x3, product: &Product) -> Measured {
        let Perpendicular { x, y } = definition::perpendicular(up);
        let error = |angle: Angle, bit| {
            let beyond = angle.centidegrees().unsigned_abs() > product.limit.into();
            if beyond { bit } else { 0 }
        };
        let errors = error(x, Status::SENSOR_ERROR_X) | error(y, Status::SENSOR_ERROR_Y);
        Measured {
            x: x.centidegrees(),
            y: y.centidegrees(),
            errors,
        }
    }

    fn with_offset(measured: i32, offset: u32) -> i32 {
        zero::two_axis(measured, offset as i16).into()
    }

    fn zero_for(measured: i32) -> u32 {
        u32::from(zero::two_axis_auto(measured) as u16)
    }
}

/// Largest inclination without SensorError of the classic line, 0.01 deg.
const LIMIT_CLASSIC: u16 = 8500;
/// Largest inclination without SensorError of the basic line, 0.01 deg.
const LIMIT_BASIC: u16 = 8000;

/// Marks the images of this model.
const IMAGE: ImageId = ImageId(0x4702);

const fn product(name: &'static str, article: u32, limit: u16) -> Product {
    let version = Version::Digits {
        major: 0x03,
        minor: 0x44,
    };
    Product {
        name,
        article,
        revision: 1,
        version,
        limit,
        image: IMAGE,
    }
}

/// What the older type has in common with the classic line.
pub(super) const CLASSIC: Product = product("IS2BP090-C-CL", 2_305_430, LIMIT_CLASSIC);

/// Classic line, big plastic housing (PR-23054-30).
pub static BP_CL: Product = CLASSIC;
/// Basic line, aluminium housing (PR-25004-00).
pub static MA_BL: Product = product("IS2MA090-C-BL", 2_500_400, LIMIT_BASIC);
/// Basic line, big plastic housing (PR-25054-30).
pub static BP_BL: Product = product("IS2BP090-C-BL", 2_505_430, LIMIT_BASIC);
/// Basic line, small plastic housing, M8 connector (PR-23064-00).
pub static SP_BL: Product = product("IS2SP090-C-BL", 2_306_400, LIMIT_BASIC);
/// Basic line, small plastic housing, cable (PR-23064-10).
pub static SP_BL_10: Product = product("IS2SP090-C-BL-10", 2_306_410, LIMIT_BASIC);

/// All products of this model.
pub static PRODUCTS: [&Product; 5] = [&BP_CL, &MA_BL, &BP_BL, &SP_BL, &SP_BL_10];
