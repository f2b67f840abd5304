//! Rules of CiA 306 and CiA 301 for a data sheet, including those that tools do not check.

use super::sheet::{DataType, Sheet, Variable, number};
use std::collections::{BTreeMap, BTreeSet};

const FILE_INFO: &[&str] = &[
    "FileName",
    "FileVersion",
    "FileRevision",
    "EDSVersion",
    "Description",
    "CreationTime",
    "CreationDate",
    "CreatedBy",
    "ModificationTime",
    "ModificationDate",
    "ModifiedBy",
];

const DEVICE_INFO: &[&str] = &[
    "VendorName",
    "VendorNumber",
    "ProductName",
    "ProductNumber",
    "RevisionNumber",
    "OrderCode",
    "BaudRate_10",
    "BaudRate_20",
    "BaudRate_50",
    "BaudRate_125",
    "BaudRate_250",
    "BaudRate_500",
    "BaudRate_800",
    "BaudRate_1000",
    "SimpleBootUpMaster",
    "SimpleBootUpSlave",
    "Granularity",
    "DynamicChannelsSupported",
    "GroupMessaging",
    "NrOfRXPDO",
    "NrOfTXPDO",
    "LSS_Supported",
];

const LISTS: [&str; 3] = ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"];

/// All violations in a data sheet, one line each.
pub fn complaints(text: &str) -> Vec<String> {
    let sheet = Sheet::parse(text);
    let mut found = Vec::new();
    characters(text, &mut found);
    duplicates(&sheet, &mut found);
    information(&sheet, &mut found);
    lists(&sheet, &mut found);
    for index in sheet.indices() {
        object(&sheet, index, &mut found);
    }
    let variables = sheet.variables();
    for variable in &variables {
        value(variable, &mut found);
        identifier(variable, &mut found);
    }
    mappings(&variables, &mut found);
    found
}

fn characters(text: &str, found: &mut Vec<String>) {
    if !text.is_ascii() {
        found.push("not ASCII".to_owned());
    }
    if text.split("\r\n").any(|line| line.contains(['\r', '\n'])) || !text.ends_with("\r\n") {
        found.push("a line does not end with CR LF".to_owned());
    }
}

fn duplicates(sheet: &Sheet, found: &mut Vec<String>) {
    let mut sections = BTreeSet::new();
    for (name, entries) in &sheet.sections {
        if !sections.insert(name.to_lowercase()) {
            found.push(format!("[{name}] is duplicated"));
        }
        let mut keys = BTreeSet::new();
        for (key, _) in entries {
            if !keys.insert(key.to_lowercase()) {
                found.push(format!("[{name}] {key} is duplicated"));
            }
        }
    }
}

fn information(sheet: &Sheet, found: &mut Vec<String>) {
    for (section, keys) in [("FileInfo", FILE_INFO), ("DeviceInfo", DEVICE_INFO)] {
        for key in keys {
            if sheet.get(section, key).is_none_or(str::is_empty) {
                found.push(format!("[{section}] has no {key}"));
            }
        }
    }
    if sheet.get("FileInfo", "EDSVersion") != Some("4.0") {
        found.push("EDSVersion is not 4.0".to_owned());
    }
    let identity = [
        ("VendorNumber", 1),
        ("ProductNumber", 2),
        ("RevisionNumber", 3),
    ];
    for (key, sub) in identity {
        let object = sheet.number(&format!("1018sub{sub}"), "DefaultValue");
        if sheet.number("DeviceInfo", key) != object {
            found.push(format!("{key} is not that of 1018h"));
        }
    }
    for (key, first) in [("NrOfRXPDO", 0x1400), ("NrOfTXPDO", 0x1800)] {
        let pdos = first..first + 512;
        let count = sheet
            .indices()
            .iter()
            .filter(|at| pdos.contains(*at))
            .count();
        if sheet.number("DeviceInfo", key) != Some(count as i64) {
            found.push(format!("{key} is not {count}"));
        }
    }
    let lines = sheet.number("Comments", "Lines").unwrap_or(0);
    if lines == 0 || (1..=lines).any(|line| sheet.get("Comments", &format!("Line{line}")).is_none())
    {
        found.push("[Comments] is incomplete".to_owned());
    }
    for data_type in 1..=7 {
        if sheet
            .number("DummyUsage", &format!("Dummy{data_type:04}"))
            .is_none()
        {
            found.push(format!("[DummyUsage] has no {data_type}"));
        }
    }
}

/// The list that an object belongs to (CiA 306, 4.6.2).
fn list_of(index: u16) -> &'static str {
    match index {
        0x1000 | 0x1001 | 0x1018 => "MandatoryObjects",
        0x2000..0x6000 => "ManufacturerObjects",
        _ => "OptionalObjects",
    }
}

