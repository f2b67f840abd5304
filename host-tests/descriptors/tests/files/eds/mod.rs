//! The Electronic Data Sheet: it is valid, it matches the manual, and the sensor matches it.

mod download;
mod others;
mod planted;
mod rules;
mod sdo;
mod sheet;
mod stranger;

use descriptors::{describe, describe_all};
use plumbline::model::catalog::find;
use rules::complaints;
use sdo::{Client, IMS360, IMS360_ONE_AXIS, JN2101, Subject, differences};
use sheet::{DataType, Sheet};
use std::collections::BTreeSet;

const NOTHING: &[String] = &[];

fn text() -> String {
    describe(find("jn2101").expect("a product")).text
}

/// The data sheet with this name, and the sensor that it describes.
const SHEETS: [(&str, Subject); 3] = [
    ("jn2101.eds", JN2101),
    ("ims360.eds", IMS360),
    ("ims360_1axis.eds", IMS360_ONE_AXIS),
];

fn sheet_of(name: &str, subject: Subject) -> String {
    let product = find(subject.product).expect("a product");
    let mut files = describe_all(product).into_iter();
    files.find(|file| file.name == name).expect("the file").text
}

#[test]
fn eds_is_valid() {
    for (name, subject) in SHEETS {
        assert_eq!(complaints(&sheet_of(name, subject)), NOTHING, "{name}");
    }
}

#[test]
fn sensor_matches_eds() {
    for (name, subject) in SHEETS {
        let sheet = Sheet::parse(&sheet_of(name, subject));
        assert_eq!(differences(subject, &sheet), NOTHING, "{name}");
    }
}

#[test]
fn eds_is_reproducible() {
    for (name, subject) in SHEETS {
        assert_eq!(sheet_of(name, subject), sheet_of(name, subject));
    }
}

/// Manual of the IMS360: 7.2.1, 7.2.17, 7.2.40.
#[test]
fn sheets_of_variants_differ_in_device_type_mapping_and_configuration_alone() {
    let variables = |(name, subject)| Sheet::parse(&sheet_of(name, subject)).variables();
    let [two_axes, one_axis] = [SHEETS[1], SHEETS[2]].map(variables);
    let differing: Vec<_> = two_axes
        .iter()
        .zip(&one_axis)
        .filter(|(two, one)| two.default != one.default)
        .map(|(two, one)| (two.address, two.default_at(0), one.default_at(0)))
        .collect();
    let expected = [
        ((0x1000, 0), Some(0x0704_019A), Some(0x0703_019A)),
        ((0x1A00, 0), Some(2), Some(1)),
        ((0x1A00, 2), Some(0x6120_0020), Some(0)),
        ((0x3120, 1), Some(1), Some(0)),
    ];
    assert_eq!(differing, expected);
    assert_eq!(two_axes.len(), one_axis.len());
}

/// Manual of the IMS360: 6.1.3, table 7, and what 7.2.36 to 7.2.39 mark.
#[test]
fn twenty_objects_of_the_ims360_can_be_mapped() {
    let sheet = Sheet::parse(&sheet_of("ims360.eds", IMS360));
    let mappable = sheet.variables().into_iter().filter(|one| one.mappable);
    let mappable: Vec<_> = mappable.map(|one| one.address).collect();
    let expected = [
        (0x3000, 1),
        (0x3010, 1),
        (0x3010, 2),
        (0x3010, 3),
        (0x3011, 0),
        (0x3012, 0),
        (0x3013, 0),
        (0x3020, 1),
        (0x3020, 2),
        (0x3020, 3),
        (0x3021, 0),
        (0x3022, 0),
        (0x3023, 0),
        (0x3100, 1),
        (0x3110, 2),
        (0x3112, 1),
        (0x3112, 4),
        (0x6110, 0),
        (0x6120, 0),
        (0x6511, 0),
    ];
    assert_eq!(mappable, expected);
}

#[test]
fn ims360_has_dynamic_mapping_lss_and_five_bit_rates() {
    let sheet = Sheet::parse(&sheet_of("ims360.eds", IMS360));
    let entry = |key: &str| sheet.number("DeviceInfo", key);
    assert_eq!(entry("Granularity"), Some(8));
    assert_eq!(entry("LSS_Supported"), Some(1));
    assert_eq!(entry("NrOfTXPDO"), Some(4));
    let rates = [10, 20, 50, 125, 250, 500, 800, 1000];
    let offered = rates.map(|rate| entry(&format!("BaudRate_{rate}")));
    let [no, yes] = [Some(0), Some(1)];
    assert_eq!(offered, [no, no, no, yes, yes, yes, yes, yes]);
    // SDO takes 1 to 126, and no 255.
    assert_eq!(sheet.number("2002", "LowLimit"), Some(1));
    assert_eq!(sheet.number("2002", "HighLimit"), Some(126));
    // There is no sub-index 4.
    assert!(!sheet.subs(0x1800).contains_key(&4));
}

