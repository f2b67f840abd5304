//! The second part of a scan: which nodes the frames of a bus show. The signs of each protocol are in its folder.
//!
//! If a node does not exist, a request to it can be a command to another device. The tool asks a node without a yes if its messages are
//! certain. A node that is known by its process data is asked only after a yes, because its address is likely at most; a slave that another
//! master owns is not asked.

use super::listen::Frames;
use super::row::{By, Heard, Row};
use super::signs::{Bus, Seen, Shown, Sign};
use crate::error::RequestError;
use crate::master::{PROTOCOLS, Protocol, Target};

/// A node that the frames show.
pub struct Sighting {
    /// The row of the list.
    pub row: Row,
    /// Its address, if it can be asked and no other device uses its identifiers.
    pub target: Option<Target>,
    /// Its messages are messages of a sensor, so the tool asks it. The tool asks other nodes only after a yes.
    pub is_sure: bool,
    /// Its messages show the protocol of the bus.
    shows_protocol: bool,
}

impl Sighting {
    /// Its protocol and address, with what it has told besides in a message of its own; None: process data only, or no address.
    pub(crate) fn told(&self) -> Option<(String, String)> {
        let Row::Heard(heard) = &self.row else {
            return None;
        };
        let address = heard.address.as_ref().filter(|_| heard.by == By::Message)?;
        let told = format!("{:?} {:?}", heard.serial, heard.text);
        Some((format!("{} {address}", heard.protocol), told))
    }

    /// The name of its protocol in documents.
    fn protocol(&self) -> &'static str {
        self.row.address().0
    }
}

/// The nodes that the frames show, each once, in the order of their first frame.
pub fn sightings(frames: &Frames) -> Vec<Sighting> {
    let mut bus = Bus::of(frames);
    let mut sightings = by_message(&bus);
    let sure = sightings.iter().filter(|sighting| sighting.is_sure);
    bus.sure = sure
        .filter_map(|sighting| Protocol::named(sighting.protocol()))
        .collect();
    for Shown { heard, target, .. } in by_process_data(&bus) {
        let row = Row::Heard(heard);
        let (protocol, address) = row.address();
        let is_known = |own: &Sighting| own.row.address() == (protocol, address.clone());
        // A node that has told its address.
        if address.is_some() && sightings.iter().any(is_known) {
            continue;
        }
        let is_other = bus.sure.iter().any(|own| own.name != protocol);
        sightings.push(Sighting {
            target: target.filter(|target| !is_used(*target, frames)),
            is_sure: false,
            shows_protocol: row.is_protocol() && !is_other,
            row,
        });
    }
    sightings
}

/// The nodes with messages of their own.
fn by_message(bus: &Bus) -> Vec<Sighting> {
    let judges = PROTOCOLS.map(|protocol| (protocol, (protocol.signs.judge)(bus)));
    let node = |seen: &Seen| {
        let Sign {
            target,
            serial,
            text,
        } = seen.sign.clone();
        let protocol = target.protocol();
        let (_, judge) = judges.iter().find(|(own, _)| *own == protocol)?;
        let is_sure = judge(seen)?;
        let heard = Heard {
            protocol: protocol.name,
            address: Some(target.address()),
            serial,
            text,
            by: By::Message,
        };
        let may_be_asked = !target.is_reserved() && !is_used(target, bus.frames);
        Some(Sighting {
            row: Row::Heard(heard),
            target: may_be_asked.then_some(target),
            is_sure,
            shows_protocol: is_sure,
        })
    };
    bus.seen.iter().filter_map(node).collect()
}

/// The nodes that are known by their process data alone, in the order of their first frame.
fn by_process_data(bus: &Bus) -> Vec<Shown> {
    let shown = PROTOCOLS.map(|protocol| (protocol.signs.process_data)(bus));
    let is_owned = |own: &Shown| own.heard.by == By::Owned;
    let mut nodes: Vec<Shown> = Vec::new();
    for id in &bus.ids {
        let mut own = shown.iter().flatten().filter(|own| own.id == *id);
        let first = own.clone().next();
        let Some(node) = own.find(|own| is_owned(own)).or(first) else {
            continue;
        };
        let is_same = |known: &Shown| {
            let (known, own) = (&known.heard, &node.heard);
            own.address.is_some()
                && (known.protocol, &known.address) == (own.protocol, &own.address)
        };
        if !nodes.iter().any(is_same) {
            nodes.push(node.clone());
        }
    }
    // The bus has the protocol of a slave that another master owns.
    if let Some(owned) = nodes.iter().find(|own| is_owned(own)) {
        let protocol = owned.heard.protocol;
        nodes.retain(|own| own.heard.protocol == protocol);
    }
    nodes
}

/// The addresses that several nodes have told, which are different by serial number.
pub(super) fn twins(sightings: &[Sighting]) -> Vec<RequestError> {
    let mut told: Vec<(&Heard, Vec<String>)> = Vec::new();
    for sighting in sightings {
        let Row::Heard(heard) = &sighting.row else {
            continue;
        };
        let Some(serial) = heard.serial else {
            continue;
        };
        let is_same =
            |own: &Heard| (own.protocol, &own.address) == (heard.protocol, &heard.address);
        match told.iter_mut().find(|(own, _)| is_same(own)) {
            Some((_, serials)) => serials.push(serial.to_string()),
            None => told.push((heard, vec![serial.to_string()])),
        }
    }
    told.retain(|(_, serials)| serials.len() > 1);
    let error = |(heard, serials): (&Heard, Vec<String>)| {
        let twins = Protocol::named(heard.protocol)?.signs.twins?;
        let address = heard.address.clone().unwrap_or_default();
        Some(twins(serials.len(), address, serials.join(" and ")))
    };
    told.into_iter().filter_map(error).collect()
}

/// The protocol of the bus, if the frames show it for sure. One bus has one protocol.
pub fn protocol(sightings: &[Sighting]) -> Option<&'static str> {
    let mut sure = sightings.iter().filter(|sighting| sighting.shows_protocol);
    sure.next().map(Sighting::protocol)
}

/// Whether the frames show that another node uses an identifier of the questions to an address, or of their answers.
pub fn is_used(target: Target, frames: &Frames) -> bool {
    let ids = target.identifiers();
    frames
        .iter()
        .any(|(_, frame)| ids.contains(&frame.can_id()))
}

#[cfg(test)]
mod process_data;
#[cfg(test)]
mod tests;