fn lists(sheet: &Sheet, found: &mut Vec<String>) {
    let mut listed = BTreeMap::new();
    for list in LISTS {
        let Some((_, entries)) = sheet.sections.iter().find(|(name, _)| name == list) else {
            found.push(format!("no [{list}]"));
            continue;
        };
        let count = entries.len() - 1;
        if sheet.number(list, "SupportedObjects") != Some(count as i64) {
            found.push(format!("[{list}] does not have {count} objects"));
        }
        let mut before = 0;
        for at in 1..=count {
            let Some(index) = sheet.number(list, &at.to_string()) else {
                found.push(format!("[{list}] has no entry {at}"));
                continue;
            };
            if index <= before {
                found.push(format!("[{list}] is not sorted at {at}"));
            }
            before = index;
            *listed.entry(index as u16).or_insert(0) += 1;
            if list_of(index as u16) != list {
                found.push(format!("{index:04X}h does not belong to [{list}]"));
            }
        }
    }
    for index in [0x1000, 0x1001, 0x1018] {
        if !listed.contains_key(&index) {
            found.push(format!("{index:04X}h is mandatory but missing"));
        }
    }
    let described: BTreeSet<_> = sheet.indices().into_iter().collect();
    for index in described.iter().filter(|index| !listed.contains_key(index)) {
        found.push(format!("{index:04X}h is in no list"));
    }
    for (index, times) in &listed {
        if *times != 1 {
            found.push(format!("{index:04X}h is listed {times} times"));
        }
        if !described.contains(index) {
            found.push(format!("{index:04X}h has no section"));
        }
    }
    if !sheet.indices().is_sorted() {
        found.push("the objects are not sorted".to_owned());
    }
}

/// ARRAY (8) or RECORD (9) as defined by CiA 301 (7.5.2); None: a variable (7), or manufacturer-specific.
fn object_code(index: u16) -> Option<i64> {
    match index {
        0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1029 => Some(8),
        0x1018 | 0x1200..=0x127F | 0x1800..=0x1BFF => Some(9),
        0x1000..=0x1FFF => Some(7),
        _ => None,
    }
}

fn object(sheet: &Sheet, index: u16, found: &mut Vec<String>) {
    let name = format!("{index:04X}");
    let subs = sheet.subs(index);
    let code = sheet.number(&name, "ObjectType");
    if object_code(index).is_some_and(|expected| code != Some(expected)) {
        found.push(format!("[{name}] ObjectType is not that of CiA 301"));
    }
    match code {
        Some(7) => {
            variable_entries(sheet, &name, found);
            if !subs.is_empty() || sheet.get(&name, "SubNumber").is_some() {
                found.push(format!("[{name}] is a variable with sub-indices"));
            }
        }
        Some(8 | 9) => structure(sheet, &name, &subs, found),
        _ => found.push(format!("[{name}] has an unknown ObjectType")),
    }
    if sheet.get(&name, "ParameterName").is_none_or(str::is_empty) {
        found.push(format!("[{name}] has no ParameterName"));
    }
}

fn structure(sheet: &Sheet, name: &str, subs: &BTreeMap<u8, String>, found: &mut Vec<String>) {
    if sheet.number(name, "SubNumber") != Some(subs.len() as i64) {
        found.push(format!("[{name}] SubNumber is not {}", subs.len()));
    }
    for key in ["DataType", "AccessType", "DefaultValue", "PDOMapping"] {
        if sheet.get(name, key).is_some() {
            found.push(format!("[{name}] has a {key}"));
        }
    }
    for section in subs.values() {
        variable_entries(sheet, section, found);
        if sheet.number(section, "ObjectType") != Some(7) {
            found.push(format!("[{section}] is not a variable"));
        }
    }
    let highest = subs.keys().last().copied().unwrap_or(0);
    let first = format!("{name}sub0");
    let is_mapping = name.starts_with("1A");
    let is_dynamic = is_mapping && sheet.get(&first, "AccessType") == Some("rw");
    let expected = match name {
        // The number of errors. Writing it is a command.
        "1003" => None,
        // The number of mapped objects.
        _ if is_dynamic => Some(mapped_count(sheet, subs)),
        // 2010h:02 does not exist, but the manual of the IMS360 prints 2.
        "2010" => Some(2),
        _ => Some(i64::from(highest)),
    };
    if sheet.number(&first, "DefaultValue") != expected {
        found.push(format!("[{first}] is not {expected:?}"));
    }
    if sheet.number(&first, "DataType") != Some(0x0005) {
        found.push(format!("[{first}] is not UNSIGNED8"));
    }
}

/// The number of entries of a dynamic mapping that are not empty.
fn mapped_count(sheet: &Sheet, subs: &BTreeMap<u8, String>) -> i64 {
    let entries = subs.iter().filter(|(sub, _)| **sub > 0);
    let used = entries.filter(|(_, section)| sheet.number(section, "DefaultValue") != Some(0));
    used.count() as i64
}

