//! The functions of the own objects of the IMS360.

use super::application::Ims360Application;
use super::{Ims360Product, groups, parameters, variant};
use crate::application::{Faults, Values};
use crate::canopen::{Abort, Initial, Own, Scope, Then};
use crate::j1939::name::identity_number;
use crate::model::listing::canopen::Defect;
use crate::node::Context;
use crate::text::decimal;

/// Status byte ST0 (3000h:01): the sensor has two axes.
const TWO_AXES: u32 = 1 << 0;
/// Status byte ST0: a sensing element is defective.
const DEFECTIVE: u32 = 1 << 1;
/// The status bit of a defective sensing element.
pub(super) const DEFECT: Defect = Defect {
    index: 0x3000,
    sub: 1,
    bits: DEFECTIVE,
};
/// Status byte ST0: all settings have their factory values.
const FACTORY: u32 = 1 << 2;

type Node = Context<Ims360Application>;

/// The state that is not a parameter.
pub struct State {
    pub(super) variant: variant::State,
    pub(super) restore: groups::State,
}

impl Initial for State {
    const INITIAL: Self = Self {
        variant: variant::State::INITIAL,
        restore: groups::State::INITIAL,
    };
}

/// In the order of the object dictionary.
pub(super) const FUNCTIONS: [Own<Ims360Product>; 13] = [
    groups::store::<1>(),
    groups::store::<2>(),
    groups::store::<3>(),
    groups::store::<4>(),
    groups::restore::<1>(),
    groups::restore::<2>(),
    groups::restore::<3>(),
    groups::restore::<4>(),
    groups::restore::<5>(),
    Own::text(0x2000, 1, |_, node| decimal(node.shell.serial())),
    Own::command(0x2010, 1, set_controller),
    Own::number(0x2106, 9, |_, node| identity_number(node.shell.serial())),
    Own::number(0x3000, 1, status),
];

/// Set controller (7.2.20): 1 restarts the sensor.
fn set_controller(_: &mut Scope<Ims360Product>, data: &[u8]) -> Result<Then, Abort> {
    match data {
        [1] => Ok(Then::Restart),
        _ => Err(Abort::Value),
    }
}

/// The status byte ST0 (section 7.2.27).
fn status(_: &State, node: &Node) -> u32 {
    let flag = |set: bool, flag: u32| if set { flag } else { 0 };
    let defective = Faults::X_DEFECTIVE.and(Faults::Y_DEFECTIVE);
    flag(parameters::has_two_axes(&node.parameters), TWO_AXES)
        | flag(node.values.faults().intersects(defective), DEFECTIVE)
        | flag(node.parameters.is_factory(), FACTORY)
}
