//! The messages of J1939. Long messages are put together from their packets. Group EF00h has the bytes of SDO.

use super::{PROTOCOL, tables};
use crate::decode::{Decoded, Decoder, Device, Known, Named};
use crate::master::canopen;
use crate::master::canopen::decode::sdo::Transfer;
use descriptors::signal_scale;
use plumbline::can::Frame;
use plumbline::j1939::identifier::{
    ACKNOWLEDGEMENT, ACTIVE_CODES, ADDRESS_CLAIMED, COMMANDED_ADDRESS, COMPONENT_IDENTIFICATION,
    ECU_IDENTIFICATION, GLOBAL, Identifier, NO_ADDRESS, PROPRIETARY_A, Pgn, REQUEST,
    SOFTWARE_IDENTIFICATION, TRANSPORT_CONTROL, TRANSPORT_DATA, pgn_of,
};
use plumbline::j1939::signal::{Group, Signal};
use plumbline::j1939::transport::{Control, PACKET};
use serde_json::json;
use std::collections::HashMap;

/// The groups with a name, except the process data of the tables.
const GROUPS: [(Pgn, &str); 11] = [
    (REQUEST, "request"),
    (ACKNOWLEDGEMENT, "acknowledgement"),
    (TRANSPORT_CONTROL, "TP.CM"),
    (TRANSPORT_DATA, "TP.DT"),
    (ADDRESS_CLAIMED, "address claimed"),
    (COMMANDED_ADDRESS, "commanded address"),
    (ACTIVE_CODES, "DM1"),
    (SOFTWARE_IDENTIFICATION, "software identification"),
    (COMPONENT_IDENTIFICATION, "component identification"),
    (ECU_IDENTIFICATION, "ECU identification"),
    (PROPRIETARY_A, "proprietary A"),
];

/// The fields of a NAME: first bit, number of bits.
const NAME: [(&str, u32, u32); 9] = [
    ("arbitrary-address", 63, 1),
    ("industry-group", 60, 3),
    ("vehicle-system-instance", 56, 4),
    ("vehicle-system", 49, 7),
    ("function", 40, 8),
    ("function-instance", 35, 5),
    ("ecu-instance", 32, 3),
    ("manufacturer", 21, 11),
    ("identity-number", 0, 21),
];

/// Sender and receiver of a message.
type Pair = (u8, u8);

/// A message of more than eight bytes.
struct Long {
    pgn: Pgn,
    size: usize,
    data: Vec<u8>,
}

/// The nodes on the bus.
struct Nodes {
    known: Known,
    devices: HashMap<u8, Device>,
    long: HashMap<Pair, Long>,
    transfers: HashMap<Pair, Transfer>,
}

/// A decoder for these products.
pub(super) fn decoder(known: Known) -> Box<dyn Decoder> {
    Box::new(Nodes {
        // The product that the user names is not that of the masters on the bus.
        known: known.untold(),
        devices: HashMap::new(),
        long: HashMap::new(),
        transfers: HashMap::new(),
    })
}

impl Decoder for Nodes {
    fn decode(&mut self, frame: &Frame) -> Option<Decoded> {
        let id = Identifier::of(frame)?;
        let decoded = self.message(id, frame.bytes());
        let decoded = decoded.unwrap_or_else(|| {
            let message = format!("PGN {:04X}h", id.pgn);
            let decoded = Decoded::new(&PROTOCOL, message).with(vec![Named::bytes(frame.bytes())]);
            Decoded {
                is_sure: false,
                ..decoded
            }
        });
        let message = match id.destination {
            GLOBAL => decoded.message,
            to => format!("{} to {to}", decoded.message),
        };
        let decoded = Decoded { message, ..decoded };
        Some(decoded.of(id.source, self.device(id.source)))
    }
}

impl Nodes {
    fn device(&mut self, address: u8) -> &mut Device {
        let known = &self.known;
        let device = self.devices.entry(address);
        device.or_insert_with(|| known.device())
    }

    fn message(&mut self, id: Identifier, data: &[u8]) -> Option<Decoded> {
        let word: Option<[u8; 8]> = data.try_into().ok();
        match id.pgn {
            TRANSPORT_CONTROL => self.control(id, word?),
            TRANSPORT_DATA => self.packet(id, word?),
            PROPRIETARY_A => self.object(id, word?),
            pgn => self.group(pgn, id.source, data),
        }
    }

