//! The checks at compile time, called at run time with tables that contain one contradiction each.

use super::pdo::check_tpdos;
use super::*;
use crate::can::BitRate;
use crate::canopen::pdo::TpdoArray;
use crate::canopen::profile::{self, constant, entry, highest, mapping, read_only, text, tpdo};
use crate::param::Permitted;
use crate::param::ValueId;
use std::vec::Vec;

/// The first parameter of the communication parameter.
const TPDO: ParameterId = ParameterId(0);
/// The COB-ID of the SYNC.
const SYNC: ParameterId = ParameterId(4);

/// The parameters of a product with one TPDO and these factory values of its COB-ID and of the COB-ID of the SYNC.
fn parameters(cob_id: u32, sync: u32) -> Vec<Parameter> {
    let mut parameters = profile::tpdo_communication(TPDO, cob_id).to_vec();
    parameters.push(Parameter {
        factory: sync,
        ..profile::sync_cob_id(SYNC)
    });
    parameters
}

/// A slope of 16 and one of 32 bits.
const QUANTITIES: [Quantity; 2] = [
    Quantity::new(ValueId(0), "slope", DataType::I16),
    Quantity::new(ValueId(1), "fine slope", DataType::I32),
];

/// The dictionary of a product with one TPDO that maps both slopes and a byte.
fn objects() -> Vec<Object> {
    let mut objects = vec![Object::parameter(0x1005, 0, SYNC)];
    objects.extend(profile::error_history(4));
    objects.push(text(0x1008, "name", "IS2"));
    objects.extend(tpdo(0, "TPDO", TPDO));
    let entries = [
        ("slope", entry(0x6010, 0, 16)),
        ("fine slope", entry(0x6110, 0, 32)),
    ];
    objects.extend(mapping::<3>(0, "mapping", &entries));
    objects.push(Object::value(0x6010, 0, ValueId(0)));
    objects.push(read_only(0x6011, 0, ValueId(0)));
    objects.push(Object::value(0x6110, 0, ValueId(1)));
    objects
}

/// Checks the dictionary after a change.
fn check_with<T: Tpdos>(change: impl FnOnce(&mut Vec<Object>)) {
    let mut objects = objects();
    change(&mut objects);
    let parameters = parameters(0x180, 0x80);
    check_tpdos::<T>(&objects, &parameters, &QUANTITIES);
    check_texts(&objects, NAME);
    check_history(&objects, 4);
    identifiers::check(&objects, &parameters);
}

/// Changes the object at an address.
fn change(objects: &mut [Object], index: u16, sub: u8, change: impl FnOnce(&mut Object)) {
    let place = objects
        .iter_mut()
        .find(|object| (object.index, object.sub) == (index, sub));
    change(place.expect("the object"));
}

/// Changes the first mapping entry.
fn map(objects: &mut [Object], entry: u32) {
    change(objects, 0x1A00, 1, |object| {
        object.target = Target::Constant(entry)
    });
}

#[test]
fn consistent_tables_are_accepted() {
    check_with::<TpdoArray<1, 2>>(|_| {});
    check_with::<TpdoArray<1, 4>>(|_| {});
    // 64 bits are full.
    check_with::<TpdoArray<1, 3>>(|objects| {
        let place = objects.iter().position(|object| object.index == 0x6010);
        let third = constant(0x1A00, 3, "slope", DataType::U32, entry(0x6010, 0, 16));
        objects.insert(place.expect("the slope"), third);
    });
}

#[test]
#[should_panic = "the number of TPDOs is not that of the dictionary"]
fn tpdo_without_objects_is_refused() {
    check_with::<TpdoArray<2, 2>>(|_| {});
}

#[test]
#[should_panic = "the number of TPDOs is not that of the dictionary"]
fn objects_without_tpdo_are_refused() {
    check_with::<TpdoArray<0, 2>>(|_| {});
}

#[test]
#[should_panic = "the number of TPDOs is not that of the dictionary"]
fn last_possible_tpdo_is_checked() {
    check_with::<TpdoArray<1, 2>>(|objects| {
        let place = objects.iter().position(|object| object.index == 0x1A00);
        objects.insert(
            place.expect("the mapping"),
            Object::parameter(0x19FF, 1, TPDO),
        );
    });
}

#[test]
#[should_panic = "the number of TPDOs is not that of the dictionary"]
fn tpdo_without_mapping_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| objects.retain(|object| object.index != 0x1A00));
}

