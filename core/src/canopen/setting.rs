//! The objects that the protocol itself uses, found in the object dictionary of a product at compile time.

use super::dictionary::{Object, Target, mistake_at, object_at};
use crate::param::{ParameterId, Setting};
use crate::walk::{each, put};

impl Setting {
    /// The setting at an address; 0 if there is no object.
    pub const fn at(objects: &[Object], index: u16, sub: u8) -> Self {
        Self::at_or(objects, index, sub, 0)
    }

    /// The setting at an address; `default` if there is no object.
    #[track_caller]
    pub const fn at_or(objects: &[Object], index: u16, sub: u8, default: u32) -> Self {
        match object_at(objects, index, sub) {
            None => Self::Constant(default),
            Some(object) => match object.target {
                Target::Parameter(id) | Target::CobId(id) | Target::FreeCobId(id) => {
                    Self::Parameter(id)
                }
                Target::Constant(number) => Self::Constant(number),
                _ => mistake_at(objects, index, sub)
                    .text("the protocol needs a parameter or a constant here")
                    .fail(),
            },
        }
    }
}

/// The communication parameter of a TPDO (1800h and following): sub-index 1 (COB-ID), 2 (transmission type), 3 (inhibit time in 100
/// us) and 5 (event timer in ms). An object that is not there has an id without a parameter.
pub type TpdoSettings = [ParameterId; 4];

/// No product has a parameter with this id, so its value is 0.
const NONE: ParameterId = ParameterId(u8::MAX);

/// The communication parameters of the first `N` TPDOs.
#[track_caller]
pub const fn tpdo_settings<const N: usize>(objects: &[Object]) -> [TpdoSettings; N] {
    let mut settings = [[NONE; 4]; N];
    let mut number = 0;
    while number < N {
        let index = 0x1800 + number as u16;
        let mut own = [NONE; 4];
        each!(place, sub in &[1, 2, 3, 5] => {
            match Setting::at(objects, index, *sub) {
                Setting::Parameter(id) => put(&mut own, place, id),
                Setting::Constant(0) => {}
                Setting::Constant(_) => mistake_at(objects, index, *sub)
                    .text("the communication parameter of a TPDO must be parameters")
                    .fail(),
            }
        });
        put(&mut settings, number, own);
        number += 1;
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canopen::profile::{constant, tpdo};
    use crate::param::DataType;

    #[test]
    fn settings_of_a_tpdo_are_its_parameters() {
        let objects = tpdo(1, "TPDO", ParameterId(7));
        let expected = [7, 8, 9, 10].map(ParameterId);
        assert_eq!(tpdo_settings::<2>(&objects), [[NONE; 4], expected]);
        let [_, cob_id, ..] = objects;
        let [_, settings] = tpdo_settings::<2>(&[cob_id]);
        assert_eq!(settings, [ParameterId(7), NONE, NONE, NONE]);
    }

    #[test]
    #[should_panic = "must be parameters"]
    fn constant_setting_of_a_tpdo_is_refused() {
        tpdo_settings::<1>(&[constant(0x1800, 2, "type", DataType::U8, 254)]);
    }
}