    /// The name of a group.
    fn name(&self, pgn: Pgn) -> Option<String> {
        let mut named = GROUPS.iter();
        let named = named.find(|(own, _)| *own == pgn);
        let name = named.map(|(_, name)| *name);
        let name = name.or_else(|| self.process_data(pgn).map(|group| group.name));
        name.map(|name| format!("{name} ({pgn:04X}h)"))
    }

    /// The group with process data of one of the products.
    fn process_data(&self, pgn: Pgn) -> Option<Group> {
        let mut groups = self
            .known
            .products()
            .filter_map(tables)
            .flat_map(|tables| tables.groups.iter());
        groups.find(|group| group.pgn == pgn).copied()
    }

    /// A message of a group, also one that has come in packets.
    fn group(&mut self, pgn: Pgn, source: u8, data: &[u8]) -> Option<Decoded> {
        let word: Option<[u8; 8]> = data.try_into().ok();
        let asked = |bytes: &[u8]| {
            let pgn = pgn_of(bytes.try_into().ok()?);
            let name = self.name(pgn);
            Some(name.unwrap_or_else(|| format!("{pgn:04X}h")))
        };
        let values = match pgn {
            REQUEST => vec![Named::text("group", asked(data.get(..3)?)?)],
            ACKNOWLEDGEMENT => {
                let kind = match data.first()? {
                    0 => "positive",
                    1 => "negative",
                    2 => "access denied",
                    3 => "cannot respond",
                    _ => return None,
                };
                vec![
                    Named::text("control", kind),
                    Named::text("group", asked(data.get(5..8)?)?),
                ]
            }
            ADDRESS_CLAIMED => fields(&word?),
            COMMANDED_ADDRESS => {
                let mut values = fields(data.get(..8)?);
                values.push(Named::number("new-address", *data.get(8)?));
                values
            }
            ACTIVE_CODES => troubles(data)?,
            SOFTWARE_IDENTIFICATION | COMPONENT_IDENTIFICATION | ECU_IDENTIFICATION => {
                vec![Named::raw("text", data)]
            }
            _ => signals(self.process_data(pgn)?.signals, &word?),
        };
        let name = match (pgn, source) {
            (ADDRESS_CLAIMED, NO_ADDRESS) => "cannot claim address".to_owned(),
            (ADDRESS_CLAIMED | REQUEST | ACKNOWLEDGEMENT, _) => {
                let mut named = GROUPS.iter();
                named.find(|(own, _)| *own == pgn)?.1.to_owned()
            }
            _ => self.name(pgn)?,
        };
        Some(Decoded::new(&PROTOCOL, name).with(values))
    }

    fn control(&mut self, id: Identifier, bytes: [u8; 8]) -> Option<Decoded> {
        let (control, pgn) = Control::parse(bytes)?;
        let count = |name: &str, number: u64| Named::number(name, number);
        let (name, values) = match control {
            Control::RequestToSend { size, packets, .. } | Control::Broadcast { size, packets } => {
                self.long.insert(
                    (id.source, id.destination),
                    Long {
                        pgn,
                        size: size.into(),
                        data: Vec::new(),
                    },
                );
                let name = match control {
                    Control::Broadcast { .. } => "TP.CM announcement",
                    _ => "TP.CM request to send",
                };
                let values = vec![count("size", size.into()), count("packets", packets.into())];
                (name, values)
            }
            Control::ClearToSend {
                count: packets,
                next,
            } => (
                "TP.CM clear to send",
                vec![count("packets", packets.into()), count("next", next.into())],
            ),
            Control::End { size, packets } => (
                "TP.CM end of message",
                vec![count("size", size.into()), count("packets", packets.into())],
            ),
            Control::Abort(reason) => {
                self.long.remove(&(id.source, id.destination));
                self.long.remove(&(id.destination, id.source));
                ("TP.CM abort", vec![count("reason", reason.into())])
            }
        };
        let group = self.name(pgn).unwrap_or_else(|| format!("{pgn:04X}h"));
        let values = [vec![Named::text("group", group)], values].concat();
        Some(Decoded::new(&PROTOCOL, name).with(values))
    }

