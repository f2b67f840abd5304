//! TILTIX 080: two axes, +-80 deg.

use super::application::{Axes, Tiltix};
use super::objects;
use super::parameters::{self, Range, Resolution};
use crate::angle::Angle;
use crate::devicenet::{self, Assembly, DevicenetNode, Identity, Object, Roles};
use crate::measure::I32x3;
use crate::measure::definition::{self, Perpendicular};
use crate::model::listing;
use crate::param::{Parameter, Parameters, Table};
use crate::store::ImageId;

/// The product: tables and measurement of two axes.
pub struct Tiltix080Product;

/// The node: what a driver or a test starts.
pub type Tiltix080 = DevicenetNode<Tiltix080Product>;

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::devicenet::<Tiltix080Product>("tiltix080", "TILTIX080")
        .guided(&objects::GUIDE_TWO_AXES);

impl Table for Tiltix080Product {
    const PARAMETERS: &'static [Parameter] = &parameters::parameters(Self::RANGE);
    crate::project!(parameters);
}

impl Axes for Tiltix080Product {
    const RANGE: Range = Range::Signed;
    const TWO: bool = true;

    fn measure(up: I32x3) -> [Angle; 2] {
        let Perpendicular { x, y } = definition::perpendicular(up);
        [x, y]
    }
}

impl devicenet::Product for Tiltix080Product {
    type Application = Tiltix<Self>;

    const IDENTITY: Identity =
        objects::identity(80, "INCLINOMETER 080 degree", "TILTIX-080-2-D100-HE2-PM");
    const ROLES: Roles = objects::ROLES;
    const OBJECTS: &'static [Object] =
        &[objects::angle(&objects::attributes::<Self::Application>())];
    const ASSEMBLIES: &'static [Assembly] = objects::ASSEMBLIES;
    const IMAGE: ImageId = ImageId::new(0x0080);
    crate::project!(attributes);

    fn distance(parameters: &Parameters<Self>, one: u16, other: u16) -> u16 {
        Self::RANGE.distance(one, other, Resolution::of(parameters))
    }
}
