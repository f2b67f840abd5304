//! The messages of sensors with function select codes.
//!
//! A sensor is known by its boot-up messages, or by the identifiers as delivered.

use super::boot_up::boot_up;
use super::identify::is_of_generation;
use super::request::{Sensor, names};
use super::{PROTOCOL, factory, tables};
use crate::decode::{Decoded, Decoder, Device, Known, Named};
use crate::number::shown;
use crate::number::version_text;
use crate::sheet::{Address, Entry};
use plumbline::can::{CanId, Frame};
use plumbline::fsc::{FLASH, UPDATE};
use plumbline::model::catalog::Product;
use plumbline::param::number;
use std::collections::HashSet;

/// The codes of the article number, and of the serial number with the software version.
const ARTICLE: u8 = 0x03;
const SERIAL: u8 = 0x04;

/// The code of the boot-up message.
const BOOT_UP: u8 = 0xFF;

/// A sensor that was heard, or one as delivered.
struct Node {
    sensor: Sensor,
    sync: Option<CanId>,
    /// The number of its boot-up messages.
    booted: u32,
    device: Device,
    article: Option<u32>,
    version: Option<u16>,
    update: Update,
}

/// Whether a sensor has its identifiers, or its bootloader has them.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Update {
    No,
    /// The sensor was asked to restart into its bootloader.
    Asked,
    /// The bootloader was asked: its requests are full frames, those of a sensor are not.
    Runs,
}

/// The sensors on the bus.
pub(super) struct Sensors {
    known: Known,
    nodes: Vec<Node>,
    /// The identifiers of other devices.
    foreign: HashSet<u32>,
}

/// The length of a boot-up message, and of the longest replies.
const FULL: usize = 8;

/// Whether a product has this code.
fn has_code(product: &Product, code: u8) -> bool {
    tables(product).is_some_and(|tables| {
        let mut access = tables.access.iter();
        access.any(|row| row.read == code || row.write == code)
            || tables.functions.iter().any(|row| row.code == code)
    })
}

/// A decoder for these products.
pub(super) fn decoder(known: Known) -> Box<dyn Decoder> {
    let mut sensors = Sensors {
        known,
        nodes: Vec::new(),
        foreign: HashSet::new(),
    };
    let products: Vec<&Product> = sensors.known.products().collect();
    for product in products {
        let Some(roles) = tables(product).map(|tables| &tables.roles) else {
            continue;
        };
        let id = |id| factory(product, id).map(CanId::from_bits);
        if let (Some(request), reply @ Some(_)) = (id(roles.set_id), id(roles.reply_id)) {
            let sensor = Sensor { request, reply };
            sensors.insert(sensor, id(roles.sync_id));
        }
    }
    Box::new(sensors)
}

impl Sensors {
    /// Whether one of the products has all bits in the status of a boot-up message. A value of J1939 that is not available has all
    /// bits.
    fn have_status(&self, frame: &Frame) -> bool {
        let status = frame.bytes().get(1).copied().unwrap_or_default();
        let mut tables = self.known.products().filter_map(tables);
        tables.any(|tables| names(&tables.status, status).len() == status.count_ones() as usize)
    }

    /// A full frame without a code is from another device, whose other frames can have the form of a boot-up message: the values of a
    /// group of J1939 do.
    fn leave_out(&mut self, frame: &Frame) {
        let [code, ..] = frame.bytes() else {
            return;
        };
        if frame.bytes().len() < FULL || self.known.products().any(|own| has_code(own, *code)) {
            return;
        }
        let id = frame.can_id();
        self.foreign.insert(id.bits());
        // Those with the identifiers as delivered have a SYNC identifier.
        self.nodes
            .retain(|node| node.sync.is_some() || node.sensor.reply != Some(id));
    }

    /// The sensor to or from whose bootloader a frame is. The next boot-up message is from the sensor.
    fn in_bootloader(&mut self, frame: &Frame) -> Option<&Node> {
        let id = frame.can_id();
        let nodes = self.nodes.iter_mut();
        let mut nodes = nodes.filter(|node| node.update != Update::No);
        let node = nodes.find(|node| node.sensor.request == id || node.sensor.reply == Some(id))?;
        if boot_up(frame) == Some(node.sensor) {
            node.update = Update::No;
        } else if node.sensor.request == id && frame.bytes().len() == FULL {
            node.update = Update::Runs;
        }
        (node.update == Update::Runs).then_some(node)
    }

