//! The variants of the IMS360: with one axis, the device type and the factory mapping of the first TPDO differ.
//!
//! A stored set contains the device type of the variant for which it was stored. A new variant replaces the factory mapping of the stored
//! variant by its own. It keeps any other mapping.

use super::Ims360Product;
use super::parameters::{ONE_AXIS, ONE_AXIS_TYPE, TWO_AXES_TYPE, id};
use crate::canopen::Initial;
use crate::param::{ParameterId, Parameters};

/// The device type (1000h) of the variant in force.
pub struct State {
    device_type: u32,
}

impl Initial for State {
    const INITIAL: Self = Self { device_type: 0 };
}

/// Adapts restored parameters: at a start to the variant that they select, otherwise to the variant in force.
pub(super) fn adapt(state: &mut State, parameters: &mut Parameters<Ims360Product>, starts: bool) {
    if starts {
        let (selector, one_axis) = ONE_AXIS.selector;
        state.device_type = if parameters.get(selector) == one_axis {
            ONE_AXIS_TYPE
        } else {
            TWO_AXES_TYPE
        };
    }
    let before = parameters.get(id::DEVICE_TYPE);
    let after = state.device_type;
    let mut defaults = ONE_AXIS.defaults.iter();
    if defaults.all(|row| parameters.get(row.0) == default(before, *row)) {
        for row in ONE_AXIS.defaults {
            parameters.set(row.0, default(after, *row));
        }
    }
    parameters.set(id::DEVICE_TYPE, after);
}

/// The factory value of a parameter with this device type.
fn default(device_type: u32, (id, one_axis): (ParameterId, u32)) -> u32 {
    if device_type == ONE_AXIS_TYPE {
        one_axis
    } else {
        Parameters::<Ims360Product>::factory_value(id)
    }
}
