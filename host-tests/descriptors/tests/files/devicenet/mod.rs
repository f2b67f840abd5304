//! The data sheets of the DeviceNet products: sections and fields as ODVA defines them, and each parameter as the sensor has it on the
//! wire: type, size, limits, default value, and whether it is read-only.

mod download;
mod master;
mod sheet;

use descriptors::describe;
use master::{Master, value};
use plumbline::model::catalog::{PRODUCTS, Product, Protocol, find};
use sheet::{ENUMERATED, MONITOR, READ_ONLY, Sheet, TYPES, enumerated, number};
use std::collections::BTreeMap;

const INVALID_VALUE: u8 = 0x09;
const NOT_SETTABLE: u8 = 0x0E;

/// Compares a parameter entry with the sensor.
fn check_parameter(sheet: &Sheet, place: usize, master: &mut Master) -> (u8, u8) {
    let key = format!("Param{place}");
    let fields = sheet.get("Params", &key);
    assert_eq!(fields.len(), 21, "{key}");
    assert_eq!((fields[0].as_str(), fields[1].as_str()), ("0", "6"));
    let path: Vec<u8> = fields[2]
        .split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).expect("a byte"))
        .collect();
    let [0x20, class, 0x24, 1, 0x30, attribute] = path[..] else {
        panic!("{key}: {path:02X?}")
    };
    let descriptor = number(&fields[3]);
    let known = TYPES.iter().find(|(code, ..)| *code == number(&fields[4]));
    let (_, size, signed) = *known.unwrap_or_else(|| panic!("{key}: the type"));
    assert_eq!(number(&fields[5]), size as i64, "{key}: the size");
    assert!((1..=32).contains(&fields[6].len()), "{key}: the name");
    assert!(fields[8].len() <= 64, "{key}: the help text");
    let [low, high, default] = [9, 10, 11].map(|field| number(&fields[field]));
    assert!(low <= default && default <= high, "{key}");
    assert_eq!(fields[12..20], ["1", "1", "1", "0", "0", "0", "0", "0"]);
    let read = master.get(class, 1, attribute);
    assert_eq!(read.len(), size, "{key}: the size on the wire");
    if descriptor & MONITOR == 0 {
        assert_eq!(value(&read, signed), default, "{key}: the default value");
    }
    if descriptor & READ_ONLY != 0 {
        // Two bytes at most, so that the request fits into a frame: the access is checked before the length.
        let refused = master.set(class, attribute, low, size.min(2));
        assert_eq!(refused, Err(NOT_SETTABLE), "{key}");
        return (class, attribute);
    }
    let bits = 8 * size as u32;
    let fits = |number: i64| {
        let (from, to) = if signed {
            (-(1 << (bits - 1)), 1 << (bits - 1))
        } else {
            (0, 1 << bits)
        };
        (from..to).contains(&number)
    };
    for beyond in [low - 1, high + 1]
        .into_iter()
        .filter(|number| fits(*number))
    {
        let refused = master.set(class, attribute, beyond, size);
        assert_eq!(refused, Err(INVALID_VALUE), "{key}: {beyond}");
    }
    let permitted = match descriptor & ENUMERATED {
        0 => vec![low, high],
        _ => enumerated(sheet, place, low),
    };
    for number in permitted.into_iter().chain([default]) {
        assert_eq!(
            master.set(class, attribute, number, size),
            Ok(()),
            "{key}: {number}"
        );
        let read = master.get(class, 1, attribute);
        assert_eq!(value(&read, signed), number, "{key}");
    }
    (class, attribute)
}

