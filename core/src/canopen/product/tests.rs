//! The checks at compile time, called at run time with tables that contain one contradiction each.

use super::*;
use crate::canopen::pdo::TpdoArray;
use crate::canopen::profile::{constant, entry, highest, mapping, read_only, text, tpdo};
use crate::param::{DataType, ParameterId, ValueId};
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
    check_rows(&objects, 4, NAME, &parameters);
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
#[should_panic = "a mapped object does not exist"]
fn mapping_of_missing_index_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6012, 0, 16)));
}

#[test]
#[should_panic = "a mapped object does not exist"]
fn mapping_of_missing_sub_index_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6010, 1, 16)));
}

#[test]
#[should_panic = "a mapped object cannot be mapped"]
fn mapping_of_object_that_is_not_mappable_is_refused() {
    check_with::<TpdoArray<1, 2>>(|objects| map(objects, entry(0x6011, 0, 16)));
}

#[test]
#[should_panic = "a mapped object has another length"]
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
#[should_panic = "a text is longer than its buffer"]
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
    check_rows(&objects(), 4, NAME - 1, &parameters(0x180, 0x80));
}

#[test]
#[should_panic = "more than 255 bytes"]
fn buffer_of_more_than_255_bytes_is_refused() {
    check_rows(&objects(), 4, 256, &parameters(0x180, 0x80));
}

#[test]
fn buffer_of_255_bytes_is_accepted() {
    check_rows(&objects(), 4, 255, &parameters(0x180, 0x80));
}

#[test]
#[should_panic = "the capacity of the error history"]
fn history_with_other_capacity_is_refused() {
    check_rows(&objects(), 5, NAME, &parameters(0x180, 0x80));
}

#[test]
#[should_panic = "the default COB-ID of the SYNC is not free"]
fn restricted_cob_id_of_sync_is_refused() {
    check_rows(&objects(), 4, NAME, &parameters(0x180, 0x101));
}

#[test]
#[should_panic = "the default COB-ID is not free"]
fn cob_id_that_is_not_free_for_node_1_is_refused() {
    check_rows(&objects(), 4, NAME, &parameters(0x17F, 0x80));
}

#[test]
#[should_panic = "the default COB-ID is not free"]
fn cob_id_that_is_not_free_for_node_127_is_refused() {
    check_rows(&objects(), 4, NAME, &parameters(0x502, 0x80));
}

#[test]
fn cob_id_that_is_free_for_all_nodes_is_accepted() {
    check_rows(&objects(), 4, NAME, &parameters(0x501, 0x80));
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
    check_lss(&objects, &parameters, ParameterId(0));
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