fn variable_entries(sheet: &Sheet, name: &str, found: &mut Vec<String>) {
    for key in [
        "ParameterName",
        "ObjectType",
        "DataType",
        "AccessType",
        "PDOMapping",
    ] {
        if sheet.get(name, key).is_none_or(str::is_empty) {
            found.push(format!("[{name}] has no {key}"));
        }
    }
    if sheet
        .number(name, "DataType")
        .and_then(DataType::of)
        .is_none()
    {
        found.push(format!("[{name}] has an unknown DataType"));
    }
    if let Some(flags) = sheet.get(name, "ObjFlags")
        && (flags != "1" || sheet.get(name, "DefaultValue").is_some())
    {
        found.push(format!("[{name}] is a command with ObjFlags {flags}"));
    }
    let access = sheet.get(name, "AccessType").unwrap_or("");
    if !["ro", "rw", "wo", "const"].contains(&access) {
        found.push(format!("[{name}] AccessType {access}"));
    }
}

/// The factory value fits the type and is within the limits.
fn value(variable: &Variable, found: &mut Vec<String>) {
    let section = &variable.section;
    if variable.data_type == DataType::Text {
        if variable.low.is_some() || variable.high.is_some() {
            found.push(format!("[{section}] is a text with limits"));
        }
        return;
    }
    let [lowest, highest] = variable.data_type.limits();
    let low = variable.low.unwrap_or(lowest);
    let high = variable.high.unwrap_or(highest);
    if low < lowest || high > highest || low > high {
        found.push(format!("[{section}] limits"));
    }
    if variable.access == "const" && variable.default.is_none() {
        found.push(format!("[{section}] is constant without a value"));
    }
    if let DataType::Real(_) = variable.data_type {
        let default = variable.default.as_deref().map(str::parse::<f64>);
        if default.is_some_and(|number| number.is_err()) {
            found.push(format!("[{section}] DefaultValue is not a real number"));
        }
        return;
    }
    let outside = |value: i64| value < low || value > high;
    if variable.default.is_some()
        && [1, 127]
            .iter()
            .any(|&id| variable.default_at(id).is_none_or(outside))
    {
        found.push(format!("[{section}] DefaultValue"));
    }
}

/// Only the identifiers of the predefined connection set (CiA 301, table 76) depend on the node id.
fn identifier(variable: &Variable, found: &mut Vec<String>) {
    let (index, sub) = variable.address;
    let used = match (index, sub) {
        (0x1014, 0) => Some(0x080),
        (0x1200, 1) => Some(0x600),
        (0x1200, 2) => Some(0x580),
        (0x1800..=0x1803, 1) => Some(0x180 + 0x100 * i64::from(index - 0x1800)),
        _ => None,
    };
    let relative = variable
        .default
        .as_deref()
        .and_then(|text| text.strip_prefix("$NODEID+"));
    // Bit 31: the TPDO is off.
    let base = relative.and_then(number).map(|base| base & !(1 << 31));
    if base != used {
        found.push(format!(
            "[{}] has a wrong dependency on the node id",
            variable.section
        ));
    }
}

/// An object mapped to a TPDO exists, can be mapped and has the length of the mapping; the TPDO fits into eight bytes.
fn mappings(variables: &[Variable], found: &mut Vec<String>) {
    let has = |address| variables.iter().any(|variable| variable.address == address);
    let mut bits = BTreeMap::new();
    for mapping in variables {
        let (index, sub) = mapping.address;
        if !(0x1A00..0x1C00).contains(&index) || sub == 0 {
            continue;
        }
        let section = &mapping.section;
        let entry = mapping.default_at(0).unwrap_or(0) as u32;
        // An empty entry of a dynamic mapping.
        if entry == 0 && mapping.access == "rw" {
            continue;
        }
        let [length, mapped_sub, low, high] = entry.to_le_bytes();
        let address = (u16::from_le_bytes([low, high]), mapped_sub);
        let Some(mapped) = variables
            .iter()
            .find(|variable| variable.address == address)
        else {
            found.push(format!("[{section}] maps an object that does not exist"));
            continue;
        };
        if !mapped.mappable || mapped.access == "wo" {
            found.push(format!("[{section}] maps an object that cannot be mapped"));
        }
        if mapped.data_type.bits() != u32::from(length) {
            found.push(format!("[{section}] maps with a wrong length"));
        }
        *bits.entry(index).or_insert(0) += u32::from(length);
        if !has((index - 0x200, 1)) {
            found.push(format!("[{section}] belongs to no TPDO"));
        }
    }
    for (index, bits) in bits {
        if bits > 64 {
            found.push(format!("{index:04X}h maps {bits} bits"));
        }
    }
}
