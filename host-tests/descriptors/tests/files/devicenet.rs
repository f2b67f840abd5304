//! The data sheets of the DeviceNet products: sections and fields as ODVA defines them, and each parameter as the sensor has it on the
//! wire: type, size, limits, default value, and whether it is read-only.

use bench::{AdapterId, Bus, BusRate, Device, Flash, NodeType};
use descriptors::describe;
use plumbline::can::{Frame, standard};
use plumbline::measure::Reading;
use plumbline::model::catalog::{PRODUCTS, Product, Protocol, find};
use plumbline::time::{after, millis};
use std::collections::BTreeMap;

/// The fields of an entry.
type Fields = Vec<String>;

/// The sections of a data sheet, each with its entries in their order.
struct Sheet(Vec<(String, Vec<(String, Fields)>)>);

impl Sheet {
    /// Reads a data sheet: comments begin with `$`, an entry ends with `;`.
    fn parse(text: &str) -> Self {
        let mut sections: Vec<(String, Vec<(String, Fields)>)> = Vec::new();
        for line in text.lines() {
            let line = line.split('$').next().unwrap_or("").trim();
            if line.is_empty() {
                continue;
            }
            if let Some(name) = line
                .strip_prefix('[')
                .and_then(|line| line.strip_suffix(']'))
            {
                sections.push((name.to_owned(), Vec::new()));
                continue;
            }
            let entry = line.strip_suffix(';').expect("an entry ends with ;");
            let (key, value) = entry.split_once('=').expect("an entry has a key");
            let (_, entries) = sections.last_mut().expect("an entry is in a section");
            entries.push((key.trim().to_owned(), fields(value)));
        }
        Self(sections)
    }

    fn section(&self, name: &str) -> &[(String, Fields)] {
        let found = self.0.iter().find(|(section, _)| section == name);
        let (_, entries) = found.unwrap_or_else(|| panic!("no section {name}"));
        entries
    }

    fn get(&self, section: &str, key: &str) -> &Fields {
        let mut entries = self.section(section).iter();
        let found = entries.find(|(name, _)| name == key);
        let (_, fields) = found.unwrap_or_else(|| panic!("no {key} in {section}"));
        fields
    }

    fn number(&self, section: &str, key: &str) -> i64 {
        number(&self.get(section, key)[0])
    }

    fn text(&self, section: &str, key: &str) -> &str {
        &self.get(section, key)[0]
    }
}

/// The fields between commas outside of quotes; quotes are removed.
fn fields(value: &str) -> Fields {
    let (mut fields, mut quoted) = (vec![String::new()], false);
    for letter in value.trim().chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            ' ' if !quoted => {}
            _ => fields.last_mut().expect("a field").push(letter),
        }
    }
    assert!(!quoted, "{value}");
    fields
}

fn number(text: &str) -> i64 {
    let number = match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// A sensor with factory values and a master with an explicit connection.
struct Master {
    bus: Bus,
    adapter: AdapterId,
}

impl Master {
    fn new(product: &Product) -> Self {
        let mut bus = Bus::new(BusRate::Follow);
        let motion = Box::new(Reading::default());
        bus.attach(Device::new(
            &NodeType::from(product),
            1,
            Flash::default(),
            motion,
        ));
        let adapter = bus.adapter();
        bus.open(adapter, None, false);
        let mut master = Self { bus, adapter };
        master.run(2200);
        assert_eq!(master.send(6, &[0x4B, 3, 1, 1, 0x0A]), [0xCB, 0]);
        assert_eq!(master.ask(&[0x10, 5, 1, 9, 0, 0]), [0x90, 0, 0]);
        master
    }

    fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    /// The answer to a request, without its header. Fragments are joined.
    fn send(&mut self, message: u16, request: &[u8]) -> Vec<u8> {
        let mut bytes = [&[0x0A], request].concat();
        let mut answer = Vec::new();
        loop {
            self.bus.take_received(self.adapter);
            let frame = Frame::data(standard(0x5F8 | message), &bytes);
            self.bus
                .send(self.adapter, frame.expect("at most eight bytes"));
            self.run(5);
            let received = self.bus.take_received(self.adapter);
            let Some((_, frame)) = received.first() else {
                return answer;
            };
            let (header, body) = frame.bytes().split_first().expect("a header");
            if header & 0x80 == 0 {
                return body.to_vec();
            }
            answer.extend(&body[1..]);
            bytes = vec![0x8A, 0xC0 | body[0] & 0x3F, 0];
        }
    }

    fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.send(4, request)
    }

    /// The value of an attribute.
    fn get(&mut self, class: u8, instance: u8, attribute: u8) -> Vec<u8> {
        let answer = self.ask(&[0x0E, class, instance, attribute]);
        assert_eq!(
            answer[0], 0x8E,
            "{class:02X} {attribute:02X}: {answer:02X?}"
        );
        answer[1..].to_vec()
    }

    /// Sets an attribute of the instance 1; the error is the general code.
    fn set(&mut self, class: u8, attribute: u8, value: i64, size: usize) -> Result<(), u8> {
        let bytes = value.to_le_bytes();
        let request = [&[0x10, class, 1, attribute], &bytes[..size]].concat();
        match *self.ask(&request) {
            [0x90] => Ok(()),
            [0x94, code, 0xFF] => Err(code),
            ref answer => panic!("{answer:02X?}"),
        }
    }
}

/// A number from bytes, low byte first.
fn value(bytes: &[u8], signed: bool) -> i64 {
    let raw = bytes
        .iter()
        .rev()
        .fold(0_i64, |sum, byte| sum << 8 | i64::from(*byte));
    let unused = 64 - 8 * bytes.len();
    if signed { raw << unused >> unused } else { raw }
}

/// The types with their sizes and whether they are signed.
const TYPES: [(i64, usize, bool); 4] = [
    (0xC3, 2, true),
    (0xC4, 4, true),
    (0xC6, 1, false),
    (0xC7, 2, false),
];

const INVALID_VALUE: u8 = 0x09;
const NOT_SETTABLE: u8 = 0x0E;

/// Bits of the descriptor.
const ENUMERATED: i64 = 1 << 1;
const READ_ONLY: i64 = 1 << 4;
const MONITOR: i64 = 1 << 5;

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
    assert!(!fields[6].is_empty(), "{key}: the name");
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

/// The named values of a parameter.
fn enumerated(sheet: &Sheet, place: usize, low: i64) -> Vec<i64> {
    let mut params = sheet.section("Params").iter();
    if let Some((_, fields)) = params.find(|(name, _)| *name == format!("Enum{place}")) {
        assert!(fields.len().is_multiple_of(2));
        return fields
            .iter()
            .step_by(2)
            .map(|field| number(field))
            .collect();
    }
    let names = sheet.get("EnumPar", &format!("Param{place}"));
    (low..).take(names.len()).collect()
}

/// Compares a data sheet with the sensor.
fn check(text: &str, product: &Product) {
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
