//! Which product answers at an address: its article, serial number and firmware, and the products of the catalogue that fit.

use crate::client::Link;
use crate::client::devicenet::{Path, Response, Slave};
use crate::client::fsc::{self, Sensor};
use crate::client::sdo::{Answer, Server};
use crate::failure::Failure;
use crate::session::Target;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::canopen::dictionary::Target as ObjectTarget;
use plumbline::fsc::Version;
use plumbline::model::catalog::{PRODUCTS, Product, Protocol, find};
use plumbline::param::number;
use plumbline::time::{Duration, millis};
use serde_json::{Value, json};

/// The wait for the answer to a question, besides the time on the bus.
const LATENCY: Duration = millis(30);

/// The bits of the frames until a sensor that detects the bit rate has answered: the adapter repeats the first frame
/// until it is error passive, then come two boot-up messages.
const DETECTION: u32 = 3500;

/// The bits of a question and its answer.
const EXCHANGE: u32 = 300;

/// The wait for the answer to a question at the bit rate of a link.
pub fn question(link: &Link) -> Duration {
    let rate = link.rate().map_or(250_000, BitRate::bits_per_second);
    // A sensor that detects the bit rate takes the first one at which somebody sends.
    let is_first = link.sent().iter().all(|(rate, _)| *rate == link.rate());
    let bits = if is_first { DETECTION } else { EXCHANGE };
    LATENCY + millis(bits * 1000 / rate)
}

/// A sensor that has answered.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its address.
    pub target: Target,
    /// The products that it can be; empty for a foreign device.
    pub products: Vec<&'static Product>,
    /// The order number, or what is known of it.
    pub article: Option<String>,
    /// The serial number.
    pub serial: Option<u32>,
    /// The version of the firmware.
    pub firmware: Option<String>,
}

impl Found {
    /// The name of the protocol in documents.
    pub fn protocol(&self) -> &'static str {
        match self.target {
            Target::Fsc(_) => "fsc",
            Target::Canopen(_) => "canopen",
            Target::Devicenet(_) => "devicenet",
        }
    }

    /// The only product that it can be.
    pub fn product(&self) -> Option<&'static Product> {
        match self.products[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// The product for a session; `wanted` is the product of the command line.
    ///
    /// # Errors
    /// Several products fit or none does, or the wanted one has another protocol.
    pub fn decide(&self, wanted: Option<&'static Product>) -> Result<&'static Product, Failure> {
        if let Some(wanted) = wanted {
            if protocol_of(wanted) != self.protocol() {
                let message = format!(
                    "{} speaks {}, but the sensor speaks {}: give another --product",
                    wanted.name,
                    protocol_of(wanted),
                    self.protocol()
                );
                return Err(Failure::usage("wrong-product", message));
            }
            return Ok(wanted);
        }
        let names: Vec<&str> = self.products.iter().map(|product| product.name).collect();
        let article = self.article.as_deref().unwrap_or("unknown");
        match self.products[..] {
            [only] => Ok(only),
            [] => Err(Failure::usage(
                "unknown-product",
                format!(
                    "the article {article} is not in the catalogue: say what it is like with --product NAME"
                ),
            )),
            _ => Err(Failure::usage(
                "ambiguous-product",
                format!(
                    "the article {article} can be {}: choose with --product NAME",
                    names.join(" or ")
                ),
            )),
        }
    }

    /// As `scan` prints it; `rate` in kbit/s.
    pub fn json(&self, rate: Option<Value>) -> Value {
        json!({
            "rate": rate,
            "protocol": self.protocol(),
            "product": self.product().map(|product| product.name),
            "address": self.target.address(),
            "serial": self.serial,
            "article": self.article,
            "firmware": self.firmware,
        })
    }
}

/// The name of the protocol of a product in documents.
pub fn protocol_of(product: &Product) -> &'static str {
    match product.protocol {
        Protocol::Fsc(_) => "fsc",
        Protocol::Canopen(_) => "canopen",
        Protocol::Devicenet(_) => "devicenet",
    }
}

/// The product with this name.
///
/// # Errors
/// There is none.
pub fn product(name: &str) -> Result<&'static Product, Failure> {
    find(&name.to_lowercase()).ok_or_else(|| {
        let names: Vec<&str> = PRODUCTS.iter().map(|product| product.name).collect();
        let message = format!(
            "there is no product {name:?}; the products are {}",
            names.join(", ")
        );
        Failure::usage("unknown-product", message)
    })
}

/// Asks at an address; None if nobody answers. Only reads, which change nothing. A connection of DeviceNet is released again.
///
/// # Errors
/// Those of the adapter.
pub fn ask(link: &mut Link, target: Target) -> Result<Option<Found>, Failure> {
    match target {
        Target::Fsc(sensor) => ask_fsc(link, sensor),
        Target::Canopen(node) => ask_canopen(link, node),
        Target::Devicenet(slave) => ask_devicenet(link, slave),
    }
}

