//! The Electronic Data Sheet: it is valid, it matches the manual, and the sensor matches it.

mod planted;
mod rules;
mod sdo;
mod sheet;

use descriptors::describe;
use plumbline::model::catalog::find;
use rules::complaints;
use sdo::{Client, NO_OBJECT, NO_SUB_INDEX, differences};
use sheet::{DataType, Sheet};
use std::collections::BTreeSet;

const NOTHING: &[String] = &[];

fn text() -> String {
    describe(find("jn2101").expect("a product")).text
}

#[test]
fn eds_is_valid() {
    assert_eq!(complaints(&text()), NOTHING);
}

#[test]
fn sensor_matches_eds() {
    assert_eq!(differences(&Sheet::parse(&text())), NOTHING);
}

#[test]
fn eds_is_reproducible() {
    assert_eq!(text(), text());
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
                differences(&Sheet::parse(&planted))
            }
        };
        assert!(!found.is_empty(), "{}", defect.what);
    }
}

/// J30 of the product's document: services, values that refer to the present position, and the self-test.
const COMMANDS: [(u16, u8); 9] = [
    (0x1003, 0),
    (0x1010, 1),
    (0x1011, 1),
    (0x2002, 0),
    (0x2042, 0),
    (0x2046, 0),
    (0x207F, 0),
    (0x3000, 0),
    (0x4004, 1),
];

#[test]
fn exactly_the_commands_have_object_flag_1() {
    let sheet = Sheet::parse(&text());
    let flagged: Vec<_> = sheet
        .variables()
        .into_iter()
        .filter(|variable| sheet.get(&variable.section, "ObjFlags") == Some("1"))
        .map(|variable| variable.address)
        .collect();
    assert_eq!(flagged, COMMANDS);
}

#[test]
fn only_commands_and_variable_contents_have_no_factory_value() {
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
    assert_eq!(without, COMMANDS.into_iter().chain(variable).collect());
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
            let mut client = Client::new();
            let written = client.write(variable.address, &variable.data_type.bytes(number));
            assert_eq!(written, Ok(()), "[{}] {number}", variable.section);
        }
    }
}

#[test]
fn identifiers_follow_the_node_id() {
    let mut client = Client::new();
    assert_eq!(client.write((0x2000, 0), &[32]), Ok(()));
    // NMT: reset communication of node 10.
    client.send(0x000, &[0x82, sdo::NODE_ID]);
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

#[test]
fn sensor_has_no_other_objects() {
    let sheet = Sheet::parse(&text());
    let described: BTreeSet<_> = sheet
        .variables()
        .into_iter()
        .map(|variable| variable.address)
        .collect();
    let indices: BTreeSet<_> = sheet.indices().into_iter().collect();
    let mut client = Client::new();
    for index in 0..=u16::MAX {
        let subs = if indices.contains(&index) {
            0..=u8::MAX
        } else {
            0..=0
        };
        for sub in subs {
            if described.contains(&(index, sub)) {
                continue;
            }
            let expected = if indices.contains(&index) {
                NO_SUB_INDEX
            } else {
                NO_OBJECT
            };
            let read = client.read((index, sub));
            assert_eq!(read, Err(expected), "{index:04X}h:{sub:02X}");
            let written = client.write((index, sub), &[0]);
            assert_eq!(written, Err(expected), "{index:04X}h:{sub:02X}");
        }
    }
}
