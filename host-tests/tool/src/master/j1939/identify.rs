//! Which product answers at a J1939 address. Only standard requests: parameters are in a proprietary group, which can be a command to
//! another device.

use super::tables;
use crate::error::Error;
use crate::identify::{Found, TRIES, text_of};
use crate::link::Link;
use crate::master::j1939::groups::{Answer, get, name};
use crate::master::{Ca, Target};
use plumbline::j1939::identifier::{COMPONENT_IDENTIFICATION, Pgn, SOFTWARE_IDENTIFICATION};
use plumbline::j1939::name::Name;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::time::Duration;

/// The node at an address, by its claim and its component identification (make, model, serial number, unit number); None if nobody
/// answers.
pub(super) fn ask(link: &mut Link, address: u8, time: Duration) -> Result<Option<Found>, Error> {
    let Some(own) = name(link, address, time)? else {
        return Ok(None);
    };
    let component = group(link, address, COMPONENT_IDENTIFICATION)?;
    let component = component.as_deref().and_then(text_of);
    let fields: Vec<&str> = component
        .as_deref()
        .map_or(Vec::new(), |text| text.split('*').collect());
    let field = |place: usize| fields.get(place).copied().filter(|text| !text.is_empty());
    let products: Vec<&Product> = PRODUCTS
        .iter()
        .filter(|product| {
            let mut articles = product.articles();
            let is_model = articles.any(|article| field(1).is_some_and(|model| article.is(model)));
            tables(product).is_some() && is_model
        })
        .collect();
    let article = field(1).map_or_else(|| shown(own), str::to_owned);
    Ok(Some(Found {
        article: Some(article),
        serial: field(2).and_then(|text| text.parse().ok()),
        firmware: match products.is_empty() {
            true => None,
            false => software(link, address)?,
        },
        products,
        ..Found::at(Target::J1939(Ca(address)))
    }))
}

/// The first software identification: a count, then texts that end with an asterisk.
fn software(link: &mut Link, address: u8) -> Result<Option<String>, Error> {
    let Some(bytes) = group(link, address, SOFTWARE_IDENTIFICATION)? else {
        return Ok(None);
    };
    let text = bytes.get(1..).and_then(text_of);
    let first = text.as_deref().and_then(|text| text.split('*').next());
    Ok(first.map(str::to_owned))
}

/// The data of a group, with repetitions.
fn group(link: &mut Link, address: u8, pgn: Pgn) -> Result<Option<Vec<u8>>, Error> {
    for _ in 0..TRIES {
        match get(link, address, pgn)? {
            Answer::Data(data) => return Ok(Some(data)),
            Answer::Refused => break,
            Answer::Silent => {}
        }
    }
    Ok(None)
}

/// What a NAME tells of its maker.
fn shown(Name(name): Name) -> String {
    let (manufacturer, function) = (name >> 21 & 0x7FF, name >> 40 & 0xFF);
    format!("manufacturer {manufacturer}, function {function}")
}