    /// The number of boot-up messages with these identifiers that were heard before.
    fn insert(&mut self, sensor: Sensor, sync: Option<CanId>) -> &mut Node {
        let mut nodes = self.nodes.iter();
        let place = nodes.position(|node| node.sensor == sensor);
        let place = place.unwrap_or_else(|| {
            self.nodes.push(Node {
                sensor,
                sync,
                booted: 0,
                device: self.known.device(),
                article: None,
                version: None,
                update: Update::No,
            });
            self.nodes.len() - 1
        });
        &mut self.nodes[place]
    }
}

impl Decoder for Sensors {
    fn decode(&mut self, frame: &Frame) -> Option<Decoded> {
        if frame.is_remote() {
            return None;
        }
        let id = frame.can_id();
        if let Some(node) = self.in_bootloader(frame) {
            let is_request = node.sensor.request == id;
            let side = if is_request { "request" } else { "answer" };
            let decoded = Decoded::new(&PROTOCOL, format!("bootloader {side}"))
                .of(shown(node.sensor.request), &node.device)
                .with(vec![Named::bytes(frame.bytes())]);
            let is_sure = node.booted >= 2;
            return Some(Decoded { is_sure, ..decoded });
        }
        self.leave_out(frame);
        let is_own = self.have_status(frame) && !self.foreign.contains(&id.bits());
        if let Some(sensor) = boot_up(frame).filter(|_| is_own) {
            // One frame with this form can come from another device.
            self.insert(sensor, None).booted += 1;
        }
        let is_own = |node: &&mut Node| {
            node.sensor.request == id || node.sensor.reply == Some(id) || node.sync == Some(id)
        };
        let nodes = self.nodes.iter_mut().rev().filter(is_own);
        let node = nodes.max_by_key(|node| node.booted)?;
        let decoded = if node.sync == Some(id) {
            Decoded::new(&PROTOCOL, "sync")
        } else if node.sensor.request == id {
            node.request(frame.bytes())?
        } else {
            node.reply(frame.bytes())?
        };
        let is_sure = node.booted >= 2;
        let decoded = decoded.of(shown(node.sensor.request), &node.device);
        Some(Decoded { is_sure, ..decoded })
    }
}

impl Node {
    /// The name of a code, and whether it writes.
    fn code(&self, code: u8) -> Option<(&'static str, bool)> {
        self.device.agreed(|product| {
            let tables = tables(product)?;
            let mut access = tables.access.iter();
            let access = access.find(|row| row.read == code || row.write == code);
            let mut functions = tables.functions.iter();
            let function = functions.find(|row| row.code == code);
            function
                .map(|row| (row.name, false))
                .or_else(|| access.map(|row| (row.name, row.write == code)))
        })
    }

    fn has_code(&self, code: u8) -> bool {
        let mut products = self.device.products();
        products.any(|product| has_code(product, code))
    }

    /// A code and whether it writes. A code that the sensor does not have can be a message of another device, unless the sensor is known.
    fn named(&self, code: u8) -> Option<(String, bool)> {
        if !self.has_code(code) {
            let is_known = self.booted >= 2 || self.device.is_told();
            let name = match code {
                UPDATE => "update (60h)".to_owned(),
                _ => format!("code {code:02X}h"),
            };
            return is_known.then_some((name, false));
        }
        Some(match self.code(code) {
            Some((name, writes)) => (format!("{name} ({code:02X}h)"), writes),
            None => (format!("code {code:02X}h"), false),
        })
    }

