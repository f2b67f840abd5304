//! What a tool needs besides the tables: short names, the angles, units that a parameter selects, zero point and teach-in.
//!
//! Only programs on a PC use it. A firmware image does not contain it.

use crate::mistake::Mistake;
use crate::param::projection::{exists, has_quantity};
use crate::param::{Parameter, ParameterId, Quantity, ValueId};
use crate::walk::{each, equal};

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

    /// Checks that the tables of the product have each id.
    #[track_caller]
    pub(super) const fn check(&self, parameters: &[Parameter], quantities: &[Quantity]) {
        each!(place, (id, name) in self.short_names => {
            let mistake = Mistake::item(name);
            exists(mistake, parameters, *id);
            Mistake::item("short_names").unless(!name.is_empty(), "a name is empty");
            each!((_, other) in self.short_names.split_at(place).0 => {
                mistake.unless(!equal(name, other), "two parameters have this short name");
            });
        });
        each!(place, (name, ids) in self.groups => {
            let mistake = Mistake::item(name);
            Mistake::item("groups").unless(!name.is_empty(), "a name is empty");
            each!((other, _) in self.groups.split_at(place).0 => {
                mistake.unless(!equal(name, other), "two groups have this name");
            });
            each!(id in *ids => { exists(mistake, parameters, *id) });
        });
        each!(id in self.angles => { has_quantity(Mistake::item("angles"), quantities, *id) });
        if let Some(resolution) = &self.resolution {
            let mistake = Mistake::item("resolution");
            exists(mistake, parameters, resolution.parameter);
            each!(id in resolution.parameters => { exists(mistake, parameters, *id) });
            each!(id in resolution.values => { has_quantity(mistake, quantities, *id) });
        }
        each!(place, adjustment in self.zero => {
            let mistake = Mistake::row("zero", place);
            adjustment.check(mistake, parameters);
            if let Some(offset) = &adjustment.offset {
                has_quantity(mistake, quantities, offset.angle);
            }
        });
        each!(place, adjustment in self.teach => {
            adjustment.check(Mistake::row("teach", place), parameters);
        });
    }
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
    /// The offset with which a tool moves the zero point by a number; None: only the present position can become zero.
    pub offset: Option<Offset>,
}

impl Adjustment {
    /// These writes for an axis.
    pub const fn new(axis: &'static str, writes: &'static [(ParameterId, Written)]) -> Self {
        Self {
            axis,
            writes,
            absent_if: None,
            offset: None,
        }
    }

    /// The same with an offset.
    pub const fn with_offset(self, offset: Offset) -> Self {
        Self {
            offset: Some(offset),
            ..self
        }
    }

    #[track_caller]
    const fn check(&self, mistake: Mistake, parameters: &[Parameter]) {
        mistake.unless(
            matches!(self.axis.as_bytes(), b"" | b"x" | b"y"),
            "the axis is `x`, `y` or empty",
        );
        each!((id, _) in self.writes => { exists(mistake, parameters, *id) });
        if let Some((id, _)) = self.absent_if {
            exists(mistake, parameters, id);
        }
        if let Some(offset) = &self.offset {
            exists(mistake, parameters, offset.parameter);
            if let Some(switch) = &offset.switch {
                exists(mistake, parameters, switch.other);
                exists(mistake, parameters, switch.parameter);
            }
        }
    }
}

/// A parameter that is added to an angle and has its unit.
#[derive(Clone, Copy, Debug)]
pub struct Offset {
    /// The angle.
    pub angle: ValueId,
    /// The parameter.
    pub parameter: ParameterId,
    /// What switches the offset on; None: it always acts.
    pub switch: Option<Switch>,
}

/// A parameter that switches two offsets of an angle on.
#[derive(Clone, Copy, Debug)]
pub struct Switch {
    /// The second offset.
    pub other: ParameterId,
    /// The parameter with the bits.
    pub parameter: ParameterId,
    /// The bits; the offsets act while all of them are set.
    pub bits: u32,
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
