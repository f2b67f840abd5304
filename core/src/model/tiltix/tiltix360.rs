//! TILTIX 360: one axis, 360 deg. The lateral angle is constantly 0; all attributes exist.

use super::application::{Axes, Tiltix};
use super::objects;
use super::parameters::{self, Range, Resolution};
use crate::angle::Angle;
use crate::devicenet::{self, Assembly, DevicenetNode, Identity, Object, Roles};
use crate::measure::I32x3;
use crate::measure::definition;
use crate::model::listing;
use crate::param::{Parameter, Parameters, Table};
use crate::store::ImageId;

/// The product: tables and measurement of one axis.
pub struct Tiltix360Product;

/// The node: what a driver or a test starts.
pub type Tiltix360 = DevicenetNode<Tiltix360Product>;

/// The entry in [`PRODUCTS`](crate::model::catalog::PRODUCTS).
pub const LISTING: listing::Product =
    listing::Product::devicenet::<Tiltix360Product>("tiltix360", "TILTIX360")
        .guided(&objects::GUIDE_ONE_AXIS);

impl Table for Tiltix360Product {
    const PARAMETERS: &'static [Parameter] = &parameters::parameters(Self::RANGE);
    crate::project!(parameters);
}

impl Axes for Tiltix360Product {
    const RANGE: Range = Range::Circle;
    const TWO: bool = false;

    fn measure(up: I32x3) -> [Angle; 2] {
        [definition::rotation(up), Angle::ZERO]
    }
}

impl devicenet::Product for Tiltix360Product {
    type Application = Tiltix<Self>;

    const IDENTITY: Identity =
        objects::identity(360, "INCLINOMETER 360 degree", "TILTIX-360-1-D100-VE2-PM");
    const ROLES: Roles = objects::ROLES;
    const OBJECTS: &'static [Object] =
        &[objects::angle(&objects::attributes::<Self::Application>())];
    const ASSEMBLIES: &'static [Assembly] = objects::ASSEMBLIES;
    const IMAGE: ImageId = ImageId::new(0x0360);
    crate::project!(attributes);

    fn distance(parameters: &Parameters<Self>, one: u16, other: u16) -> u16 {
        Self::RANGE.distance(one, other, Resolution::of(parameters))
    }
}
