//! The tests of the parent module.

use super::*;
use crate::devicenet::table::{Attribute, Object};
use crate::param::DataType;

const X: ValueId = ValueId(0);
const PARAMETERS: [Parameter; 1] = [Parameter::new(ParameterId(0), "", DataType::U8)];
const QUANTITIES: [Quantity; 1] = [Quantity::new(X, "", DataType::I16)];

const fn attribute(number: u8, source: Source, settable: bool) -> Attribute {
    Attribute {
        settable,
        ..Attribute::new(number, "", source)
    }
}

const fn object(class: u8, attributes: &'static [Attribute]) -> Object {
    Object::new(class, "", attributes)
}

#[test]
fn attributes_of_two_objects_are_found_in_their_object() {
    const OBJECTS: [Object; 2] = [
        object(
            0x65,
            &[
                attribute(1, Source::Constant(DataType::U16, 7), false),
                attribute(3, Source::Parameter(ParameterId(0)), true),
            ],
        ),
        object(
            0x66,
            &[
                attribute(2, Source::Value(X), false),
                attribute(9, Source::Constant(DataType::U32, 8), false),
            ],
        ),
    ];
    const COUNT: usize = attribute_count(&OBJECTS);
    static ROWS: [AttributeRow; COUNT] = attributes(&OBJECTS, &PARAMETERS, &QUANTITIES);
    let rows = objects::<2>(&OBJECTS);
    let numbers = |place: usize| {
        let has = |number: &u8| rows[place].attribute(&ROWS, *number).is_some();
        (0..=255).filter(has).collect::<std::vec::Vec<u8>>()
    };
    assert_eq!(numbers(0), [1, 3]);
    assert_eq!(numbers(1), [2, 9]);
    assert_eq!(constants::<2>(&OBJECTS), [7, 8]);
    let size = |place: usize, number| rows[place].attribute(&ROWS, number).unwrap().size();
    assert_eq!(
        [size(0, 1), size(0, 3), size(1, 2), size(1, 9)],
        [2, 1, 2, 4]
    );
    let [constant, parameter] = [1, 3].map(|number| rows[0].attribute(&ROWS, number).unwrap());
    assert_eq!(parameter.place(), Place::Parameter(ParameterId(0)));
    assert!(parameter.is_settable() && !constant.is_settable());
}
