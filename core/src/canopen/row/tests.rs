//! The tests of the parent module.

use super::*;
use crate::canopen::dictionary::Access;
use crate::param::Persistence;

const PARAMETERS: [Parameter; 2] = [
    Parameter::new(ParameterId(0), "one", DataType::U16),
    Parameter {
        persistence: Persistence::Volatile,
        ..Parameter::new(ParameterId(1), "other", DataType::U8)
    },
];

#[test]
fn row_has_the_access_and_the_type_of_its_object() {
    let object = |index, access, id| Object {
        access,
        ..Object::parameter(index, 0, ParameterId(id))
    };
    let objects = [object(0x1FFF, Access::Wo, 0), object(0x2000, Access::Ro, 1)];
    let [write_only, read_only] = rows::<2>(&objects, &PARAMETERS, &[]);
    assert!(!write_only.is_readable() && write_only.is_writable());
    assert!(read_only.is_readable() && !read_only.is_writable());
    assert_eq!((write_only.index(), read_only.index()), (0x1FFF, 0x2000));
    assert_eq!((write_only.size(), read_only.size()), (2, 1));
    assert!(write_only.is_communication() && !read_only.is_communication());
    assert!(Access::Wo.is_writable() && Access::Rw.is_writable());
    assert!(!Access::Ro.is_writable() && !Access::Const.is_writable());
}

#[test]
fn server_accepts_writes_of_read_only_mapping() {
    let objects = [
        constant(0x19FF, 0),
        constant(0x1A00, 0),
        constant(0x1A00, 1),
        constant(0x1BFF, 0),
        constant(0x1C00, 0),
    ];
    let rows = rows::<5>(&objects, &[], &[]);
    let accepts = rows.map(|row| row.is_writable());
    assert_eq!(accepts, [false, true, true, true, false]);
    let counts = rows.map(|row| row.is_mapped_count());
    assert_eq!(counts, [false, true, false, true, false]);
}

fn constant(index: u16, sub: u8) -> Object {
    Object {
        index,
        sub,
        ..Object::plain()
    }
}

#[test]
#[should_panic(expected = "rows must be sorted")]
fn unsorted_rows_are_refused() {
    rows::<2>(&[constant(0x2000, 1), constant(0x2000, 0)], &[], &[]);
}

#[test]
#[should_panic(expected = "rows must be sorted")]
fn row_within_the_sub_indices_of_the_row_before_is_refused() {
    let [_, errors] = crate::canopen::profile::error_history(4);
    rows::<2>(&[errors, constant(0x1003, 4)], &[], &[]);
}

#[test]
fn row_after_the_sub_indices_of_the_row_before_is_accepted() {
    let [_, errors] = crate::canopen::profile::error_history(4);
    rows::<2>(&[errors, constant(0x1003, 5)], &[], &[]);
}

#[test]
#[should_panic(expected = "this parameter is in two rows")]
fn parameter_in_two_rows_is_refused() {
    let objects = [0x2000, 0x2001].map(|index| Object::parameter(index, 0, ParameterId(0)));
    rows::<2>(&objects, &PARAMETERS, &[]);
}

#[test]
#[should_panic(expected = "only the error history has several sub-indices in one row")]
fn several_sub_indices_of_a_constant_are_refused() {
    let objects = [Object {
        count: 2,
        ..constant(0x2000, 0)
    }];
    rows::<1>(&objects, &[], &[]);
}

#[test]
#[should_panic(expected = "a constant or a value cannot be written")]
fn writable_constant_is_refused() {
    let objects = [Object {
        access: Access::Rw,
        ..constant(0x2000, 0)
    }];
    rows::<1>(&objects, &[], &[]);
}

#[test]
#[should_panic(expected = "the constant must fit its type")]
fn constant_that_does_not_fit_its_type_is_refused() {
    let objects = [Object {
        target: Target::Constant(256),
        ..constant(0x2000, 0)
    }];
    rows::<1>(&objects, &[], &[]);
}

#[test]
fn missing_object_and_missing_sub_index_have_their_own_abort_codes() {
    static ROWS: [Row; 4] = rows::<4>(
        &[
            Object {
                index: 0x1FFF,
                sub: 3,
                ..Object::plain()
            },
            Object {
                index: 0x2000,
                sub: 1,
                ..Object::plain()
            },
            Object {
                index: 0x2000,
                sub: 3,
                ..Object::plain()
            },
            Object {
                index: 0x2002,
                ..Object::plain()
            },
        ],
        &[],
        &[],
    );
    let find = |index, sub| find(&ROWS, 0, Address { index, sub }).map(Row::index);
    assert_eq!(find(0x2000, 1), Ok(0x2000));
    assert_eq!(find(0x2000, 3), Ok(0x2000));
    assert_eq!(find(0x2002, 0), Ok(0x2002));
    for sub in [0, 2, 4, 255] {
        assert_eq!(find(0x2000, sub), Err(Abort::NoSubIndex), "{sub}");
    }
    for index in [0, 0x1FFE, 0x2001, 0x2003, 0xFFFF] {
        assert_eq!(find(index, 0), Err(Abort::NoObject), "{index:04X}");
    }
    assert_eq!(find(0x1FFF, 0), Err(Abort::NoSubIndex));
}

#[test]
fn constant_of_16_bits_and_history_of_100_entries_behind_others_are_accepted() {
    check(&Object {
        data_type: DataType::U16,
        target: Target::Constant(0x1234),
        ..constant(0x2000, 0)
    });
    check(&Object {
        count: 100,
        target: Target::Service(Service::ErrorHistory),
        ..constant(0x1003, 4)
    });
}
