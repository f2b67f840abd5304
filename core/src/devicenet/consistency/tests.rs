//! Tests of the checks of a description, and of the projected rows.

use super::*;
use crate::can::BitRate;
use crate::devicenet::projection::Place;
use crate::devicenet::projection::{assemblies, attribute_count, attributes, constants, objects};
use crate::devicenet::table::{Attribute, Object, Source};
use crate::param::{Permitted, Quantity, ValueId};

const IDENTITY: Identity = Identity {
    vendor: 1,
    vendor_name: "",
    device_type: 0,
    device_type_name: "",
    product_code: 1,
    revision: (1, 1),
    name: "level",
    catalog: "",
};

const ROLES: Roles = Roles {
    mac_id: ParameterId(0),
    baud_rate: ParameterId(1),
    bit_rates: &[BitRate::K125, BitRate::K250],
    bus_off_interrupt: ParameterId(2),
    polled_assembly: ParameterId(3),
    cyclic_assembly: ParameterId(3),
    cos_delta: ParameterId(4),
};

const fn byte(id: u8, low: i64, high: i64) -> Parameter {
    Parameter {
        persistence: Persistence::AtOnce,
        ..Parameter::new(ParameterId(id), "", DataType::U8).within(low, high, low as i32)
    }
}

const PARAMETERS: [Parameter; 5] = [
    byte(0, 0, 63),
    byte(1, 0, 1),
    byte(2, 0, 1),
    byte(3, 101, 102),
    byte(4, 0, 255),
];

const X: ValueId = ValueId(0);
const QUANTITIES: [Quantity; 2] = [
    Quantity::new(X, "", DataType::I16),
    Quantity::new(ValueId(1), "", DataType::I32),
];

const fn assembly(instance: u8, words: &'static [ValueId]) -> Assembly {
    Assembly {
        instance,
        name: "",
        words,
    }
}

const ASSEMBLIES: [Assembly; 2] = [assembly(101, &[X]), assembly(102, &[X, X, X, X])];

const fn attribute(number: u8, source: Source, settable: bool) -> Attribute {
    Attribute {
        number,
        name: "",
        help: "",
        source,
        settable,
    }
}

const fn object(class: u8, attributes: &'static [Attribute]) -> Object {
    Object {
        class,
        name: "",
        revision: 1,
        attributes,
    }
}

fn check_parameter(changed: Parameter) {
    let mut parameters = PARAMETERS;
    parameters[usize::from(changed.id.0)] = changed;
    check(&IDENTITY, &ROLES, &ASSEMBLIES, &parameters);
}

#[test]
fn consistent_description_is_accepted() {
    check(&IDENTITY, &ROLES, &ASSEMBLIES, &PARAMETERS);
}

#[test]
#[should_panic(expected = "5 to 32 characters")]
fn product_name_for_a_single_fragment_is_refused() {
    let identity = Identity {
        name: "tilt",
        ..IDENTITY
    };
    check(&identity, &ROLES, &ASSEMBLIES, &PARAMETERS);
}

#[test]
#[should_panic(expected = "5 to 32 characters")]
fn longer_product_name_is_refused() {
    let name = "0123456789 0123456789 0123456789 ";
    check(
        &Identity { name, ..IDENTITY },
        &ROLES,
        &ASSEMBLIES,
        &PARAMETERS,
    );
}

#[test]
#[should_panic(expected = "the revision")]
fn minor_revision_0_is_refused() {
    let revision = (1, 0);
    let identity = Identity {
        revision,
        ..IDENTITY
    };
    check(&identity, &ROLES, &ASSEMBLIES, &PARAMETERS);
}

#[test]
#[should_panic(expected = "a number without meaning")]
fn mac_id_64_is_refused() {
    check_parameter(byte(0, 0, 64));
}

#[test]
#[should_panic(expected = "does not permit its highest number")]
fn bit_rate_without_code_is_refused() {
    check_parameter(byte(1, 0, 0));
}

#[test]
#[should_panic(expected = "exactly the instances")]
fn instance_without_assembly_is_refused() {
    check_parameter(byte(3, 101, 103));
}

#[test]
#[should_panic(expected = "is a byte")]
fn word_as_mac_id_is_refused() {
    check_parameter(Parameter {
        data_type: DataType::U16,
        ..byte(0, 0, 63)
    });
}

#[test]
#[should_panic(expected = "stored when it is written")]
fn parameter_stored_on_save_is_refused() {
    check_parameter(Parameter {
        persistence: Persistence::OnSave,
        permitted: Permitted::Any,
        ..byte(4, 0, 255)
    });
}

#[test]
#[should_panic(expected = "have 16 bits")]
fn long_word_in_an_assembly_is_refused() {
    assemblies::<1>(&[assembly(1, &[ValueId(1)])], &QUANTITIES);
}

#[test]
#[should_panic(expected = "one to four words")]
fn assembly_longer_than_a_frame_is_refused() {
    assemblies::<1>(&[assembly(1, &[X, X, X, X, X])], &QUANTITIES);
}

#[test]
#[should_panic(expected = "same instance")]
fn two_assemblies_with_one_instance_are_refused() {
    assemblies::<2>(&[assembly(1, &[X]), assembly(1, &[X])], &QUANTITIES);
}

#[test]
#[should_panic(expected = "class of a vendor")]
fn class_outside_those_of_vendors_is_refused() {
    objects::<1>(&[object(5, &[])]);
}

#[test]
#[should_panic(expected = "sorted by number")]
fn unsorted_attributes_are_refused() {
    const UNSORTED: Object = object(
        0x65,
        &[
            attribute(2, Source::Value(X), false),
            attribute(1, Source::Value(X), false),
        ],
    );
    attributes::<2>(&[UNSORTED], &PARAMETERS, &QUANTITIES);
}

#[test]
#[should_panic(expected = "only a parameter or an own attribute is settable")]
fn settable_value_is_refused() {
    const SETTABLE: Object = object(0x65, &[attribute(1, Source::Value(X), true)]);
    attributes::<1>(&[SETTABLE], &PARAMETERS, &QUANTITIES);
}

#[test]
#[should_panic(expected = "does not fit its type")]
fn constant_above_its_type_is_refused() {
    const TOO_LARGE: Object = object(
        0x65,
        &[attribute(1, Source::Constant(DataType::U8, 256), false)],
    );
    constants::<1>(&[TOO_LARGE]);
}

#[test]
fn attributes_of_two_objects_are_found_in_their_object() {
    const OBJECTS: [Object; 2] = [
        object(
            0x65,
            &[
                attribute(1, Source::Constant(DataType::U16, 7), false),
                attribute(3, Source::Parameter(ParameterId(2)), true),
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
    static ROWS: [crate::devicenet::projection::AttributeRow; COUNT] =
        attributes(&OBJECTS, &PARAMETERS, &QUANTITIES);
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
    assert_eq!(parameter.place(), Place::Parameter(ParameterId(2)));
    assert!(parameter.is_settable() && !constant.is_settable());
}
