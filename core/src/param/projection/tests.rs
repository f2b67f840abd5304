//! The checks at compile time, called at run time with one contradiction each.

use super::*;
use crate::param::{ParameterId, Ranges};

const A: ParameterId = ParameterId(0);
const B: ParameterId = ParameterId(1);

const BYTE: Parameter = Parameter::new(A, "byte", DataType::U8);

#[test]
fn consistent_descriptions_are_accepted() {
    check(&BYTE);
    check(&BYTE.within(1, 255, 255));
    check(&Parameter::new(A, "signed", DataType::I8).within(-128, 127, -128));
    check(&Parameter {
        meanings: &[(255, "last")],
        permitted: Permitted::Named,
        factory: 255,
        ..BYTE
    });
    check(&Parameter {
        permitted: Permitted::OneOf(&[3, 7]),
        factory: 7,
        ..BYTE
    });
    check(&RANGES);
}

/// Two ranges whose three highest bits are ignored.
const RANGES: Parameter = Parameter {
    data_type: DataType::U32,
    permitted: Permitted::Ranges(&Ranges {
        text: "",
        ignored_bits: 3,
        ranges: &[(1, 3), (5, 5)],
    }),
    factory: 0xE000_0005,
    ..BYTE
};

#[test]
#[should_panic(expected = "must be a number")]
fn text_is_refused() {
    check(&Parameter::new(A, "text", DataType::Text));
}

#[test]
#[should_panic(expected = "factory value must fit")]
fn factory_value_beyond_the_type_is_refused() {
    check(&Parameter {
        factory: 0x100,
        ..BYTE
    });
}

#[test]
#[should_panic(expected = "the range must fit")]
fn range_below_the_type_is_refused() {
    check(&BYTE.within(-1, 255, 0));
}

#[test]
#[should_panic(expected = "the range must fit")]
fn range_above_the_type_is_refused() {
    check(&BYTE.within(0, 256, 0));
}

#[test]
#[should_panic(expected = "the range must fit")]
fn empty_range_is_refused() {
    check(&BYTE.within(5, 4, 5));
}

#[test]
#[should_panic(expected = "must be permitted")]
fn factory_value_below_the_range_is_refused() {
    check(&BYTE.within(2, 9, 1));
}

#[test]
#[should_panic(expected = "must be permitted")]
fn factory_value_above_the_range_is_refused() {
    check(&BYTE.within(2, 9, 10));
}

#[test]
#[should_panic(expected = "must be permitted")]
fn factory_value_without_name_is_refused() {
    check(&Parameter {
        meanings: &[(1, "one")],
        permitted: Permitted::Named,
        ..BYTE
    });
}

#[test]
#[should_panic(expected = "must be permitted")]
fn factory_value_between_ranges_is_refused() {
    check(&Parameter {
        factory: 4,
        ..RANGES
    });
}

#[test]
#[should_panic(expected = "named numbers must fit")]
fn named_number_beyond_the_type_is_refused() {
    check(&Parameter {
        meanings: &[(0, "zero"), (0x100, "too large")],
        ..BYTE
    });
}

/// Two bytes with these factory values.
fn bytes(a: i32, b: i32) -> [Parameter; 2] {
    [
        BYTE.within(0, 255, a),
        Parameter { id: B, ..BYTE }.within(0, 255, b),
    ]
}

const DIFFERENT: &[Constraint] = &[Constraint::different(A, B)];
const AT_MOST: &[Constraint] = &[Constraint::new(Relation::AtMost {
    parameter: A,
    high: 8,
    other: B,
    number: 2,
})];

#[test]
fn factory_values_that_fulfil_the_constraints_are_accepted() {
    check_constraints(&bytes(1, 2), DIFFERENT);
    check_constraints(&bytes(8, 2), AT_MOST);
    check_constraints(&bytes(9, 1), AT_MOST);
}

#[test]
#[should_panic(expected = "fulfil the constraints")]
fn equal_factory_values_are_refused() {
    check_constraints(&bytes(1, 1), DIFFERENT);
}

#[test]
#[should_panic(expected = "fulfil the constraints")]
fn factory_value_above_the_limit_of_a_constraint_is_refused() {
    check_constraints(&bytes(9, 2), AT_MOST);
}

#[test]
#[should_panic(expected = "must be its index")]
fn id_that_is_not_the_index_is_refused() {
    let [a, b] = bytes(0, 0);
    rows::<2>(&[b, a], &[]);
}

#[test]
#[should_panic(expected = "at most 128 parameters")]
fn number_of_factory_values_that_is_not_that_of_the_parameters_is_refused() {
    factory::<2>(&[BYTE]);
}

#[test]
fn parameters_with_equal_ranges_share_them() {
    let second = |low, high| Parameter {
        id: B,
        ..BYTE.within(low, high, 50)
    };
    let first = BYTE.within(1, 100, 50);
    for (other, size) in [
        (second(1, 100), 1),
        (second(1, 50), 2),
        (second(2, 100), 2),
        (second(2, 50), 2),
    ] {
        assert_eq!(pool_size(&[first, other]), size, "{other:?}");
    }
}
