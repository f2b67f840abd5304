//! IS2xx090-C-xL: two axes, +-90 deg, FSC on raw CAN, types of 2021.

use super::application::{Axes, Gemac};
use super::functions::{self, ANGLE_X, ANGLE_Y, signed_angle};
use super::parameters::{self, *};
use crate::angle::Angle;
use crate::application::Faults;
use crate::fsc::table::{Access, Function, LedTable, Roles};
use crate::fsc::{self, Article, ArticleNumber, FscNode, StatusBit, Version};
use crate::measure::definition::{self, Perpendicular};
use crate::measure::{I32x3, zero};
use crate::model::listing;
use crate::param::{Constraint, Parameter, Quantity, Table};
use crate::store::ImageId;

/// The product: tables and measurement of two axes.
pub struct TwoAxes;

/// The node: what a driver or a test starts.
pub type Is2 = FscNode<TwoAxes>;

impl Table for TwoAxes {
    const PARAMETERS: &'static [Parameter] = crate::parameters![
        COMMON,
        [
            signed_offset(id::ZERO_X, "Zero Offset X"),
            signed_offset(id::ZERO_Y, "Zero Offset Y")
        ]
    ];
    const CONSTRAINTS: &'static [Constraint] = parameters::CONSTRAINTS;
    crate::project!(parameters);
}

impl Axes for TwoAxes {
    const QUANTITIES: &'static [Quantity] = &[
        signed_angle(ANGLE_X, "Angle X"),
        signed_angle(ANGLE_Y, "Angle Y"),
    ];
    const ANGLES: Faults = Faults::X.and(Faults::Y);

    fn measure(up: I32x3, limit: u16) -> ([i32; 2], Faults) {
        let Perpendicular { x, y } = definition::perpendicular(up);
        let beyond = |angle: Angle| angle.centidegrees().unsigned_abs() > limit.into();
        let faults = Faults::X.when(beyond(x)).and(Faults::Y.when(beyond(y)));
        ([x.centidegrees(), y.centidegrees()], faults)
    }

    fn with_offset(measured: i32, offset: u32) -> i32 {
        zero::two_axis(measured, offset as i16).into()
    }

    fn zero_for(measured: i32) -> u32 {
        u32::from(zero::two_axis_auto(measured) as u16)
    }
}

impl fsc::Product for TwoAxes {
    type Application = Gemac<Self, false>;

    const ROLES: Roles = functions::ROLES;
    const ACCESS: &'static [Access] = functions::ACCESS_TWO_AXES;
    const FUNCTIONS: &'static [Function] = functions::FUNCTIONS_TWO_AXES;
    const STATUS: [StatusBit; 8] = functions::STATUS_TWO_AXES;
    const LEDS: LedTable = functions::LEDS;
    crate::project!(functions);

    fn set_article(application: &mut Self::Application, article: &Article) {
        application.set_limit(article.limit);
    }
}

/// Largest inclination without SensorError of the classic line, 0.01 deg.
const LIMIT_CLASSIC: u16 = 85_00;
/// Largest inclination without SensorError of the basic line, 0.01 deg.
const LIMIT_BASIC: u16 = 80_00;

/// The identification of the stored images of this product.
const IMAGE: ImageId = ImageId::new(0x4702);

const fn article(name: &'static str, number: &'static str, limit: u16) -> Article {
    let version = Version::Digits {
        major: 0x03,
        minor: 0x44,
    };
    Article {
        name,
        number: ArticleNumber::new(number),
        revision: 1,
        version,
        limit,
        image: IMAGE,
    }
}

/// The article of the classic line, also used for the older type and the reference line.
pub(super) const CLASSIC: Article = article("IS2BP090-C-CL", "PR-23054-30", LIMIT_CLASSIC);

/// Classic line, large plastic housing (PR-23054-30).
pub const BP_CL: Article = CLASSIC;
/// Basic line, aluminium housing (PR-25004-00).
pub const MA_BL: Article = article("IS2MA090-C-BL", "PR-25004-00", LIMIT_BASIC);
/// Basic line, large plastic housing (PR-25054-30).
pub const BP_BL: Article = article("IS2BP090-C-BL", "PR-25054-30", LIMIT_BASIC);
/// Basic line, small plastic housing, M8 connector (PR-23064-00).
pub const SP_BL: Article = article("IS2SP090-C-BL", "PR-23064-00", LIMIT_BASIC);
/// Basic line, small plastic housing, cable (PR-23064-10).
pub const SP_BL_10: Article = article("IS2SP090-C-BL-10", "PR-23064-10", LIMIT_BASIC);

/// The catalogue entry with all articles.
pub const LISTING: listing::Product =
    listing::Product::fsc::<TwoAxes>("is2", super::MAKER, &[BP_CL, MA_BL, BP_BL, SP_BL, SP_BL_10])
        .guided(&super::functions::GUIDE_TWO_AXES);
