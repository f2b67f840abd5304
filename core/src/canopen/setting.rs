//! The objects that the protocol itself uses, found in the object dictionary of a product at compile time.

use super::dictionary::{Object, Target, object_at};
use crate::param::{ParameterId, Parameters, Table};

/// The object at an address: a parameter or a constant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Setting {
    /// A parameter.
    Parameter(ParameterId),
    /// A constant.
    Constant(u32),
}

impl Setting {
    /// The setting at an address; 0 if there is no object.
    pub const fn at(objects: &[Object], index: u16, sub: u8) -> Self {
        Self::at_or(objects, index, sub, 0)
    }

    /// The setting at an address; `default` if there is no object.
    #[allow(clippy::panic)] // evaluated at compile time only
    pub const fn at_or(objects: &[Object], index: u16, sub: u8, default: u32) -> Self {
        match object_at(objects, index, sub) {
            None => Self::Constant(default),
            Some(object) => match object.target {
                Target::Parameter(id) | Target::CobId(id) => Self::Parameter(id),
                Target::Constant(number) => Self::Constant(number),
                _ => panic!("the protocol needs a parameter or a constant here"),
            },
        }
    }

    /// The value of the setting.
    pub(super) fn get<T: Table>(self, parameters: &Parameters<T>) -> u32 {
        match self {
            Self::Parameter(id) => parameters.get(id),
            Self::Constant(number) => number,
        }
    }
}

/// The communication parameter of a TPDO (1800h and following).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TpdoSettings {
    /// Sub-index 1.
    pub(super) cob_id: Setting,
    /// Sub-index 2.
    pub(super) transmission_type: Setting,
    /// Sub-index 3, in 100 us.
    pub(super) inhibit_time: Setting,
    /// Sub-index 5, in ms.
    pub(super) event_timer: Setting,
}

/// The communication parameters of the first `N` TPDOs.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn tpdo_settings<const N: usize>(objects: &[Object]) -> [TpdoSettings; N] {
    let mut settings = [TpdoSettings {
        cob_id: Setting::Constant(0),
        transmission_type: Setting::Constant(0),
        inhibit_time: Setting::Constant(0),
        event_timer: Setting::Constant(0),
    }; N];
    let mut number = 0;
    while number < N {
        let index = 0x1800 + number as u16;
        settings[number] = TpdoSettings {
            cob_id: Setting::at(objects, index, 1),
            transmission_type: Setting::at(objects, index, 2),
            inhibit_time: Setting::at(objects, index, 3),
            event_timer: Setting::at(objects, index, 5),
        };
        number += 1;
    }
    settings
}