    fn packet(&mut self, id: Identifier, bytes: [u8; 8]) -> Option<Decoded> {
        let [place, data @ ..] = bytes;
        let name = format!("TP.DT packet {place}");
        let pair = (id.source, id.destination);
        let Some(long) = self.long.get_mut(&pair) else {
            return Some(Decoded::new(&PROTOCOL, name).with(vec![Named::bytes(&data)]));
        };
        // A packet that is sent again replaces itself. After a gap the message is not put together.
        let start = usize::from(place).wrapping_sub(1).wrapping_mul(PACKET);
        if start <= long.data.len() {
            long.data.truncate(start);
            long.data.extend_from_slice(&data);
        }
        if long.data.len() < long.size {
            return Some(Decoded::new(&PROTOCOL, name).with(vec![Named::bytes(&data)]));
        }
        let Long {
            pgn,
            size,
            mut data,
        } = self.long.remove(&pair)?;
        data.truncate(size);
        let whole = self.group(pgn, id.source, &data);
        let (message, values) = match whole {
            Some(whole) => (whole.message, whole.values),
            None => (format!("{pgn:04X}h"), vec![Named::bytes(&data)]),
        };
        Some(Decoded::new(&PROTOCOL, format!("{name}, end of {message}")).with(values))
    }

    /// A message between a client and the dictionary of a node. The command shows which one sends.
    fn object(&mut self, id: Identifier, bytes: [u8; 8]) -> Option<Decoded> {
        let asks = (id.destination, id.source);
        let answers = (id.source, id.destination);
        let known = self.known.clone();
        // A request initiates a transfer to the receiver, or goes on with one.
        let is_answer = self.transfers.contains_key(&answers);
        let (server, pair) = match is_answer {
            true => (id.source, answers),
            false => (id.destination, asks),
        };
        let device = self.devices.entry(server);
        let device = device.or_insert_with(|| known.device());
        let message = if is_answer {
            self.transfers.get_mut(&pair)?.answer(device, bytes)
        } else {
            let transfer = self.transfers.entry(pair).or_default();
            transfer.request(device, bytes)
        };
        let Some(message) = message else {
            self.transfers.remove(&pair);
            return None;
        };
        if let (Some((index, sub, data)), true) = (&message.done, is_answer) {
            canopen::decode::learn(device, *index, *sub, data);
        }
        Some(Decoded::new(&PROTOCOL, message.text).with(message.values))
    }
}

/// The fields of a NAME.
fn fields(bytes: &[u8]) -> Vec<Named> {
    let name = bytes.iter().rev();
    let name = name.fold(0_u64, |name, byte| name << 8 | u64::from(*byte));
    let field = |(title, first, bits): (&str, u32, u32)| {
        Named::number(title, name >> first & ((1 << bits) - 1))
    };
    NAME.map(field).into()
}

/// The lamps and the trouble codes of DM1.
fn troubles(data: &[u8]) -> Option<Vec<Named>> {
    let [lamps, _, codes @ ..] = data else {
        return None;
    };
    let mut values = vec![Named::text("lamps", format!("{lamps:02X}h"))];
    for code in codes.chunks_exact(4) {
        let &[low, middle, high, count] = code else {
            continue;
        };
        let (spn, fmi) = (u32::from_le_bytes([low, middle, high >> 5, 0]), high & 0x1F);
        if (spn, fmi) == (0, 0) || code == [0xFF; 4] {
            continue;
        }
        let text = format!("FMI {fmi}, {} times", count & 0x7F);
        values.push(Named::text(format!("SPN {spn}"), text));
    }
    Some(values)
}

/// The values of the signals of a group.
fn signals(signals: &[Signal], bytes: &[u8; 8]) -> Vec<Named> {
    let data = u64::from_le_bytes(*bytes);
    let value = |signal: &Signal| {
        let mask = u64::MAX >> (64 - u32::from(signal.bits));
        let raw = data >> signal.start & mask;
        let ((dividend, divisor), offset, unit) = signal_scale(signal);
        let name = match signal.spn {
            0 => signal.name.to_owned(),
            spn => format!("{} (SPN {spn})", signal.name),
        };
        let is_number = signal.bits >= 8;
        if raw == mask {
            return Named::text(name, "not available");
        }
        // The numbers above the range are errors and states.
        if is_number && raw >> (signal.bits - 8) > 0xFA {
            return Named::text(name, "error");
        }
        let number = raw as f64 * dividend as f64 / divisor as f64 + f64::from(offset);
        let text = match is_number {
            true => format!("{number:.4}"),
            false => raw.to_string(),
        };
        Named {
            name,
            text: format!("{text} {unit}").trim_end().to_owned(),
            json: json!({"value": number, "unit": unit, "raw": raw}),
        }
    };
    signals.iter().map(value).collect()
}
