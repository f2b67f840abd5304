//! Which product answers.

use super::tables;
use crate::error::Error;
use crate::identify::{Found, QUICK, TRIES, exchange};
use crate::link::Link;
use crate::master::Target;
use crate::master::fsc::request::{self as fsc, Sensor};
use crate::number::version_text;
use plumbline::can::Frame;
use plumbline::fsc::{Article, Version};
use plumbline::model::catalog::PRODUCTS;
use plumbline::param::number;
use plumbline::time::Duration;

/// The sensor by its article, serial number and software version. Another device can send a frame that looks like a reply before the sensor
/// answers, so a sender that tells neither an article of the catalogue nor a serial number is left out, and the sensor is asked again.
pub(super) fn ask(link: &mut Link, sensor: Sensor, time: Duration) -> Result<Option<Found>, Error> {
    const PRODUCT: u8 = 0x03;
    let request = Frame::of(sensor.request, [PRODUCT, 0, 0, 0, 0, 0, 0, 0], 1);
    let mut others = vec![sensor.request];
    for _ in 0..TRIES {
        let judge = |frame: &Frame| match frame.bytes() {
            // Another device can also send a shorter frame.
            [PRODUCT, _, data @ ..] if data.len() == 6 && !others.contains(&frame.can_id()) => {
                Some((frame.can_id(), number(&data[..4])))
            }
            _ => None,
        };
        let Some((reply, digits)) = link.ask(&request, time, judge)? else {
            return Ok(None);
        };
        let sensor = Sensor {
            reply: Some(reply),
            ..sensor
        };
        let told = serials(link, sensor)?;
        if !told.is_empty() || is_article(digits) {
            return found(link, sensor, digits, &told).map(Some);
        }
        others.push(reply);
    }
    Ok(None)
}

/// Whether the catalogue has a sensor with this article.
fn is_article(digits: u32) -> bool {
    let mut articles = PRODUCTS.iter().filter_map(|own| tables(own));
    articles.any(|own| own.articles.iter().any(|own| own.number.digits() == digits))
}

/// The sensor with this article, and with the serial numbers that were told with the software versions.
fn found(
    link: &mut Link,
    sensor: Sensor,
    digits: u32,
    told: &[(u32, u16)],
) -> Result<Found, Error> {
    let first = told.first().copied();
    let (serial, version) = (first.map(|own| own.0), first.map(|own| own.1));
    let twins = match told.len() {
        0 | 1 => Vec::new(),
        _ => confirmed(link, sensor, &told[1..])?,
    };
    let mut article = Some(digits.to_string());
    let mut products = Vec::new();
    for product in PRODUCTS {
        let Some(tables) = tables(product) else {
            continue;
        };
        let mut articles = tables.articles.iter();
        let same = |article: &&Article| {
            article.number.digits() == digits && is_of_generation(article.version, version)
        };
        if let Some(own) = articles.find(same) {
            article = Some(own.number.text().to_owned());
            products.push(product);
        }
    }
    Ok(Found {
        products,
        article,
        serial,
        firmware: version.map(version_text),
        twins,
        ..Found::at(Target::Fsc(sensor))
    })
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
pub(super) fn is_of_generation(own: Version, version: Option<u16>) -> bool {
    let Some(version) = version else {
        return true;
    };
    match own {
        Version::Digits { .. } => version >> 8 != 0,
        Version::Number(_) => version >> 8 == 0,
    }
}
