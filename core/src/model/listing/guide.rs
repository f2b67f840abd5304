//! What a tool needs besides the tables: short names, the angles, units that a parameter selects, zero point and teach-in.
//!
//! Only programs on a PC use it. A firmware image does not contain it.

use crate::param::{ParameterId, ValueId};

/// A guide to a product for tools that show it and set it up.
#[derive(Clone, Copy, Debug)]
pub struct Guide {
    /// Short names of parameters, for command lines and files. Other parameters have the name of the table.
    pub short_names: &'static [(ParameterId, &'static str)],
    /// Names for several parameters that are set together, for example `filter`.
    pub groups: &'static [(&'static str, &'static [ParameterId])],
    /// The published values that are the measured angles.
    pub angles: &'static [ValueId],
    /// The unit that a parameter selects.
    pub resolution: Option<Resolution>,
    /// How the present position becomes the zero point, one entry for each axis; one entry without name for all axes together.
    pub zero: &'static [Adjustment],
    /// How the present position becomes the reference of the teach-in; empty if the product has none.
    pub teach: &'static [Adjustment],
}

impl Guide {
    /// No guidance: the tables are sufficient.
    pub const NONE: Self = Self {
        short_names: &[],
        groups: &[],
        angles: &[],
        resolution: None,
        zero: &[],
        teach: &[],
    };
}

/// A parameter whose value, in its own unit, is the unit of other numbers.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    /// The parameter with the unit.
    pub parameter: ParameterId,
    /// The parameters in this unit. Their permitted values in the table are those at the factory value of the resolution.
    pub parameters: &'static [ParameterId],
    /// The published values in this unit.
    pub values: &'static [ValueId],
}

/// Writes that make the present position a reference.
#[derive(Clone, Copy, Debug)]
pub struct Adjustment {
    /// The axis, `x` or `y`; empty for all axes.
    pub axis: &'static str,
    /// The writes, in this order.
    pub writes: &'static [(ParameterId, Written)],
    /// The axis does not exist while this parameter has this value.
    pub absent_if: Option<(ParameterId, u32)>,
}

impl Adjustment {
    /// These writes for an axis.
    pub const fn new(axis: &'static str, writes: &'static [(ParameterId, Written)]) -> Self {
        Self {
            axis,
            writes,
            absent_if: None,
        }
    }
}

/// What is written to a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Written {
    /// A request without data: the sensor takes the number from the present position.
    Nothing,
    /// This number, as a raw number.
    Number(u32),
    /// The present number with these bits set.
    Bits(u32),
}
