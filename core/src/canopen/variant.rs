//! Variants of a product that a parameter selects, with other factory values.
//!
//! A stored set contains the mark of the variant for which it was stored. Factory values of that variant follow a new variant; other
//! values stay.

use super::product::{ParametersOf, Product};
use crate::param::ParameterId;

/// A variant of a product. The factory values of the table are those of the variant without an entry in
/// [`VARIANTS`](super::Product::VARIANTS).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Variant {
    /// A short name, for example for the name of a file.
    pub name: &'static str,
    /// The parameter that selects the variant, and its value. It acts after a restart with stored parameters.
    pub selector: (ParameterId, u32),
    /// The read-only stored parameter of the communication profile that shows the variant in force, and its value.
    pub mark: (ParameterId, u32),
    /// The factory values of the parameters that follow the variant together, for example of a mapping. All variants have the same
    /// parameters here.
    pub defaults: &'static [(ParameterId, u32)],
}

/// Adapts restored parameters to the variant with the mark `in_force`; None: the variant that they select.
pub(super) fn adapt<P: Product>(parameters: &mut ParametersOf<P>, in_force: Option<u32>) {
    let Some(shape) = P::VARIANTS.first() else {
        return;
    };
    let (mark, _) = shape.mark;
    let before = find::<P>(|variant| variant.mark.1 == parameters.get(mark));
    let after = find::<P>(|variant| match in_force {
        Some(number) => variant.mark.1 == number,
        None => parameters.get(variant.selector.0) == variant.selector.1,
    });
    let mut ids = shape.defaults.iter().map(|(id, _)| *id);
    if ids.all(|id| parameters.get(id) == default::<P>(before, id)) {
        for (id, _) in shape.defaults {
            parameters.set(*id, default::<P>(after, *id));
        }
    }
    let number = after.map(|variant| variant.mark.1);
    parameters.set(
        mark,
        number.unwrap_or_else(|| ParametersOf::<P>::factory_value(mark)),
    );
}

fn find<P: Product>(wanted: impl Fn(&Variant) -> bool) -> Option<&'static Variant> {
    P::VARIANTS.iter().find(|variant| wanted(variant))
}

/// The factory value of a parameter in a variant.
fn default<P: Product>(variant: Option<&Variant>, id: ParameterId) -> u32 {
    let defaults = variant.map_or(&[][..], |variant| variant.defaults);
    let own = defaults.iter().find(|(other, _)| *other == id);
    own.map_or_else(|| ParametersOf::<P>::factory_value(id), |(_, value)| *value)
}
