//! The rows of the profile as CiA 301 prints them.

use super::*;
use std::vec::Vec;

const ID: ParameterId = ParameterId(7);

/// Name, type, unit, factory value and persistence of a parameter.
fn printed(parameter: &Parameter) -> (&str, DataType, &str, u32, Persistence) {
    (
        parameter.name,
        parameter.data_type,
        parameter.unit,
        parameter.factory,
        parameter.persistence,
    )
}

#[test]
fn parameters_have_types_units_and_factory_values_of_cia_301() {
    use DataType::{U8, U16, U32};
    use Persistence::{OnSave, Volatile};
    let expected = [
        (node_id(ID, 10), ("Node-ID", U8, "", 10, OnSave)),
        (bit_rate(ID, 125), ("Bit rate", U16, "kbit/s", 125, OnSave)),
        (
            sync_cob_id(ID),
            ("COB-ID SYNC message", U32, "", 0x80, OnSave),
        ),
        (guard_time(ID), ("Guard time", U16, "ms", 0, OnSave)),
        (
            life_time_factor(ID),
            ("Life time factor", U8, "", 0, OnSave),
        ),
        (emcy_cob_id(ID), ("COB-ID EMCY", U32, "", 0x80, Volatile)),
        (
            emcy_inhibit_time(ID),
            ("Inhibit time EMCY", U16, "100 us", 0, OnSave),
        ),
        (
            heartbeat_time(ID),
            ("Producer heartbeat time", U16, "ms", 0, OnSave),
        ),
        (error_behaviour(ID), ("Error behaviour", U8, "", 0, OnSave)),
        (nmt_start_up(ID), ("NMT start-up", U32, "", 0, OnSave)),
    ];
    for (parameter, row) in expected {
        assert_eq!((parameter.id, printed(&parameter)), (ID, row));
    }
    let tpdo = tpdo_communication(ID, 0x280);
    let expected = [
        (7, ("COB-ID", U32, "", 0x280, Volatile)),
        (8, ("Transmission type", U8, "", 1, OnSave)),
        (9, ("Inhibit time", U16, "100 us", 0, OnSave)),
        (10, ("Event timer", U16, "ms", 10, OnSave)),
    ];
    for (parameter, (id, row)) in tpdo.iter().zip(expected) {
        assert_eq!((parameter.id, printed(parameter)), (ParameterId(id), row));
    }
}

/// Which of these values are permitted.
fn permits(parameter: &Parameter, values: &[u32]) -> Vec<bool> {
    let permitted = |value: u32| match parameter.permitted {
        Permitted::Any => true,
        Permitted::Range(low, high) => (low..=high).contains(&value.into()),
        Permitted::Named => parameter
            .meanings
            .iter()
            .any(|&(number, _)| number == value),
        Permitted::OneOf(values) => values.contains(&value),
        Permitted::Ranges(ranges) => ranges.contain(value),
    };
    values.iter().map(|&value| permitted(value)).collect()
}

#[test]
fn parameters_permit_values_of_cia_301() {
    let node_id = node_id(ID, 10);
    assert_eq!(
        permits(&node_id, &[0, 1, 127, 128]),
        [false, true, true, false]
    );
    assert_eq!(
        permits(&bit_rate(ID, 125), &[0, 10, 100, 125, 800, 1000, 1001]),
        [false, true, false, true, true, true, false]
    );
    assert_eq!(
        permits(&sync_cob_id(ID), &[0x7F, 0x80, 0x101]),
        [false, true, false]
    );
    assert_eq!(
        permits(&error_behaviour(ID), &[0, 1, 2, 3]),
        [true, true, true, false]
    );
    assert_eq!(
        permits(&nmt_start_up(ID), &[0, 1, 2, 3, 8, 9]),
        [true, false, true, false, true, false]
    );
    let [_, transmission_type, _, _] = tpdo_communication(ID, 0x180);
    assert_eq!(permits(&transmission_type, &[1, 251]), [true, false]);
}

