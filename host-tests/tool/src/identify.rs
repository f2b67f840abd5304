//! Which product answers at an address: its article, serial number and firmware, and the products of the catalogue that fit.

use crate::client::Link;
use crate::client::devicenet::{Path, Response, Slave};
use crate::client::fsc::{self, Sensor};
use crate::client::sdo::{Answer, Server};
use crate::connect;
use crate::error::{Error, Kind};
use crate::known::meant;
use crate::master::{Ca, Node, Target};
use crate::session::Session;
use plumbline::can::{BitRate, Frame};
use plumbline::canopen::dictionary::Target as ObjectTarget;
use plumbline::fsc::Version;
use plumbline::model::catalog::{PRODUCTS, Product, Protocol, find};
use plumbline::param::number;
use plumbline::time::{Duration, millis};

mod found;
mod j1939;

pub use found::{About, Found, Identity};

/// How long an answer may take, in addition to the time on the bus, at an address that perhaps no node has.
pub const QUICK: Duration = millis(30);

/// The same at an address that was heard or given.
pub const PATIENT: Duration = millis(100);

/// The number of times an identified sensor is asked the same.
const TRIES: u8 = 3;

/// The bits of the frames until a sensor that detects the bit rate has answered: the adapter repeats the first frame
/// until it is error passive, then come two boot-up messages.
const DETECTION: u32 = 3500;

/// The bits of a question and its answer.
const EXCHANGE: u32 = 300;

/// The wait for the answer to a question at the bit rate of a link; `latency` is the latency of the adapter.
pub fn question(link: &Link, latency: Duration) -> Duration {
    let rate = link.rate().map_or(250_000, BitRate::bits_per_second);
    // A sensor that detects the bit rate takes the first rate at which a node sends.
    let is_first = link.sent().iter().all(|(rate, _)| *rate == link.rate());
    let bits = if is_first { DETECTION } else { EXCHANGE };
    latency + millis(bits * 1000 / rate)
}

/// The time of a question and an answer at the bit rate of a link.
fn exchange(link: &Link, latency: Duration) -> Duration {
    let rate = link.rate().map_or(250_000, BitRate::bits_per_second);
    latency + millis(EXCHANGE * 1000 / rate)
}

/// The product with this name.
///
/// # Errors
/// There is none.
pub fn product(name: &str) -> Result<&'static Product, Error> {
    find(&name.to_lowercase()).ok_or_else(|| {
        let names: Vec<&str> = PRODUCTS.iter().map(|product| product.name).collect();
        let message = format!(
            "there is no product {name:?}; the products are {}{}",
            names.join(", "),
            meant(name, names.iter().copied())
        );
        Error::usage("unknown-product", message)
    })
}

/// Asks at an address; None if nobody answers. Only reads, which change nothing. A connection of DeviceNet is allocated and released
/// again. `latency` is [`QUICK`] or [`PATIENT`].
///
/// # Errors
/// The adapter fails.
pub fn ask(link: &mut Link, target: Target, latency: Duration) -> Result<Option<Found>, Error> {
    let time = question(link, latency);
    match target {
        Target::Fsc(sensor) => ask_fsc(link, sensor, time),
        Target::Canopen(Node(node)) => ask_canopen(link, node, time),
        Target::Devicenet(slave) => ask_devicenet(link, slave, time),
        Target::J1939(Ca(address)) => j1939::ask(link, address, time),
    }
}

/// Refuses another sensor at the address of a session: the serial number differs, or what it tells if it has none.
///
/// # Errors
/// Another sensor answers, nobody answers, or the adapter fails.
pub fn same(session: &mut Session, found: &Found) -> Result<(), Error> {
    let own = found.identity().serial();
    let target = session.target;
    if target.is_connected(session)? {
        return Ok(());
    }
    if own.is_some() {
        match session.serial() {
            Err(failure) if failure.kind != Kind::Refused => return Err(failure),
            Ok(serial) if serial == own => return Ok(()),
            _ => {}
        }
    }
    is_same(session, found)
}

/// The same with all that the sensor tells.
///
/// # Errors
/// See [`same`].
pub fn is_same(session: &mut Session, found: &Found) -> Result<(), Error> {
    session.release()?;
    let rate = session.link.rate();
    match ask(&mut session.link, session.target, PATIENT)? {
        None => Err(connect::silent(&[session.target], &[rate])),
        Some(other) if other.identity() != found.identity() => {
            Err(connect::other(&other.line(rate)))
        }
        Some(_) => Ok(()),
    }
}

