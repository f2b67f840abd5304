//! The Device Configuration File (DCF, CiA 306): the data sheet with the value of each setting, for other CANopen tools.

use super::address;
use crate::sheet::{Address, Entry};
use plumbline::can::BitRate;
use plumbline::param::DataType;
use std::collections::BTreeMap;

/// What a file says about the device.
#[derive(Clone, Debug, Default)]
pub struct Commissioning {
    /// The name of the file.
    pub file: String,
    /// The node-ID that the file gives the device.
    pub node: u8,
    /// The name of the sensor.
    pub name: String,
    /// The bit rate that the file gives the device.
    pub rate: Option<BitRate>,
    /// The serial number of the device in the file.
    pub serial: Option<u32>,
}

/// The data sheet with these values. The file is otherwise as it was.
pub fn text(data_sheet: &str, device: &Commissioning, values: &[(Entry, u32)]) -> String {
    let mut left: BTreeMap<(u16, u8), String> = values
        .iter()
        .filter_map(|(entry, raw)| match entry.address {
            Address::Object { index, sub } => Some(((index, sub), value(entry, *raw))),
            _ => None,
        })
        .collect();
    let mut lines: Vec<String> = Vec::new();
    let mut is_dropped = false;
    let mut is_info = false;
    for line in data_sheet.lines() {
        let trimmed = line.trim();
        let key = trimmed.split('=').next().unwrap_or_default().trim();
        let is = |name: &str| key.eq_ignore_ascii_case(name);
        if let Some(name) = section(trimmed) {
            is_info = name.eq_ignore_ascii_case("FileInfo");
            // These sections belong to an older configuration. CiA 306 has one m, other tools write two.
            let is_commissioning = ["DeviceComissioning", "DeviceCommissioning"];
            is_dropped = is_commissioning
                .iter()
                .any(|own| name.trim().eq_ignore_ascii_case(own))
                || compact_values(name).is_some();
            if is_dropped {
                continue;
            }
            lines.push(trimmed.to_owned());
            if is_info {
                lines.push(format!("FileName={}", device.file));
            }
            let place = address(name).map(|(index, sub)| (index, sub.unwrap_or(0)));
            if let Some(value) = place.and_then(|place| left.remove(&place)) {
                lines.push(format!("ParameterValue={value}"));
            }
        } else if is_dropped || is("ParameterValue") || (is_info && is("LastEDS")) {
        } else if is_info && is("FileName") {
            let name = trimmed.split_once('=').map_or("", |(_, name)| name.trim());
            lines.push(format!("LastEDS={name}"));
        } else {
            lines.push(line.to_owned());
        }
    }
    // The sub-indices of objects that describe them all.
    let mut indices: Vec<u16> = left.keys().map(|(index, _)| *index).collect();
    indices.dedup();
    for index in indices {
        let subs = left.range((index, 0)..=(index, u8::MAX));
        let subs: Vec<(&(u16, u8), &String)> = subs.collect();
        lines.push(format!("\n[{index:04X}Value]\nNrOfEntries={}", subs.len()));
        lines.extend(
            subs.iter()
                .map(|((_, sub), value)| format!("{sub}={value}")),
        );
    }
    lines.push(format!(
        "\n[DeviceComissioning]\nNodeID={}\nNodeName={}",
        device.node, device.name
    ));
    if let Some(rate) = device.rate {
        let kbits = f64::from(rate.bits_per_second()) / 1000.0;
        lines.push(format!("Baudrate={kbits}"));
    }
    lines.push("NetNumber=0\nNetworkName=\nCANopenManager=0".to_owned());
    if let Some(serial) = device.serial {
        lines.push(format!("LSS_SerialNumber={serial}"));
    }
    lines.join("\n").replace('\r', "").replace('\n', "\r\n") + "\r\n"
}

/// The name of a section.
fn section(line: &str) -> Option<&str> {
    line.strip_prefix('[')?.split(']').next()
}

/// The index in the name of a section with values: `2000Value`.
fn compact_values(name: &str) -> Option<u16> {
    let small = name.to_ascii_lowercase();
    address(small.strip_suffix("value")?).map(|(index, _)| index)
}

/// A value in the form of the data sheet.
fn value(entry: &Entry, raw: u32) -> String {
    match entry.data_type {
        DataType::U32 => format!("0x{raw:X}"),
        _ => entry.data_type.value(raw).to_string(),
    }
}