#[test]
#[should_panic = "a mapping entry must be a constant"]
fn mapping_entry_that_is_a_parameter_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| {
        change(objects, 0x1A00, 1, |object| {
            object.target = Target::Parameter(SYNC)
        });
    });
}

#[test]
#[should_panic = "does not exist"]
fn mapping_of_missing_index_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6012, 0, 16)));
}

#[test]
#[should_panic = "does not exist"]
fn mapping_of_missing_sub_index_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6010, 1, 16)));
}

#[test]
#[should_panic = "cannot be mapped"]
fn mapping_of_object_that_is_not_mappable_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6011, 0, 16)));
}

#[test]
#[should_panic = "has another length"]
fn mapping_with_wrong_length_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6010, 0, 8)));
}

#[test]
#[should_panic = "the mapped objects do not fit into a frame"]
fn mapping_of_more_than_64_bits_is_refused() {
    check_with::<TpdoArray<1, 3>>(|objects| {
        let place = objects.iter().position(|object| object.index == 0x6010);
        let third = constant(0x1A00, 3, "slope", DataType::U32, entry(0x6110, 0, 32));
        objects.insert(place.expect("the slope"), third);
    });
}

#[test]
#[should_panic = "more objects are mapped than the TPDO takes"]
fn mapping_of_more_objects_than_the_tpdo_takes_is_refused() {
    check_with::<TpdoArray<1, 1>>(|_| {});
}

#[test]
#[should_panic = "the text is longer than its buffer"]
fn text_longer_than_buffer_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| {
        change(objects, 0x1008, 0, |object| {
            object.target = Target::Text("a text with thirty-three characters")
        });
    });
}

#[test]
#[should_panic = "the name of a unit is longer than the buffer"]
fn buffer_shorter_than_the_name_of_a_unit_is_refused() {
    check_texts(&objects(), NAME - 1);
}

#[test]
#[should_panic = "more than 255 bytes"]
fn buffer_of_more_than_255_bytes_is_refused() {
    check_texts(&objects(), 256);
}

#[test]
fn buffer_of_255_bytes_is_accepted() {
    check_texts(&objects(), 255);
}

#[test]
#[should_panic = "the capacity of the error history is"]
fn history_with_other_capacity_is_refused() {
    check_history(&objects(), 5);
}

#[test]
#[should_panic = "the default COB-ID of the SYNC is not free"]
fn restricted_cob_id_of_sync_is_refused() {
    identifiers::check(&objects(), &parameters(0x180, 0x101));
}

#[test]
#[should_panic = "the default COB-ID is not free"]
fn cob_id_that_is_not_free_for_node_1_is_refused() {
    identifiers::check(&objects(), &parameters(0x100, 0x80));
}

#[test]
#[should_panic = "the default COB-ID is not free"]
fn cob_id_that_is_not_free_for_node_96_is_refused() {
    identifiers::check(&objects(), &parameters(0x680, 0x80));
}

#[test]
fn cob_id_that_is_free_for_all_nodes_is_accepted() {
    identifiers::check(&objects(), &parameters(0x500, 0x80));
}

#[test]
fn highest_sub_index_is_constant() {
    let row = highest(0x1018, "Identity object", DataType::U8, 4);
    assert_eq!(row.target, Target::Constant(4));
}

/// Checks a product with LSS, after a change of its dictionary.
fn check_lss_with(permitted: Permitted, change: impl FnOnce(&mut Vec<Object>)) {
    let mut objects = profile::identity(1, 2, 3).to_vec();
    change(&mut objects);
    let parameters = [Parameter {
        permitted,
        ..profile::lss_node_id(ParameterId(0), 50)
    }];
    check_lss(&objects);
    identifiers::check_node_id(&parameters, ParameterId(0), true);
}

#[test]
fn identity_and_node_id_255_are_accepted_with_lss() {
    let node_id = profile::lss_node_id(ParameterId(0), 50);
    check_lss_with(node_id.permitted, |_| {});
}

#[test]
#[should_panic = "needs all numbers of the identity object"]
fn lss_without_serial_number_is_refused() {
    let node_id = profile::lss_node_id(ParameterId(0), 50);
    check_lss_with(node_id.permitted, |objects| {
        objects.pop();
    });
}

#[test]
#[should_panic = "permits the node-ID 255"]
fn lss_without_node_id_255_is_refused() {
    check_lss_with(Permitted::Range(1, 255), |_| {});
}