    fn request(&mut self, bytes: &[u8]) -> Option<Decoded> {
        let [code, data @ ..] = bytes else {
            return None;
        };
        if *code == UPDATE && data.starts_with(FLASH) {
            self.update = Update::Asked;
        }
        let (name, writes) = self.named(*code)?;
        let entries = self.device.entries(
            |address| matches!(address, Address::Fsc { write: Some(write), .. } if write == *code),
        );
        let (verb, values) = match writes {
            true if !data.is_empty() => ("write", values(&entries, data)),
            // The sensor takes the value from its position.
            true => ("write without data", Vec::new()),
            false if data.is_empty() => ("request", Vec::new()),
            false => ("request", vec![Named::bytes(data)]),
        };
        Some(Decoded::new(&PROTOCOL, format!("{verb} {name}")).with(values))
    }

    fn reply(&mut self, bytes: &[u8]) -> Option<Decoded> {
        let [code, status, data @ ..] = bytes else {
            return None;
        };
        self.learn(*code, data);
        // The sensor refuses another code with its status.
        if !self.has_code(*code) && *code != UPDATE && !data.is_empty() {
            return None;
        }
        let (name, _) = self.named(*code)?;
        let status = self.status(*status);
        if let (BOOT_UP, [id @ .., _, _]) = (*code, data)
            && id.len() == 4
        {
            let values = vec![
                Named::text("status", status),
                Named::text("set-id", shown(CanId::from_bits(number(id)))),
                Named::text("software-version", version_text(number(&data[4..]) as u16)),
            ];
            return Some(Decoded::new(&PROTOCOL, "boot-up").with(values));
        }
        let entries = self
            .device
            .entries(|address| matches!(address, Address::Fsc { read, .. } if read == *code));
        let mut all = vec![Named::text("status", status)];
        all.extend(values(&entries, data));
        let place = entries.iter().map(end).max().unwrap_or(0);
        if let Some(counter) = data.get(place..place + 2).filter(|_| self.is_cyclic(*code))
            && !entries.is_empty()
        {
            all.push(Named::number("counter", number(counter)));
        }
        Some(Decoded::new(&PROTOCOL, format!("reply {name}")).with(all))
    }

    /// The names of the active bits of the status.
    fn status(&self, status: u8) -> String {
        let told = self.device.agreed(|product| {
            let names = names(&tables(product)?.status, status);
            Some(names.join(" + "))
        });
        match told {
            Some(told) if !told.is_empty() => told,
            Some(_) if status == 0 => "ok".to_owned(),
            _ => format!("{status:02X}h"),
        }
    }

    fn is_cyclic(&self, code: u8) -> bool {
        let own = self.device.agreed(|product| {
            let mut functions = tables(product)?.functions.iter();
            let own = functions.find(|row| row.code == code)?;
            Some(own.operation == plumbline::fsc::table::Operation::Inclination)
        });
        own == Some(true)
    }

    /// Which product it is, by article and software version.
    fn learn(&mut self, code: u8, data: &[u8]) {
        match (code, data) {
            (ARTICLE, [digits @ .., _, _]) if digits.len() == 4 => {
                self.article = Some(number(digits));
            }
            (SERIAL | BOOT_UP, [_, _, _, _, version @ ..]) if version.len() == 2 => {
                self.version = Some(number(version) as u16);
            }
            _ => return,
        }
        let (article, version) = (self.article, self.version);
        self.device.keep(|product| {
            tables(product).is_some_and(|tables| {
                tables.articles.iter().any(|own| {
                    article.is_none_or(|digits| own.number.digits() == digits)
                        && is_of_generation(own.version, version)
                })
            })
        });
    }
}

/// The end of an entry in the data.
fn end(entry: &Entry) -> usize {
    match entry.address {
        Address::Fsc { offset, .. } => usize::from(offset + entry.data_type.size()),
        _ => 0,
    }
}

/// The values of entries in the data of a message. If the entries are not known, the data.
fn values(entries: &[Entry], data: &[u8]) -> Vec<Named> {
    if entries.is_empty() && !data.is_empty() {
        return vec![Named::bytes(data)];
    }
    let value = |entry: &Entry| {
        let end = end(entry);
        let bytes = data.get(end - usize::from(entry.data_type.size())..end)?;
        Some(Named::of(entry, bytes))
    };
    entries.iter().filter_map(value).collect()
}
