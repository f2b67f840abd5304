//! IS1xx360-C-xL: one axis, 360 deg, FSC on raw CAN, types of 2021.

use super::application::{Axes, Gemac};
use super::functions::{self, ANGLE_X, unsigned_angle};
use super::parameters::{self, *};
use crate::application::Faults;
use crate::fsc::table::{Access, Function, LedTable, Roles};
use crate::fsc::{self, Article, ArticleNumber, FscNode, StatusBit, Version};
use crate::measure::{I32x3, definition, zero};
use crate::model::listing;
use crate::param::{Constraint, Parameter, Quantity, Table};
use crate::store::ImageId;

/// The product: tables and measurement of one axis.
pub struct OneAxis;

/// The node: what a driver or a test starts.
pub type Is1 = FscNode<OneAxis>;

impl Table for OneAxis {
    const PARAMETERS: &'static [Parameter] =
        crate::parameters![COMMON, [unsigned_offset(id::ZERO_X, "Zero Offset")]];
    const CONSTRAINTS: &'static [Constraint] = parameters::CONSTRAINTS;
    crate::project!(parameters);
}

impl Axes for OneAxis {
    const QUANTITIES: &'static [Quantity] = &[unsigned_angle(ANGLE_X, "Angle")];
    const ANGLES: Faults = Faults::X;

    fn measure(up: I32x3, limit: u16) -> ([i32; 2], Faults) {
        let cross_slope = definition::cross_slope(up).centidegrees();
        let tilted = cross_slope.unsigned_abs() > limit.into();
        let angle = definition::rotation(up).centidegrees_unsigned();
        ([angle.into(), 0], Faults::X.when(tilted))
    }

    fn with_offset(measured: i32, offset: u32) -> i32 {
        zero::one_axis(measured as u16, offset as u16).into()
    }

    fn zero_for(measured: i32) -> u32 {
        zero::one_axis_auto(measured as u16).into()
    }
}

impl fsc::Product for OneAxis {
    type Application = Gemac<Self, false>;

    const ROLES: Roles = functions::ROLES;
    const ACCESS: &'static [Access] = functions::ACCESS_ONE_AXIS;
    const FUNCTIONS: &'static [Function] = functions::FUNCTIONS_ONE_AXIS;
    const STATUS: [StatusBit; 8] = functions::STATUS_ONE_AXIS;
    const LEDS: LedTable = functions::LEDS;
    crate::project!(functions);

    fn set_article(application: &mut Self::Application, article: &Article) {
        application.set_limit(article.limit);
    }
}

/// Largest cross slope without SensorError, 0.01 deg.
const CROSS_SLOPE: u16 = 45_00;

/// The identification of the stored images of this product.
const IMAGE: ImageId = ImageId::new(0x4701);

const fn article(name: &'static str, number: &'static str) -> Article {
    let version = Version::Digits {
        major: 0x03,
        minor: 0x44,
    };
    Article {
        name,
        number: ArticleNumber::new(number),
        revision: 1,
        version,
        limit: CROSS_SLOPE,
        image: IMAGE,
    }
}

/// The article of the classic line, also used for the older type and the reference line.
pub(super) const CLASSIC: Article = article("IS1BP360-C-CL", "PR-23050-30");

/// Classic line, large plastic housing (PR-23050-30).
pub const BP_CL: Article = CLASSIC;
/// Basic line, aluminium housing (PR-25000-00).
pub const MA_BL: Article = article("IS1MA360-C-BL", "PR-25000-00");
/// Basic line, large plastic housing (PR-25050-30).
pub const BP_BL: Article = article("IS1BP360-C-BL", "PR-25050-30");
/// Basic line, small plastic housing, M8 connector (PR-23060-00).
pub const SP_BL: Article = article("IS1SP360-C-BL", "PR-23060-00");
/// Basic line, small plastic housing, cable (PR-23060-10).
pub const SP_BL_10: Article = article("IS1SP360-C-BL-10", "PR-23060-10");

/// The catalogue entry with all articles.
pub const LISTING: listing::Product =
    listing::Product::fsc::<OneAxis>("is1", super::MAKER, &[BP_CL, MA_BL, BP_BL, SP_BL, SP_BL_10])
        .guided(&super::functions::GUIDE_ONE_AXIS);