#[test]
fn planted_defects_are_found() {
    let text = text();
    for defect in planted::DEFECTS {
        let planted = defect.plant(&text);
        let found = match defect.found_by {
            planted::Check::Rules => complaints(&planted),
            planted::Check::Sensor => {
                assert_eq!(complaints(&planted), NOTHING, "{}", defect.what);
                differences(JN2101, &Sheet::parse(&planted))
            }
        };
        assert!(!found.is_empty(), "{}", defect.what);
    }
}

/// J30 and J34 of the product's document: services, values that refer to the present position, the self-test, node-ID and bit rate.
const NOT_DOWNLOADED: [(u16, u8); 11] = [
    (0x1003, 0),
    (0x1010, 1),
    (0x1011, 1),
    (0x2000, 0),
    (0x2001, 0),
    (0x2002, 0),
    (0x2042, 0),
    (0x2046, 0),
    (0x207F, 0),
    (0x3000, 0),
    (0x4004, 1),
];

/// S75 of the product's document: services, reset, zero point, bit rate, node-ID and protocol.
const IMS360_NOT_DOWNLOADED: [(u16, u8); 15] = [
    (0x1003, 0),
    (0x1010, 1),
    (0x1010, 2),
    (0x1010, 3),
    (0x1010, 4),
    (0x1011, 1),
    (0x1011, 2),
    (0x1011, 3),
    (0x1011, 4),
    (0x1011, 5),
    (0x2001, 0),
    (0x2002, 0),
    (0x2010, 1),
    (0x3100, 1),
    (0x3200, 0),
];

/// The objects of a data sheet with ObjFlags = 1.
fn flagged(text: &str) -> Vec<(u16, u8)> {
    let sheet = Sheet::parse(text);
    let variables = sheet.variables().into_iter();
    let flagged = variables.filter(|one| sheet.get(&one.section, "ObjFlags") == Some("1"));
    flagged.map(|one| one.address).collect()
}

#[test]
fn exactly_commands_and_what_moves_the_node_have_object_flag_1() {
    assert_eq!(flagged(&text()), NOT_DOWNLOADED);
    for (name, subject) in &SHEETS[1..] {
        assert_eq!(flagged(&sheet_of(name, *subject)), IMS360_NOT_DOWNLOADED);
    }
}

#[test]
fn only_flagged_objects_and_variable_contents_have_no_factory_value() {
    let without: BTreeSet<_> = Sheet::parse(&text())
        .variables()
        .into_iter()
        .filter(|variable| variable.default.is_none())
        .map(|variable| variable.address)
        .collect();
    // The serial number, and measured values.
    let variable = [
        (0x1018, 4),
        (0x4080, 0),
        (0x4081, 0),
        (0x6010, 0),
        (0x6020, 0),
        (0x6110, 0),
        (0x6120, 0),
    ];
    assert_eq!(
        without,
        NOT_DOWNLOADED.into_iter().chain(variable).collect()
    );
}

/// Angles and temperature (manual 7.7); a sensor in level position cannot show the difference.
#[test]
fn values_that_can_be_negative_are_signed() {
    let sheet = Sheet::parse(&text());
    let signed: Vec<_> = sheet
        .variables()
        .into_iter()
        .filter(|variable| matches!(variable.data_type, DataType::Signed(_)))
        .map(|variable| (variable.address.0, variable.data_type.bits()))
        .collect();
    let expected = [
        (0x4080, 32),
        (0x6010, 16),
        (0x6020, 16),
        (0x6110, 32),
        (0x6120, 32),
    ];
    assert_eq!(signed, expected);
}

/// Each test uses a new sensor, because some of the writes restart it.
#[test]
fn limit_values_are_permitted() {
    for variable in Sheet::parse(&text()).variables() {
        for number in [variable.low, variable.high].into_iter().flatten() {
            // The factory value of 207Fh reports a failure and is not written.
            if (variable.address.0, number) == (0x207F, 0) {
                continue;
            }
            let mut client = Client::new(JN2101);
            let written = client.write(variable.address, &variable.data_type.bytes(number));
            assert_eq!(written, Ok(()), "[{}] {number}", variable.section);
        }
    }
}

#[test]
fn identifiers_follow_the_node_id() {
    let mut client = Client::new(JN2101);
    assert_eq!(client.write((0x2000, 0), &[32]), Ok(()));
    // NMT: reset communication of node 10.
    client.send(0x000, &[0x82, JN2101.node_id]);
    client.wait(100);
    client.node_id = 32;
    let relative = |variable: &sheet::Variable| {
        let default = variable.default.as_deref();
        default.is_some_and(|default| default.starts_with("$NODEID"))
    };
    let variables = Sheet::parse(&text()).variables();
    let identifiers: Vec<_> = variables.into_iter().filter(relative).collect();
    assert_eq!(identifiers.len(), 5, "1014h, two of 1200h, 1800h, 1801h");
    for variable in identifiers {
        let expected = variable.default_at(32).map(|id| (id as u32).to_le_bytes());
        let read = client.read(variable.address).ok();
        assert_eq!(read, expected.map(Vec::from), "[{}]", variable.section);
    }
}
