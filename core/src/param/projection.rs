//! Projection of the parameter descriptions of a product into the form that the device uses.
//!
//! All functions are evaluated at compile time. An inconsistent description is a compile error.
#![allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only

use super::row::{Limits, ParameterRow, ordered};
use super::{Constraint, DataType, Parameter, ParameterSet, Permitted, Persistence};
use crate::mistake::Mistake;

/// The maximum number of parameters of a product.
pub const PARAMETERS_MAX: usize = ParameterSet::CAPACITY;

/// The factory value of each parameter.
#[track_caller]
pub const fn factory<const N: usize>(parameters: &[Parameter]) -> [u32; N] {
    Mistake::in_item("PARAMETERS").unless(
        parameters.len() == N && N <= PARAMETERS_MAX,
        "a product has at most 128 parameters",
    );
    let mut values = [0; N];
    let mut row = 0;
    while row < N {
        values[row] = parameters[row].factory;
        row += 1;
    }
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
    assert!(parameters.len() == N, "one row for each parameter");
    let empty = ParameterRow::new(DataType::U8, Persistence::Volatile, 0, (0, 0));
    let mut rows = [empty; N];
    let places = places(parameters);
    let mut row = 0;
    while row < N {
        let parameter = &parameters[row];
        Mistake::in_parameter(row, parameter.name).unless(
            parameter.id.0 as usize == row,
            "the id of a parameter must be its index",
        );
        check(parameter);
        if parameter.data_type.is_wide() {
            Mistake::in_parameter(row, parameter.name).unless(
                row + 1 < N && is_upper(parameter, &parameters[row + 1]),
                "a parameter of 64 bits has two rows: `Parameter::wide`",
            );
        }
        let ignored_bits = match parameter.permitted {
            Permitted::Ranges(ranges) => ranges.ignored_bits,
            _ => 0,
        };
        rows[row] = ParameterRow::new(
            parameter.data_type,
            parameter.persistence,
            ignored_bits,
            (places[row], count(parameter)),
        );
        row += 1;
    }
    check_constraints(parameters, constraints);
    rows
}

/// Whether a parameter is a real number of 32 bits.
pub const fn has_reals(parameters: &[Parameter]) -> bool {
    let mut row = 0;
    while row < parameters.len() {
        if let DataType::Real32 = parameters[row].data_type {
            return true;
        }
        row += 1;
    }
    false
}

/// The number of ranges in the pool.
pub const fn pool_size(parameters: &[Parameter]) -> usize {
    places(parameters)[parameters.len()]
}

/// The pool of permitted ranges of the rows. Parameters with the same ranges share them.
pub const fn pool<const N: usize>(parameters: &[Parameter]) -> [Limits; N] {
    let mut pool = [(0, 0); N];
    let places = places(parameters);
    let mut row = 0;
    while row < parameters.len() {
        let first = places[row];
        let mut range = 0;
        while range < count(&parameters[row]) {
            pool[first + range] = limits(&parameters[row], range);
            range += 1;
        }
        row += 1;
    }
    pool
}

/// The size in bytes of the stored parameters.
pub const fn stored_size(parameters: &[Parameter]) -> usize {
    let mut size = 0;
    let mut row = 0;
    while row < parameters.len() {
        if parameters[row].persistence as u8 != Persistence::Volatile as u8 {
            // A row of a parameter of 64 bits has 32.
            let own = parameters[row].data_type.size() as usize;
            size += if own > 4 { 4 } else { own };
        }
        row += 1;
    }
    size
}

/// Whether the named numbers are consecutive, so that they are one range.
const fn is_sequence(parameter: &Parameter) -> bool {
    let names = parameter.meanings;
    let mut row = 1;
    while row < names.len() {
        if names[row].0 != names[row - 1].0 + 1 {
            return false;
        }
        row += 1;
    }
    !names.is_empty()
}

/// The number of permitted ranges of a parameter; 0: all numbers are permitted.
const fn count(parameter: &Parameter) -> usize {
    match parameter.permitted {
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
            (names[0].0, names[names.len() - 1].0)
        }
        Permitted::Named => (parameter.meanings[range].0, parameter.meanings[range].0),
        Permitted::OneOf(numbers) => (numbers[range], numbers[range]),
        Permitted::Ranges(ranges) => ranges.ranges[range],
    };
    (
        ordered(parameter.data_type, low),
        ordered(parameter.data_type, high),
    )
}

/// The index of the first range of each row in the pool: that of an earlier row with the same ranges, or the next free one. After the
/// last row: the size of the pool.
const fn places(parameters: &[Parameter]) -> [usize; PARAMETERS_MAX + 1] {
    let mut places = [0; PARAMETERS_MAX + 1];
    let (mut row, mut end) = (0, 0);
    while row < parameters.len() {
        let mut alike = 0;
        while !is_alike(&parameters[alike], &parameters[row]) {
            alike += 1;
        }
        places[row] = if alike < row { places[alike] } else { end };
        let after = places[row] + count(&parameters[row]);
        if after > end {
            end = after;
        }
        row += 1;
    }
    places[row] = end;
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
    let mistake = Mistake::in_parameter(parameter.id.0 as usize, parameter.name);
    mistake.unless(data_type.size() > 0, "a parameter must be a number");
    let (least, most) = data_type.range();
    mistake.unless(
        fits(data_type, parameter.factory),
        "the factory value must fit the type",
    );
    mistake.unless(
        !data_type.is_wide() || matches!(parameter.permitted, Permitted::Any),
        "a parameter of 64 bits permits all numbers",
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
        }
        Permitted::Any | Permitted::Named | Permitted::OneOf(_) => {}
    }
    mistake.unless(
        permits(parameter, parameter.factory),
        "the factory value must be permitted",
    );
    let mut row = 0;
    while row < parameter.meanings.len() {
        mistake.unless(
            fits(data_type, parameter.meanings[row].0),
            "the named numbers must fit the type",
        );
        row += 1;
    }
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
    let mut row = 0;
    while row < constraints.len() {
        let (Constraint::Different(one, other)
        | Constraint::AtMost {
            parameter: one,
            other,
            ..
        }) = constraints[row];
        let mistake = Mistake::in_row("constraint", row);
        mistake.unless(
            (one.0 as usize) < parameters.len() && (other.0 as usize) < parameters.len(),
            "the table has no such parameter",
        );
        let fulfilled = match constraints[row] {
            Constraint::Different(one, other) => {
                parameters[one.0 as usize].factory != parameters[other.0 as usize].factory
            }
            Constraint::AtMost {
                parameter,
                high,
                other,
                number,
            } => {
                parameters[other.0 as usize].factory != number as u32
                    || parameters[parameter.0 as usize].factory <= high as u32
            }
        };
        mistake.unless(fulfilled, "the factory values must fulfil the constraints");
        row += 1;
    }
}

#[cfg(test)]
mod tests;
