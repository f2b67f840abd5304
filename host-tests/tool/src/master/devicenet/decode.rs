//! The messages of DeviceNet over the predefined master/slave connection set. A slave is known by its duplicate MAC ID check, or by the
//! allocation of its connections.

use super::{PROTOCOL, explicit, tables};
use crate::decode::{Decoded, Decoder, Device, Known, Named};
use crate::sheet::{Address, Entry};
use plumbline::can::Frame;
use plumbline::devicenet::identifiers::{Group1, MAC_MAX, group_2};
use plumbline::devicenet::service;
use plumbline::param::{DataType, ParameterId, number};
use std::collections::BTreeMap;

/// The longest message that is put together, in bytes.
const LONGEST: usize = 1024;

/// The lowest identifiers of groups 2 and 3.
const GROUP_2: u16 = 0x400;
const GROUP_3: u16 = 0x600;

/// The first class that the maker defines.
const OWN: u8 = 0x64;

/// An explicit request: service, class, instance, attribute.
#[derive(Clone, Copy, Debug, Default)]
struct Request {
    service: u8,
    class: u8,
    instance: u8,
    attribute: Option<u8>,
}

/// A slave.
struct Slave {
    device: Device,
    is_known: bool,
    /// The last request on the explicit connection, and at the unconnected port.
    asked: [Option<Request>; 2],
    /// The fragments of the request and of the response.
    parts: [Vec<u8>; 2],
    /// The assemblies of polls, and of COS or cyclic messages, if they were heard.
    assemblies: [Option<u32>; 2],
}

/// The slaves on the bus.
struct Slaves {
    known: Known,
    slaves: BTreeMap<u8, Slave>,
}

/// A decoder for these products.
pub(super) fn decoder(known: Known) -> Box<dyn Decoder> {
    Box::new(Slaves {
        known,
        slaves: BTreeMap::new(),
    })
}

impl Decoder for Slaves {
    fn decode(&mut self, frame: &Frame) -> Option<Decoded> {
        let id = u16::try_from(frame.can_id().bits()).ok()?;
        if frame.is_remote() || id >= GROUP_3 {
            return None;
        }
        let (mac, message) = match id < GROUP_2 {
            true => ((id & u16::from(MAC_MAX)) as u8, None),
            false => ((id >> 3 & u16::from(MAC_MAX)) as u8, Some(id & 7)),
        };
        let known = &self.known;
        let slave = self.slaves.entry(mac).or_insert_with(|| Slave {
            device: known.device(),
            is_known: false,
            asked: [None; 2],
            parts: [Vec::new(), Vec::new()],
            assemblies: [None; 2],
        });
        let data = frame.bytes();
        let explicit = match message {
            Some(group_2::DUPLICATE_CHECK) => slave.check(data),
            Some(group_2::UNCONNECTED) => slave.explicit(true, 1, data),
            Some(group_2::REQUEST) => slave.explicit(true, 0, data),
            // Responses of the unconnected port have the same identifier.
            Some(group_2::RESPONSE) => slave.explicit(false, 0, data),
            _ => None,
        };
        // Any machine can use the identifiers of the other messages.
        let is_slave = slave.is_known || slave.device.is_told();
        let other = || is_slave.then(|| slave.other(id, mac, message, data));
        let decoded = explicit.or_else(other)?;
        Some(Decoded {
            is_sure: slave.is_known,
            ..decoded.of(mac, &slave.device)
        })
    }
}

fn unused(group: u8, message: u16, data: &[u8]) -> Decoded {
    let name = format!("group {group}, message {message}");
    Decoded::new(&PROTOCOL, name).with(given(data))
}

/// Data, if there is any.
fn given(data: &[u8]) -> Vec<Named> {
    match data {
        [] => Vec::new(),
        data => vec![Named::bytes(data)],
    }
}

impl Slave {
    /// An I/O message, or one that is not used with the predefined connection set.
    fn other(&mut self, id: u16, mac: u8, message: Option<u16>, data: &[u8]) -> Decoded {
        match message {
            None if id == Group1::PollResponse.id(mac) => self.io("poll response", 0, data),
            None if id == Group1::ChangeOrCyclic.id(mac) => {
                self.io("COS or cyclic message", 1, data)
            }
            None => unused(1, id >> 6, data),
            Some(group_2::POLL) => Decoded::new(&PROTOCOL, "poll").with(given(data)),
            Some(group_2::ACKNOWLEDGE) => {
                Decoded::new(&PROTOCOL, "acknowledge of COS or cyclic").with(given(data))
            }
            Some(message) => unused(2, message, data),
        }
    }