fn ask_fsc(link: &mut Link, sensor: Sensor, time: Duration) -> Result<Option<Found>, Error> {
    const PRODUCT: u8 = 0x03;
    let request = Frame::of(sensor.request, [PRODUCT, 0, 0, 0, 0, 0, 0, 0], 1);
    // Another device can send a shorter frame that looks like a reply.
    let judge = |frame: &Frame| match frame.bytes() {
        [PRODUCT, status, data @ ..] if data.len() == 6 && frame.can_id() != sensor.request => {
            Some(fsc::Reply {
                id: frame.can_id(),
                status: *status,
                data: data.to_vec(),
            })
        }
        _ => None,
    };
    let Some(reply) = link.ask(&request, time, judge)? else {
        return Ok(None);
    };
    let sensor = Sensor {
        reply: Some(reply.id),
        ..sensor
    };
    let digits = number(&reply.data[..4]);
    let told = serials(link, sensor)?;
    let first = told.first().copied();
    let (serial, version) = (first.map(|own| own.0), first.map(|own| own.1));
    let twins = match told.len() {
        0 | 1 => Vec::new(),
        _ => confirmed(link, sensor, &told[1..])?,
    };
    let mut article = Some(digits.to_string());
    let mut products = Vec::new();
    for product in PRODUCTS {
        let Protocol::Fsc(tables) = &product.protocol else {
            continue;
        };
        let mut articles = tables.articles.iter();
        let same = |article: &&plumbline::fsc::Article| {
            article.number.digits() == digits && is_of_generation(article.version, version)
        };
        if let Some(own) = articles.find(same) {
            article = Some(own.number.text().to_owned());
            products.push(product);
        }
    }
    Ok(Some(Found {
        target: Target::Fsc(sensor),
        products,
        article,
        serial,
        firmware: version.map(crate::number::version_text),
        label: None,
        is_owned: false,
        twins,
    }))
}

/// The different serial numbers, with the software versions, that come from the Reply-Parameter-ID of a sensor: first its own one. Another
/// sensor with the same identifiers has another number, and its reply comes directly behind.
fn serials(link: &mut Link, sensor: Sensor) -> Result<Vec<(u32, u16)>, Error> {
    const SERIAL: u8 = 0x04;
    let told = |data: &[u8]| match data.len() {
        6 => Some((number(&data[..4]), number(&data[4..]) as u16)),
        _ => None,
    };
    let first = again(link, sensor, SERIAL)?;
    let Some(first) = first.and_then(|reply| told(&reply.data)) else {
        return Ok(Vec::new());
    };
    let mut all = vec![first];
    link.wait_for(exchange(link, QUICK), |frame| {
        let other = fsc::reply(frame, sensor, SERIAL).and_then(|reply| told(&reply.data));
        if let Some(other) = other
            && all.iter().all(|own| own.0 != other.0)
        {
            all.push(other);
        }
        None::<()>
    })?;
    Ok(all)
}

/// The serial numbers that come again when the sensor is asked again. The other numbers are data of another device. Two replies can destroy
/// each other, so the sensor is asked several times.
fn confirmed(link: &mut Link, sensor: Sensor, others: &[(u32, u16)]) -> Result<Vec<u32>, Error> {
    let mut twins: Vec<u32> = Vec::new();
    for _ in 0..TRIES {
        for (serial, _) in serials(link, sensor)? {
            let is_other = others.iter().any(|own| own.0 == serial);
            if is_other && !twins.contains(&serial) {
                twins.push(serial);
            }
        }
        if twins.len() == others.len() {
            break;
        }
    }
    Ok(twins)
}

/// Asks a sensor that has answered, with repetitions.
fn again(link: &mut Link, sensor: Sensor, code: u8) -> Result<Option<fsc::Reply>, Error> {
    for _ in 0..TRIES {
        let reply = fsc::ask(link, sensor, code, &[], fsc::ANSWER)?;
        if reply.is_some() {
            return Ok(reply);
        }
    }
    Ok(None)
}

/// Whether a software version is of the same generation as that of an article: types of 2021 have digits, older ones a number.
fn is_of_generation(own: Version, version: Option<u16>) -> bool {
    let Some(version) = version else {
        return true;
    };
    match own {
        Version::Digits { .. } => version >> 8 != 0,
        Version::Number(_) => version >> 8 == 0,
    }
}

