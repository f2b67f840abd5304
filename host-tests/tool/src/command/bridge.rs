//! `bridge`: finds the sensors on the bus, then publishes what they measure.

use super::bus::Bus;
use crate::cli::bridge::Bridge;
use crate::cli::time;
use crate::connect;
use crate::error::{BrokerError, Error};
use crate::identify::Found;
use crate::labels::folder;
use crate::note::Note;
use crate::ops::bridge::address::{Address, Credentials, Files, transport};
use crate::ops::bridge::agopengps::AgOpenGps;
use crate::ops::bridge::broker::{Broker, Wanted};
use crate::ops::bridge::fleet::Fleet;
use crate::ops::bridge::known::Known;
use crate::ops::bridge::queue::Queue;
use crate::ops::bridge::topics::{Topics, bus_of};
use crate::ops::bridge::{Mqtt, Outputs, Roll, run};
use crate::output::Terminal;
use crate::question::Name;
use crate::scan;
use crate::serve::lease::Lease;
use plumbline::can::BitRate;
use plumbline::time::millis;
use std::path::PathBuf;

/// Publishes what the sensors on the bus measure.
///
/// # Errors
/// An option is wrong, no sensor was found, the adapter fails, or no connection with the broker can succeed.
pub(super) fn bridge(wanted: &Bridge, bus: &mut Bus, terminal: &mut Terminal) -> Result<(), Error> {
    let time = time(wanted.seconds)?;
    let to = wanted
        .agopengps
        .map(|module| AgOpenGps::new(wanted.agopengps_to, module));
    let to = to.transpose()?;
    // What is wrong in the files must be known before the search.
    let prepared = wanted.mqtt.as_deref().map(|url| prepare(url, wanted, bus));
    let prepared = prepared.transpose()?;
    if prepared.is_none() && to.is_none() {
        return Err(BrokerError::NoDestination.into());
    }
    let lease = Lease::of_messages(bus.adapter()?);
    let (rate, found) = search(&lease, wanted.active, bus, terminal)?;
    let is_open = bus.options.sensor.target()?.is_none();
    let every = millis(wanted.every);
    let earlier = prepared.as_ref().map(|own| own.topics.makers(&own.known));
    let earlier = earlier.unwrap_or_default();
    let fleet = Fleet::new(lease, (rate, found), earlier, is_open, every, terminal)?;
    let roll = to.map(|to| Roll::new(to, &fleet, wanted.axis.as_deref()));
    let roll = roll.transpose()?;
    let mqtt = prepared.map(|own| -> Result<Mqtt, Error> {
        let url = own.connection.address.to_string();
        let broker = Broker::start(own.connection, own.queue)?;
        Ok(Mqtt::new(broker, url, own.topics, own.buffer, own.known))
    });
    let mqtt = mqtt.transpose()?;
    run(fleet, Outputs { mqtt, roll }, time, terminal)
}

/// What a connection with a broker needs.
struct Prepared {
    connection: Wanted,
    topics: Topics,
    queue: Queue,
    buffer: PathBuf,
    known: Known,
}

/// Checks what a connection with a broker needs.
fn prepare(url: &str, wanted: &Bridge, bus: &Bus) -> Result<Prepared, Error> {
    let address = Address::parse(url)?;
    let port = bus.options.port.as_deref().unwrap_or_default();
    let name = wanted.bus.clone().unwrap_or_else(|| bus_of(port));
    let topics = Topics::new(&wanted.site, &name, &wanted.discovery)?;
    let files = Files {
        ca: wanted.ca.as_deref(),
        own: wanted.certificate.as_deref().zip(wanted.key.as_deref()),
    };
    let credentials = wanted.credentials.as_deref().map(Credentials::read);
    let connection = Wanted {
        transport: transport(&address, files)?,
        credentials: credentials.transpose()?,
        client: topics.client(),
        availability: topics.bridge(),
        address,
    };
    let usual = || {
        let folder = folder(bus.options.config.as_deref());
        folder.map(|folder| folder.join("bridge").join(topics.client()))
    };
    let buffer = wanted.buffer.clone().or_else(usual);
    let buffer = buffer.ok_or(BrokerError::NoFolder)?;
    let queue = Queue::open(&buffer, u64::from(wanted.buffer_size) << 20)?;
    let known = Known::open(&buffer)?;
    Ok(Prepared {
        connection,
        topics,
        queue,
        buffer,
        known,
    })
}

/// The sensor at the address of the options, or all sensors on the bus; and the bit rate.
fn search(
    lease: &Lease,
    is_active: bool,
    bus: &Bus,
    terminal: &mut Terminal,
) -> Result<(Option<BitRate>, Vec<Found>), Error> {
    if bus.options.sensor.target()?.is_some() {
        let wanted = bus.wanted(terminal)?;
        let (link, found) = connect::find(Box::new(lease.clone()), &wanted, terminal)?;
        return Ok((link.rate(), vec![found]));
    }
    let options = scan::Options {
        rate: bus.options.rate,
        active: is_active || Name::Ask.is_in(&bus.options.yes),
        ..scan::Options::default()
    };
    let labels = bus.labels(terminal);
    let rows = scan::run(Box::new(lease.clone()), options, labels, terminal)?;
    for row in rows.heard() {
        terminal.note(&Note::OnlyHeard(row.text(rows.rate)));
    }
    Ok((
        rows.rate.or(bus.options.rate),
        rows.found().cloned().collect(),
    ))
}
