//! Projection of the parameter descriptions of a product into the form that the device uses.
//!
//! All functions are evaluated at compile time. An inconsistent description is a compile error.

use super::row::{Limits, ParameterRow, ordered};
use super::wide::WideLimits;
use super::{
    Constraint, DataType, Parameter, ParameterId, ParameterSet, Permitted, Persistence, Quantity,
    Relation, ValueId,
};
use crate::mistake::Mistake;
use crate::walk::{at, each, put};

/// The maximum number of parameters of a product.
pub const PARAMETERS_MAX: usize = ParameterSet::CAPACITY;

/// The factory value of each parameter.
#[track_caller]
pub const fn factory<const N: usize>(parameters: &[Parameter]) -> [u32; N] {
    Mistake::item("PARAMETERS").unless(
        parameters.len() == N && N <= PARAMETERS_MAX,
        "a product has at most 128 parameters",
    );
    let mut values = [0; N];
    each!(place, parameter in parameters => { put(&mut values, place, parameter.factory) });
    values
}

/// The parameters in the form that the device uses.
///
/// A row whose id is not its index, a range outside the type, and a factory value that is not permitted are compile errors.
#[track_caller]
pub const fn rows<const N: usize>(
    parameters: &[Parameter],
    constraints: &[Constraint],
) -> [ParameterRow; N] {
    let empty = ParameterRow::new(DataType::U8, Persistence::Volatile, 0, (0, 0));
    let mut rows = [empty; N];
    each!(place, parameter in parameters => {
        Mistake::parameter(place, parameter.name)
            .at(parameter.origin)
            .unless(
                parameter.id.0 as usize == place,
                "the id of a parameter must be its index",
            );
        let mistake = parameter.mistake();
        check(parameter);
        if parameter.data_type.is_wide() {
            check_wide(mistake, parameters.split_at(place).1);
        }
    });
    check_constraints(parameters, constraints);
    let places = places(parameters);
    each!(place, parameter in parameters => {
        let ignored_bits = match parameter.permitted {
            Permitted::Ranges(ranges) => ranges.ignored_bits,
            _ => 0,
        };
        let ranges = (*at(&places, place), count(parameter));
        parameter.mistake().unless(
            ranges.0 + ranges.1 < 256,
            "the table has more than 255 ranges of permitted numbers",
        );
        let row = ParameterRow::new(parameter.data_type, parameter.persistence, ignored_bits, ranges);
        put(&mut rows, place, row);
    });
    rows
}

/// Whether a parameter is a real number of 32 bits.
pub const fn has_reals(parameters: &[Parameter]) -> bool {
    each!(parameter in parameters => {
        if let DataType::Real32 = parameter.data_type {
            return true;
        }
    });
    false
}

/// The number of parameters of 64 bits that do not permit all numbers.
pub const fn wide_count(parameters: &[Parameter]) -> usize {
    let mut count = 0;
    each!(parameter in parameters => { count += WideLimits::of(parameter).is_some() as usize });
    count
}

/// The limits of the parameters of 64 bits that do not permit all numbers.
pub const fn wide_limits<const N: usize>(parameters: &[Parameter]) -> [WideLimits; N] {
    let (mut limits, mut place) = ([WideLimits::ANY; N], 0);
    each!(parameter in parameters => {
        if let Some(own) = WideLimits::of(parameter) {
            put(&mut limits, place, own);
            place += 1;
        }
    });
    limits
}

/// The number of ranges in the pool.
pub const fn pool_size(parameters: &[Parameter]) -> usize {
    *at(&places(parameters), parameters.len())
}

/// The pool of permitted ranges of the rows. Parameters with the same ranges share them.
pub const fn pool<const N: usize>(parameters: &[Parameter]) -> [Limits; N] {
    let mut pool = [(0, 0); N];
    let places = places(parameters);
    each!(place, parameter in parameters => {
        let mut range = 0;
        while range < count(parameter) {
            put(&mut pool, *at(&places, place) + range, limits(parameter, range));
            range += 1;
        }
    });
    pool
}

/// The size in bytes of the stored parameters.
pub const fn stored_size(parameters: &[Parameter]) -> usize {
    let mut size = 0;
    each!(parameter in parameters => {
        if parameter.persistence as u8 != Persistence::Volatile as u8 {
            // A row of a parameter of 64 bits has 32.
            let own = parameter.data_type.size() as usize;
            size += if own > 4 { 4 } else { own };
        }
    });
    size
}

/// Whether the named numbers are consecutive, so that they are one range.
const fn is_sequence(parameter: &Parameter) -> bool {
    let [(first, _), ..] = parameter.meanings else {
        return false;
    };
    each!(place, (number, _) in parameter.meanings => {
        if *number != *first + place as u32 {
            return false;
        }
    });
    true
}