#[test]
#[should_panic = "quantity 1: the application publishes fewer values"]
fn more_quantities_than_published_values_are_refused() {
    check_quantities(&QUANTITIES, 1);
}

#[test]
#[should_panic = "quantity 0: the id of a quantity must be its index"]
fn quantity_with_index_different_from_its_id_is_refused() {
    let [_, other] = QUANTITIES;
    check_quantities(&[other], 2);
}

#[test]
#[should_panic = "object 2100h:02: the table has no parameter 5"]
fn object_of_missing_parameter_is_refused() {
    let objects = [Object::parameter(0x2100, 2, ParameterId(5))];
    check_references(&objects, &parameters(0x180, 0x80), &QUANTITIES);
}

#[test]
#[should_panic = "object 6010h:00: the application has no quantity 2"]
fn object_of_missing_quantity_is_refused() {
    check_references(&[Object::value(0x6010, 0, ValueId(2))], &[], &QUANTITIES);
}

#[test]
fn each_mandatory_object_is_required() {
    let objects = [
        &[profile::device_type(1), profile::error_register()][..],
        &profile::identity(1, 2, 3)[..2],
    ]
    .concat();
    check_profile(&objects, &[], &[]);
    for missing in 0..objects.len() {
        let mut objects = objects.clone();
        let Object { index, sub, .. } = objects.remove(missing);
        let checked = std::panic::catch_unwind(|| check_profile(&objects, &[], &[]));
        let message = checked.unwrap_err();
        let message = message.downcast_ref::<std::string::String>().unwrap();
        let expected =
            std::format!("object {index:04X}h:{sub:02X}: this object is mandatory in CiA 301");
        // Another sub-index of the same object has a line.
        assert!(message.ends_with(&expected), "{message}");
    }
}

#[test]
#[should_panic = "object 1017h:00: CiA 301 defines another data type for this object"]
fn object_of_the_profile_with_another_type_is_refused() {
    let objects = [
        &[profile::device_type(1), profile::error_register()][..],
        &[constant(0x1017, 0, "heartbeat", DataType::U8, 0)],
        &profile::identity(1, 2, 3),
    ]
    .concat();
    check_profile(&objects, &[], &[]);
}

#[test]
#[should_panic = "object 1018h:00: the highest sub-index is 2, not 3"]
fn sub_index_0_with_wrong_highest_sub_index_is_refused() {
    check_highest(&[
        highest(0x1018, "record", DataType::U8, 3),
        constant(0x1018, 1, "one", DataType::U32, 0),
        constant(0x1018, 2, "other", DataType::U32, 0),
    ]);
}

#[test]
#[should_panic = "NODE_ID: the table has no parameter 9"]
fn node_id_beyond_the_table_is_refused() {
    identifiers::check_node_id(&parameters(0x180, 0x80), ParameterId(9), false);
}

#[test]
#[should_panic = "parameter 4 \"COB-ID SYNC message\": the factory value is not a node-ID"]
fn parameter_without_a_node_id_is_refused() {
    identifiers::check_node_id(&parameters(0x180, 0x80), SYNC, false);
}

/// Checks the bit rates of a product with this parameter.
fn check_bit_rate_with(permitted: Permitted) {
    let parameter = Parameter {
        permitted,
        ..profile::bit_rate(ParameterId(0), 125)
    };
    let codes = &[(125, BitRate::K125), (250, BitRate::K250)];
    identifiers::check_bit_rate(&[parameter], ParameterId(0), codes);
}

#[test]
fn permitted_numbers_with_a_bit_rate_are_accepted() {
    check_bit_rate_with(Permitted::OneOf(&[125, 250]));
    check_bit_rate_with(Permitted::OneOf(&[125]));
    check_bit_rate_with(Permitted::Range(125, 125));
}

#[test]
#[should_panic = "parameter 0 \"Bit rate\": BIT_RATES has no bit rate for the permitted number 500"]
fn permitted_number_without_a_bit_rate_is_refused() {
    check_bit_rate_with(Permitted::OneOf(&[125, 500]));
}

#[test]
#[should_panic = "BIT_RATES has no bit rate for the permitted number 126"]
fn range_with_a_number_without_a_bit_rate_is_refused() {
    check_bit_rate_with(Permitted::Range(125, 126));
}

#[test]
#[should_panic = "permits numbers without a bit rate"]
fn bit_rate_that_permits_all_numbers_is_refused() {
    check_bit_rate_with(Permitted::Any);
}