/// Address, count, group, name, type, access of an object.
fn row(object: &Object) -> (u16, u8, u8, &str, &str, DataType, Access) {
    (
        object.index,
        object.sub,
        object.count,
        object.group,
        object.name,
        object.data_type,
        object.access,
    )
}

#[test]
fn objects_have_addresses_names_and_access_of_cia_301() {
    use Access::{Const, Ro, Rw};
    use DataType::{U8, U32};
    const MAPPING: [Object; 2] = mapping(1, "mapping", &[("slope", entry(0x6010, 2, 16))]);
    let objects = objects![
        [device_type(0x1_0195), error_register()],
        error_history(4),
        [text(0x1008, "Name", "IS")],
        identity(1, 2, 3),
        server_sdo(),
        MAPPING,
    ];
    let (error, identity) = ("Pre-defined error field", "Identity object");
    let expected = [
        (0x1000, 0, 1, "", "Device type", U32, Const),
        (0x1001, 0, 1, "", "Error register", U8, Ro),
        (0x1003, 0, 1, error, "Number of error entries", U8, Rw),
        (0x1003, 1, 4, "", "Error code", U32, Ro),
        (0x1008, 0, 1, "", "Name", U8, Const),
        (
            0x1018,
            0,
            1,
            identity,
            "Highest supported sub-index",
            U8,
            Ro,
        ),
        (0x1018, 1, 1, "", "Vendor ID", U32, Ro),
        (0x1018, 2, 1, "", "Product code", U32, Ro),
        (0x1018, 3, 1, "", "Revision number", U32, Ro),
        (0x1018, 4, 1, "", "Serial number", U32, Ro),
        (
            0x1200,
            0,
            1,
            "Server SDO parameter",
            "Highest supported sub-index",
            U8,
            Ro,
        ),
        (0x1200, 1, 1, "", "COB-ID client to server", U32, Ro),
        (0x1200, 2, 1, "", "COB-ID server to client", U32, Ro),
        (
            0x1A01,
            0,
            1,
            "mapping",
            "Highest supported sub-index",
            U8,
            Ro,
        ),
        (0x1A01, 1, 1, "", "slope", U32, Ro),
    ];
    assert_eq!(objects.iter().map(row).collect::<Vec<_>>(), expected);
    let targets: Vec<_> = objects.iter().map(|object| object.target).collect();
    assert_eq!(
        targets,
        [
            Target::Constant(0x1_0195),
            Target::Service(Service::ErrorRegister),
            Target::Service(Service::ErrorCount),
            Target::Service(Service::ErrorHistory),
            Target::Text("IS"),
            Target::Constant(4),
            Target::Constant(1),
            Target::Constant(2),
            Target::Constant(3),
            Target::Service(Service::SerialNumber),
            Target::Constant(2),
            Target::NodeRelative(0x600),
            Target::NodeRelative(0x580),
            Target::Constant(1),
            Target::Constant(0x6010_0210),
        ]
    );
}

#[test]
fn tpdo_has_sub_indices_of_cia_301() {
    let rows = tpdo(3, "TPDO", ID);
    let addresses = rows.map(|object| (object.index, object.sub, object.access, object.target));
    let parameter = |sub, id| {
        let target = Target::Parameter(ParameterId(id));
        (0x1803, sub, Access::Rw, target)
    };
    assert_eq!(
        addresses,
        [
            (0x1803, 0, Access::Ro, Target::Constant(5)),
            (0x1803, 1, Access::Rw, Target::CobId(ID)),
            parameter(2, 8),
            parameter(3, 9),
            parameter(5, 10),
        ]
    );
    assert_eq!(rows[0].group, "TPDO");
}

#[test]
fn only_values_can_be_mapped() {
    assert!(Object::value(0x6010, 0, ValueId(0)).mappable);
    assert!(!read_only(0x4080, 0, ValueId(0)).mappable);
    assert!(!Object::parameter(0x6000, 0, ID).mappable);
}

#[test]
#[should_panic = "one row more"]
fn mapping_with_another_number_of_rows_is_refused() {
    let _: [Object; 3] = mapping(0, "", &[("slope", entry(0x6010, 0, 16))]);
}