    fn check(&mut self, data: &[u8]) -> Option<Decoded> {
        let &[port, low, high, ref serial @ ..] = data else {
            return None;
        };
        if serial.len() != 4 || port & 0x7F != 0 {
            return None;
        }
        self.is_known = true;
        let vendor = u16::from_le_bytes([low, high]);
        self.keep(|identity| identity.vendor == vendor);
        let kind = match port & 0x80 {
            0 => "request",
            _ => "response",
        };
        let decoded = Decoded::new(&PROTOCOL, format!("duplicate MAC ID check, {kind}"));
        Some(decoded.with(vec![
            Named::number("vendor", vendor),
            Named::number("serial-number", number(serial)),
        ]))
    }

    fn keep(&mut self, is: impl Fn(&plumbline::devicenet::Identity) -> bool) {
        self.device
            .keep(|product| tables(product).is_some_and(|tables| is(&tables.identity)));
    }

    /// An I/O message. It does not say its assembly: it is the one that was set, or the first one of its size.
    fn io(&mut self, name: &str, place: usize, data: &[u8]) -> Decoded {
        if !self.device.is_identified() {
            return Decoded::new(&PROTOCOL, name).needing_product(data);
        }
        let wanted = self.assemblies[place];
        let words = self.device.agreed(|product| {
            let tables = tables(product)?;
            let set = match place {
                0 => tables.roles.polled_assembly,
                _ => tables.roles.cyclic_assembly,
            };
            let factory = product.parameters.get(usize::from(set.0))?.factory;
            let instance = wanted.unwrap_or(factory);
            let is_size = |own: &&plumbline::devicenet::Assembly| {
                usize::from(own.size()) == data.len() && !data.is_empty()
            };
            let all = || tables.assemblies.iter().filter(is_size);
            let mut own = all().filter(|own| u32::from(own.instance) == instance);
            let own = own.next().or_else(|| all().next())?;
            Some((own.name, own.words))
        });
        let Some((assembly, words)) = words else {
            return Decoded::new(&PROTOCOL, name).with(given(data));
        };
        let values =
            words
                .iter()
                .zip(data.chunks(2))
                .map(|(id, bytes)| match self.device.published(*id) {
                    Some(entry) => Named::of(&entry, bytes),
                    None => Named::bytes(bytes),
                });
        let values = values.collect();
        Decoded::new(&PROTOCOL, format!("{name} ({assembly})")).with(values)
    }

    /// An explicit message, or a part of one.
    fn explicit(&mut self, is_request: bool, port: usize, data: &[u8]) -> Option<Decoded> {
        let [header, rest @ ..] = data else {
            return None;
        };
        if header & 0x80 == 0 {
            return self.message(is_request, port, rest);
        }
        let [control, part @ ..] = rest else {
            return None;
        };
        let (kind, count) = (control >> 6, control & 0x3F);
        let name = if is_request { "request" } else { "response" };
        if kind == 3 {
            let text = format!("explicit {name}, acknowledge of fragment {count}");
            return Some(Decoded::new(&PROTOCOL, text));
        }
        let parts = &mut self.parts[usize::from(!is_request)];
        if kind == 0 || parts.len() > LONGEST {
            parts.clear();
        }
        parts.extend_from_slice(part);
        let text = format!("explicit {name}, fragment {count}");
        if kind != 2 {
            return Some(Decoded::new(&PROTOCOL, text).with(vec![Named::bytes(part)]));
        }
        let whole = std::mem::take(parts);
        let whole = self.message(is_request, port, &whole)?;
        Some(Decoded {
            message: format!("{text}, end of {}", whole.message),
            ..whole
        })
    }

    fn message(&mut self, is_request: bool, port: usize, body: &[u8]) -> Option<Decoded> {
        match is_request {
            true => self.request(port, body),
            false => self.response(body),
        }
    }