fn ask_canopen(link: &mut Link, node: u8, time: Duration) -> Result<Option<Found>, Error> {
    const IDENTITY: u16 = 0x1018;
    const VERSION: u16 = 0x100A;
    let question = Server {
        time,
        ..Server::of(node)
    };
    if question.read(link, 0x1000, 0)? == Answer::Silent {
        return Ok(None);
    }
    let mut read = |index, sub| {
        let mut answer = Answer::Silent;
        for _ in 0..TRIES {
            answer = Server::of(node).read(link, index, sub)?;
            if answer != Answer::Silent {
                break;
            }
        }
        Ok::<_, Error>(answer)
    };
    let mut identity = [None; 5];
    for sub in [1, 2, 4] {
        if let Answer::Done(bytes) = read(IDENTITY, sub)?
            && bytes.len() == 4
        {
            identity[usize::from(sub)] = Some(number(&bytes));
        }
    }
    let firmware = match read(VERSION, 0)? {
        Answer::Done(text) => text_of(&text),
        _ => None,
    };
    let constant = |tables: &plumbline::model::listing::canopen::Tables, sub: u8| {
        let mut objects = tables.objects.iter();
        let object = objects.find(|object| (object.index, object.sub) == (IDENTITY, sub))?;
        match object.target {
            ObjectTarget::Constant(number) => Some(number),
            _ => None,
        }
    };
    let products: Vec<&Product> = PRODUCTS
        .iter()
        .filter(|product| match &product.protocol {
            Protocol::Canopen(tables) => [1, 2].into_iter().all(|sub| {
                let own = constant(tables, sub);
                own.is_some() && own == identity[usize::from(sub)]
            }),
            _ => false,
        })
        .collect();
    let mut articles = products
        .first()
        .into_iter()
        .flat_map(|product| product.articles());
    Ok(Some(Found {
        target: Target::Canopen(Node(node)),
        article: articles
            .next()
            .map(|article| article.number.to_owned())
            .or_else(|| {
                let (vendor, code) = (identity[1]?, identity[2]?);
                Some(format!("vendor {vendor:X}h, product code {code:X}h"))
            }),
        products,
        serial: identity[4],
        firmware,
        label: None,
        is_owned: false,
        twins: Vec::new(),
    }))
}

/// A slave of another master.
pub fn owned(slave: Slave) -> Found {
    Found {
        target: Target::Devicenet(slave),
        products: Vec::new(),
        article: None,
        serial: None,
        firmware: None,
        label: None,
        is_owned: true,
        twins: Vec::new(),
    }
}

fn ask_devicenet(link: &mut Link, slave: Slave, time: Duration) -> Result<Option<Found>, Error> {
    let identity = Path {
        class: 1,
        instance: 1,
    };
    match slave.allocate_within(link, time) {
        Ok(()) => {}
        Err(failure) if failure.code == "no-answer" => return Ok(None),
        Err(failure) if failure.code == "owned" => return Ok(Some(owned(slave))),
        Err(failure) => return Err(failure),
    }
    let mut attribute = |number: u8| -> Result<Option<Vec<u8>>, Error> {
        for _ in 0..TRIES {
            match slave.get(link, identity, number)? {
                Response::Done(data) => return Ok(Some(data)),
                Response::Refused(..) => break,
                Response::Silent => {}
            }
        }
        Ok(None)
    };
    let read = [1, 3, 4, 6].map(&mut attribute);
    slave.release(link)?;
    let [vendor, code, revision, serial] = read;
    let (vendor, code, revision) = (vendor?, code?, revision?);
    let serial = serial?.filter(|data| data.len() == 4);
    let word = |data: &Option<Vec<u8>>| data.as_deref().filter(|data| data.len() == 2).map(number);
    let (vendor, code) = (word(&vendor), word(&code));
    let products: Vec<&Product> = PRODUCTS
        .iter()
        .filter(|product| match &product.protocol {
            Protocol::Devicenet(tables) => {
                Some(tables.identity.vendor.into()) == vendor
                    && Some(tables.identity.product_code.into()) == code
            }
            _ => false,
        })
        .collect();
    let mut articles = products
        .first()
        .into_iter()
        .flat_map(|product| product.articles());
    let firmware = revision.filter(|data| data.len() == 2);
    Ok(Some(Found {
        target: Target::Devicenet(slave),
        article: articles
            .next()
            .map(|article| article.number.to_owned())
            .or_else(|| Some(format!("vendor {}, product code {}", vendor?, code?))),
        products,
        serial: serial.as_deref().map(number),
        firmware: firmware.map(|data| format!("{}.{}", data[0], data[1])),
        label: None,
        is_owned: false,
        twins: Vec::new(),
    }))
}

/// A text of the sensor, if it is printable.
fn text_of(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?.trim_end_matches('\0');
    let printable = text.chars().all(|letter| !letter.is_control());
    printable.then(|| text.to_owned())
}