/// The number of permitted ranges of a parameter; 0: all numbers are permitted, or it has 64 bits.
const fn count(parameter: &Parameter) -> usize {
    match parameter.permitted {
        _ if parameter.data_type.is_wide() => 0,
        Permitted::Any => 0,
        Permitted::Range(..) => 1,
        Permitted::Named if is_sequence(parameter) => 1,
        Permitted::Named => parameter.meanings.len(),
        Permitted::OneOf(numbers) => numbers.len(),
        Permitted::Ranges(ranges) => ranges.ranges.len(),
    }
}

/// The limits of one permitted range, as ordered numbers.
const fn limits(parameter: &Parameter, range: usize) -> Limits {
    let (low, high) = match parameter.permitted {
        Permitted::Any => (0, u32::MAX),
        Permitted::Range(low, high) => match parameter.data_type {
            DataType::Real32 => ((low as f32).to_bits(), (high as f32).to_bits()),
            _ => (low as u32, high as u32),
        },
        Permitted::Named if is_sequence(parameter) => {
            let names = parameter.meanings;
            (at(names, 0).0, at(names, names.len() - 1).0)
        }
        Permitted::Named => (
            at(parameter.meanings, range).0,
            at(parameter.meanings, range).0,
        ),
        Permitted::OneOf(numbers) => (*at(numbers, range), *at(numbers, range)),
        Permitted::Ranges(ranges) => *at(ranges.ranges, range),
    };
    (
        ordered(parameter.data_type, low),
        ordered(parameter.data_type, high),
    )
}

/// The index of the first range of each row in the pool: that of an earlier row with the same ranges, or the next free one. After the
/// last row: the size of the pool.
const fn places(parameters: &[Parameter]) -> [usize; PARAMETERS_MAX + 1] {
    let (mut places, mut end) = ([0; PARAMETERS_MAX + 1], 0);
    each!(row, parameter in parameters => {
        let mut first = end;
        each!(place, other in parameters.split_at(row).0 => {
            if is_alike(other, parameter) {
                first = *at(&places, place);
                break;
            }
        });
        put(&mut places, row, first);
        let after = first + count(parameter);
        if after > end {
            end = after;
        }
    });
    put(&mut places, parameters.len(), end);
    places
}

/// Whether two parameters permit the same ranges.
const fn is_alike(one: &Parameter, other: &Parameter) -> bool {
    let ranges = count(one);
    if ranges != count(other) {
        return false;
    }
    let mut range = 0;
    while range < ranges {
        let (a, b) = (limits(one, range), limits(other, range));
        if a.0 != b.0 || a.1 != b.1 {
            return false;
        }
        range += 1;
    }
    true
}

/// Checks the two rows of a parameter of 64 bits.
#[track_caller]
const fn check_wide(mistake: Mistake, rows: &[Parameter]) {
    let [lower, upper, ..] = rows else {
        mistake.text(TWO_ROWS).fail();
    };
    mistake.unless(is_upper(lower, upper), TWO_ROWS);
    mistake.unless(
        matches!(lower.permitted, Permitted::Any | Permitted::Range(..)),
        "a parameter of 64 bits permits all numbers, or one range",
    );
    let factory = (upper.factory as u64) << 32 | lower.factory as u64;
    if let Some(limits) = WideLimits::of(lower) {
        mistake.unless(limits.permit(factory), NOT_PERMITTED);
    }
}

const TWO_ROWS: &str = "a parameter of 64 bits has two rows: `Parameter::wide`";
const TOO_FINE: &str = "a number has at most 9 digits after the decimal point";
const NOT_PERMITTED: &str = "the factory value must be permitted";

/// Whether a row is that of the upper 32 bits of a parameter.
const fn is_upper(parameter: &Parameter, upper: &Parameter) -> bool {
    matches!(upper.data_type, DataType::U32)
        && matches!(upper.permitted, Permitted::Any)
        && upper.name.is_empty()
        && upper.persistence as u8 == parameter.persistence as u8
}

/// Checks that a description is consistent.
#[track_caller]
const fn check(parameter: &Parameter) {
    let data_type = parameter.data_type;
    let mistake = parameter.mistake();
    mistake.unless(data_type.size() > 0, "a parameter must be a number");
    mistake.unless(parameter.decimals < 10, TOO_FINE);
    mistake.unless(
        parameter.decimals == 0 || !data_type.is_real(),
        "a real number has its own decimal point: no decimals",
    );
    let (least, most) = data_type.range();
    mistake.unless(
        fits(data_type, parameter.factory),
        "the factory value must fit the type",
    );
    match parameter.permitted {
        Permitted::Range(low, high) => {
            mistake.unless(
                least <= low && low <= high && high <= most,
                "the range must fit the type",
            );
        }
        Permitted::Ranges(ranges) => {
            mistake.unless(!data_type.is_signed(), "ranges need an unsigned type");
            mistake.unless(
                ranges.ignored_bits == 0 || data_type.size() == 4,
                "ignored bits need a type of 32 bits",
            );
            mistake.unless(ranges.ignored_bits < 4, "at most 3 bits are ignored");
            each!((low, high) in ranges.ranges => {
                mistake.unless(
                    *low <= *high && fits(data_type, *high),
                    "the ranges must fit the type",
                );
            });
        }
        Permitted::OneOf(numbers) => {
            each!(number in numbers => {
                mistake.unless(fits(data_type, *number), "the permitted numbers must fit the type");
            });
        }
        Permitted::Any | Permitted::Named => {}
    }
    each!(place, (number, _) in parameter.meanings => {
        mistake.unless(fits(data_type, *number), "the named numbers must fit the type");
        each!((other, _) in parameter.meanings.split_at(place).0 => {
            mistake.unless(*other != *number, "a number has two names");
        });
    });
    mistake.unless(
        data_type.is_wide() || permits(parameter, parameter.factory),
        NOT_PERMITTED,
    );
}