/// The reply to a question, or the boot-up message of a sensor that has just detected the bit rate.
enum Heard {
    Reply(fsc::Reply),
    BootUp(Sensor),
}

/// The boot-up message of a sensor with function select codes: `FF ss id id id id vv vv`. It names the Set-Parameter-ID.
pub fn boot_up(frame: &Frame) -> Option<Sensor> {
    let &[0xFF, _, a, b, c, d, _, _] = frame.bytes() else {
        return None;
    };
    let bits = u32::from_le_bytes([a, b, c, d]);
    let request = CanId::from_bits(bits);
    (request.bits() == bits && request != frame.can_id()).then(|| Sensor {
        request,
        reply: Some(frame.can_id()),
    })
}

fn ask_fsc(link: &mut Link, sensor: Sensor) -> Result<Option<Found>, Failure> {
    const PRODUCT: u8 = 0x03;
    const SERIAL: u8 = 0x04;
    let request = Frame::of(sensor.request, [PRODUCT, 0, 0, 0, 0, 0, 0, 0], 1);
    let judge = |frame: &Frame| {
        if let Some(booted) = boot_up(frame) {
            return Some(Heard::BootUp(booted));
        }
        match frame.bytes() {
            [PRODUCT, status, data @ ..] if data.len() == 6 && frame.can_id() != sensor.request => {
                Some(Heard::Reply(fsc::Reply {
                    id: frame.can_id(),
                    status: *status,
                    data: data.to_vec(),
                }))
            }
            _ => None,
        }
    };
    let (sensor, reply) = match link.ask(&request, question(link), judge)? {
        None => return Ok(None),
        Some(Heard::Reply(reply)) => (
            Sensor {
                reply: Some(reply.id),
                ..sensor
            },
            Some(reply),
        ),
        Some(Heard::BootUp(booted)) => {
            // It sends the message twice.
            link.wait_for(question(link), |frame| boot_up(frame).map(|_| ()))?;
            (booted, fsc::ask(link, booted, PRODUCT, &[], fsc::ANSWER)?)
        }
    };
    let Some(reply) = reply else {
        return Ok(None);
    };
    let digits = number(&reply.data[..4]);
    let (mut serial, mut version) = (None, None);
    if let Some(reply) = fsc::ask(link, sensor, SERIAL, &[], fsc::ANSWER)?
        && reply.data.len() == 6
    {
        serial = Some(number(&reply.data[..4]));
        version = Some(number(&reply.data[4..6]) as u16);
    }
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
    }))
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

fn ask_canopen(link: &mut Link, node: u8) -> Result<Option<Found>, Failure> {
    const IDENTITY: u16 = 0x1018;
    const VERSION: u16 = 0x100A;
    let question = Server {
        time: question(link),
        ..Server::of(node)
    };
    if question.read(link, 0x1000, 0)? == Answer::Silent {
        return Ok(None);
    }
    let server = Server::of(node);
    let mut identity = [None; 5];
    for sub in [1, 2, 4] {
        if let Answer::Done(bytes) = server.read(link, IDENTITY, sub)?
            && bytes.len() == 4
        {
            identity[usize::from(sub)] = Some(number(&bytes));
        }
    }
    let firmware = match server.read(link, VERSION, 0)? {
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
        target: Target::Canopen(node),
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
    }))
}

fn ask_devicenet(link: &mut Link, slave: Slave) -> Result<Option<Found>, Failure> {
    let identity = Path {
        class: 1,
        instance: 1,
    };
    let time = question(link);
    match slave.allocate_within(link, time) {
        Ok(()) => {}
        Err(failure) if failure.code == "no-answer" => return Ok(None),
        Err(failure) if failure.code == "owned" => {
            return Ok(Some(Found {
                target: Target::Devicenet(slave),
                products: Vec::new(),
                article: None,
                serial: None,
                firmware: None,
            }));
        }
        Err(failure) => return Err(failure),
    }
    let mut attribute = |number: u8| -> Result<Option<Vec<u8>>, Failure> {
        Ok(match slave.get(link, identity, number)? {
            Response::Done(data) => Some(data),
            _ => None,
        })
    };
    let vendor = attribute(1)?;
    let code = attribute(3)?;
    let revision = attribute(4)?;
    let serial = attribute(6)?.filter(|data| data.len() == 4);
    slave.release(link)?;
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
    }))
}

/// A text of the sensor, if it is printable.
fn text_of(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?.trim_end_matches('\0');
    let printable = text.chars().all(|letter| !letter.is_control());
    printable.then(|| text.to_owned())
}