/// Compares a data sheet with the sensor.
fn check(text: &str, product: &'static Product) {
    let sheet = Sheet::parse(text);
    let names: Vec<&str> = sheet.0.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "File",
            "Device",
            "Device Classification",
            "IO_Info",
            "ParamClass",
            "Params",
            "EnumPar"
        ]
    );
    let mut master = Master::new(product);
    let mut identity = |attribute| value(&master.get(1, 1, attribute), false);
    for (key, attribute) in [("VendCode", 1), ("ProdType", 2), ("ProdCode", 3)] {
        assert_eq!(sheet.number("Device", key), identity(attribute), "{key}");
    }
    let revision = sheet.number("Device", "MajRev") | sheet.number("Device", "MinRev") << 8;
    assert_eq!(revision, identity(4));
    let name = master.ask(&[0x0E, 1, 1, 7]);
    assert_eq!(&name[2..], sheet.text("Device", "ProdName").as_bytes());
    assert_eq!(sheet.text("Device Classification", "Class1"), "DeviceNet");
    for place in 1..=3 {
        let fields = sheet.get("IO_Info", &format!("Input{place}"));
        assert_eq!(fields.len(), 7);
        let instance = u8::from_str_radix(&fields[5][9..11], 16).expect("an instance");
        assert_eq!(fields[5], format!("20 04 24 {instance:02X} 30 03"));
        let data = master.get(4, instance, 3);
        assert_eq!(number(&fields[0]), data.len() as i64);
    }
    // The parameters are stored; the device has no parameter objects.
    assert_eq!(sheet.number("ParamClass", "Descriptor"), 1 << 3);
    let count = sheet.number("ParamClass", "MaxInst") as usize;
    let entries = sheet.section("Params").iter();
    let entries = entries.filter(|(name, _)| name.starts_with("Param"));
    assert_eq!(entries.count(), count);
    let mut found = BTreeMap::new();
    for place in 1..=count {
        let address = check_parameter(&sheet, place, &mut master);
        assert_eq!(found.insert(address, place), None, "{address:02X?} twice");
    }
    let Protocol::Devicenet(tables) = &product.protocol else {
        panic!("it speaks DeviceNet")
    };
    // All but the number of attributes.
    let attributes: usize = tables
        .objects
        .iter()
        .map(|object| object.attributes.len())
        .sum();
    assert_eq!(found.len(), attributes - 1);
}

fn devicenet() -> impl Iterator<Item = &'static Product> {
    let is = |product: &&Product| matches!(product.protocol, Protocol::Devicenet(_));
    PRODUCTS.iter().filter(is)
}

#[test]
fn data_sheet_is_that_of_the_sensor_on_the_wire() {
    assert_eq!(devicenet().count(), 2);
    for product in devicenet() {
        let text = describe(product).text;
        assert!(text.is_ascii());
        check(&text, product);
    }
}

/// Faults in a data sheet that the comparison must find.
#[test]
fn planted_fault_in_a_data_sheet_is_found() {
    let product = find("tiltix080").expect("a product");
    let text = describe(product).text;
    for (right, wrong) in [
        ("ProdCode = 80", "ProdCode = 81"),
        ("Descriptor = 0x0008", "Descriptor = 0x0000"),
        (
            "lateral16 operating param.\"",
            "lateral16 operating parameter\"",
        ),
        ("INCLINOMETER 080", "INCLINOMETER 081"),
        ("Input3 = 4", "Input3 = 2"),
        ("20 04 24 65", "20 04 24 67"),
        ("20 65 24 01 30 77", "20 65 24 01 30 74"),
        (
            "0x0000, 0xC3, 2, \"Slope long16 preset value\"",
            "0x0000, 0xC7, 2, \"Slope long16 preset value\"",
        ),
        ("-8000, 8000, 0,", "-8001, 8000, 0,"),
        ("-8000, 8000, 0,", "-8000, 7999, 0,"),
        ("0, 250, 100,", "0, 250, 99,"),
        (
            "0x0010, 0xC3, 2, \"Slope long16 offset\"",
            "0x0000, 0xC3, 2, \"Slope long16 offset\"",
        ),
        ("10, \"0.01 deg\", 100", "10, \"0.01 deg\", 101"),
        ("\"off\", \"on\";", "\"off\", \"on\", \"more\";"),
    ] {
        let planted = text.replacen(right, wrong, 1);
        assert_ne!(planted, text, "{right}");
        let found = std::panic::catch_unwind(|| check(&planted, product));
        assert!(found.is_err(), "{wrong}");
    }
}