    fn request(&mut self, port: usize, body: &[u8]) -> Option<Decoded> {
        let &[service, class, instance, ref data @ ..] = body else {
            return None;
        };
        if service & 0x80 != 0 {
            return None;
        }
        let has_attribute = matches!(service, service::GET | service::SET);
        let attribute = data.first().copied().filter(|_| has_attribute);
        let request = Request {
            service,
            class,
            instance,
            attribute,
        };
        self.asked[port] = Some(request);
        let mut values = Vec::new();
        match (service, data) {
            (service::ALLOCATE, [choice, master, ..]) if class == 3 => {
                self.is_known = true;
                values.push(Named::text("choice", format!("{choice:02X}h")));
                values.push(Named::number("master", *master));
            }
            (service::RELEASE, [choice, ..]) if class == 3 => {
                values.push(Named::text("choice", format!("{choice:02X}h")));
            }
            (service::SET, [_, data @ ..]) => values.push(self.value(request, data)),
            (service::GET, _) => {}
            (_, data) => values.extend(given(data)),
        }
        let text = format!("explicit request, {}", self.named(request));
        Some(Decoded::new(&PROTOCOL, text).with(values))
    }

    fn response(&mut self, body: &[u8]) -> Option<Decoded> {
        let [answered, data @ ..] = body else {
            return None;
        };
        if answered & 0x80 == 0 {
            return None;
        }
        if let (true, [code, more, ..]) = (*answered == service::ERROR | 0x80, data) {
            self.asked = [None; 2];
            let reason = explicit::reason(*code);
            let values = vec![Named::text(
                "reason",
                format!("{reason} ({code:02X}h, {more:02X}h)"),
            )];
            return Some(Decoded::new(&PROTOCOL, "explicit response, error").with(values));
        }
        let code = answered & 0x7F;
        let mut asked = self.asked.iter_mut();
        let asked = asked.find(|asked| asked.is_some_and(|asked| asked.service == code));
        let Some(request) = asked.and_then(Option::take) else {
            let text = format!("explicit response, {}", service_name(code));
            return Some(Decoded::new(&PROTOCOL, text).with(given(data)));
        };
        let values = match request.service {
            service::GET => vec![self.value(request, data)],
            _ => given(data),
        };
        let text = format!("explicit response, {}", self.named(request));
        Some(Decoded::new(&PROTOCOL, text).with(values))
    }

    fn entry(&self, request: Request) -> Option<Entry> {
        if request.class >= OWN && !self.device.is_identified() {
            return None;
        }
        self.device.entry(Address::Attribute {
            class: request.class,
            instance: request.instance,
            attribute: request.attribute?,
        })
    }

    /// The service with its object: class, instance and attribute, with the name of the attribute.
    fn named(&self, request: Request) -> String {
        let Request {
            service,
            class,
            instance,
            attribute,
        } = request;
        let mut text = format!(
            "{} class {class:02X}h instance {instance}",
            service_name(service)
        );
        if let Some(attribute) = attribute {
            text += &format!(" attribute {attribute}");
        }
        match self.entry(request) {
            Some(entry) => format!("{text} {}", entry.name),
            None => text,
        }
    }

    /// The value of an attribute that was read or written.
    fn value(&mut self, request: Request, data: &[u8]) -> Named {
        self.learn(request, data);
        let Some(entry) = self.entry(request) else {
            return Named::bytes(data);
        };
        let is_role = |role: fn(&plumbline::devicenet::Roles) -> ParameterId| {
            let is = self.device.agreed(|product| {
                let id = role(&tables(product)?.roles);
                Some(entry.origin == crate::sheet::Origin::Parameter(id))
            });
            is == Some(true)
        };
        let roles = [
            is_role(|roles| roles.polled_assembly),
            is_role(|roles| roles.cyclic_assembly),
        ];
        for (set, is_role) in self.assemblies.iter_mut().zip(roles) {
            if is_role && (1..=4).contains(&data.len()) {
                *set = Some(number(data));
            }
        }
        let text = match data {
            // A text begins with its length.
            [_, text @ ..] if entry.data_type == DataType::Text => text,
            _ => data,
        };
        self.device.value(&entry, text)
    }

    /// Which product it is, by its identity object.
    fn learn(&mut self, request: Request, data: &[u8]) {
        let &[low, high] = data else {
            return;
        };
        let told = u16::from_le_bytes([low, high]);
        match (request.class, request.attribute) {
            (1, Some(1)) => self.keep(|identity| identity.vendor == told),
            (1, Some(3)) => self.keep(|identity| identity.product_code == told),
            _ => {}
        }
    }
}

fn service_name(code: u8) -> String {
    match code {
        service::GET => "get".to_owned(),
        service::SET => "set".to_owned(),
        service::RESET => "reset".to_owned(),
        service::ALLOCATE => "allocate".to_owned(),
        service::RELEASE => "release".to_owned(),
        _ => format!("service {code:02X}h"),
    }
}