const fn fits(data_type: DataType, number: u32) -> bool {
    data_type.size() >= 4 || number >> (8 * data_type.size()) == 0
}

pub(crate) const fn permits(parameter: &Parameter, value: u32) -> bool {
    if matches!(parameter.data_type, DataType::Real32) && super::is_nan(value) {
        return false;
    }
    let value = match parameter.permitted {
        Permitted::Any => return true,
        Permitted::Ranges(ranges) => return ranges.contain(value),
        _ => ordered(parameter.data_type, value),
    };
    let mut range = 0;
    while range < count(parameter) {
        let (low, high) = limits(parameter, range);
        if low <= value && value <= high {
            return true;
        }
        range += 1;
    }
    false
}

/// The factory values must fulfil the constraints.
#[track_caller]
const fn check_constraints(parameters: &[Parameter], constraints: &[Constraint]) {
    each!(place, constraint in constraints => {
        let mistake = Mistake::row("constraint", place).at(constraint.origin);
        let fulfilled = match constraint.relation {
            Relation::Different(one, other) => {
                constrained(mistake, parameters, one).factory
                    != constrained(mistake, parameters, other).factory
            }
            Relation::AtMost {
                parameter,
                high,
                other,
                number,
            } => {
                let parameter = constrained(mistake, parameters, parameter);
                let other = constrained(mistake, parameters, other);
                mistake.unless(
                    !parameter.data_type.is_signed() && !other.data_type.is_signed(),
                    "both parameters are unsigned",
                );
                other.factory != number as u32 || parameter.factory <= high as u32
            }
        };
        mistake.unless(fulfilled, "the factory values must fulfil the constraints");
    });
}

/// A parameter of a constraint.
#[track_caller]
const fn constrained<'a>(
    mistake: Mistake,
    parameters: &'a [Parameter],
    id: ParameterId,
) -> &'a Parameter {
    exists(mistake, parameters, id);
    let parameter = at(parameters, id.0 as usize);
    mistake.unless(
        !parameter.data_type.is_wide(),
        "a parameter of 64 bits has no constraints",
    );
    parameter
}

/// Checks that a row names a parameter of the table.
#[track_caller]
pub(crate) const fn exists(mistake: Mistake, parameters: &[Parameter], id: ParameterId) {
    if id.0 as usize >= parameters.len() {
        mistake
            .text("the table has no parameter ")
            .number(id.0 as u32)
            .fail();
    }
}

/// Checks that a row names a quantity of the application.
#[track_caller]
pub(crate) const fn has_quantity(mistake: Mistake, quantities: &[Quantity], id: ValueId) {
    if id.0 as usize >= quantities.len() {
        mistake
            .text("the application has no quantity ")
            .number(id.0 as u32)
            .fail();
    }
}

/// The highest number that a parameter with an unsigned type permits.
pub(crate) const fn highest(parameter: &Parameter) -> u32 {
    let mut range = 0;
    let mut highest = 0;
    while range < count(parameter) {
        let (_, high) = limits(parameter, range);
        highest = if high > highest { high } else { highest };
        range += 1;
    }
    match parameter.permitted {
        Permitted::Any => parameter.data_type.range().1 as u32,
        Permitted::Ranges(ranges) if ranges.ignored_bits > 0 => u32::MAX,
        _ => highest,
    }
}

/// Checks that the id of each quantity is its index, and that the published values have room for all of them.
#[track_caller]
pub(crate) const fn check_quantities(quantities: &[Quantity], capacity: usize) {
    each!(place, quantity in quantities => {
        let mistake = Mistake::row("quantity", place).at(quantity.origin);
        mistake.unless(
            quantity.id.0 as usize == place,
            "the id of a quantity must be its index",
        );
        mistake.unless(quantity.data_type.size() > 0, "a quantity must be a number");
        mistake.unless(quantity.decimals < 10, TOO_FINE);
        mistake.unless(
            quantity.range.0 <= quantity.range.1,
            "the lowest number is above the highest one",
        );
        let (least, most) = quantity.data_type.range();
        mistake.unless(
            least <= quantity.range.0 && quantity.range.1 <= most,
            "the range must fit the type",
        );
        mistake.unless(
            place < capacity,
            "the application publishes fewer values: `Values` has no room for it",
        );
    });
}

#[cfg(test)]
mod tests;
