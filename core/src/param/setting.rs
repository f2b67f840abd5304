//! A number that a product has as a parameter or as a constant.

use super::{Parameter, ParameterId, Parameters, Table};

/// A parameter or a constant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Setting {
    /// The number is the value of a parameter.
    Parameter(ParameterId),
    /// The number is a constant of the product.
    Constant(u32),
}

impl Setting {
    /// The number with these values of the parameters.
    pub fn get<T: Table>(self, parameters: &Parameters<T>) -> u32 {
        match self {
            Self::Parameter(id) => parameters.get(id),
            Self::Constant(number) => number,
        }
    }

    /// The number as delivered; 0 for a parameter that the table does not have.
    pub fn factory(self, parameters: &[Parameter]) -> u32 {
        match self {
            Self::Parameter(id) => {
                let parameter = parameters.get(usize::from(id.0));
                parameter.map_or(0, |parameter| parameter.factory)
            }
            Self::Constant(number) => number,
        }
    }
}
