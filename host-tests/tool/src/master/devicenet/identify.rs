//! Which product answers.

use super::connection::IDENTITY;
use super::tables;
use crate::error::{Error, SensorError};
use crate::identify::{Found, TRIES};
use crate::link::Link;
use crate::master::Target;
use crate::master::devicenet::explicit::{Response, Slave};
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::number;
use plumbline::time::Duration;

/// A slave of another master.
pub(super) fn owned(slave: Slave) -> Found {
    Found {
        is_owned: true,
        ..Found::at(Target::Devicenet(slave))
    }
}

/// The slave by its identity object. The connection is allocated and released again.
pub(super) fn ask(link: &mut Link, slave: Slave, time: Duration) -> Result<Option<Found>, Error> {
    match slave.allocate_within(link, time) {
        Ok(()) => {}
        Err(Error::Silent(_)) => return Ok(None),
        Err(Error::Sensor(SensorError::Owned(_))) => return Ok(Some(owned(slave))),
        Err(failure) => return Err(failure),
    }
    let mut attribute = |number: u8| -> Result<Option<Vec<u8>>, Error> {
        for _ in 0..TRIES {
            match slave.get(link, IDENTITY, number)? {
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
        .filter(|product| {
            tables(product).is_some_and(|tables| {
                Some(tables.identity.vendor.into()) == vendor
                    && Some(tables.identity.product_code.into()) == code
            })
        })
        .collect();
    let mut articles = products
        .first()
        .into_iter()
        .flat_map(|product| product.articles());
    let firmware = revision.filter(|data| data.len() == 2);
    Ok(Some(Found {
        article: articles
            .next()
            .map(|article| article.number.to_owned())
            .or_else(|| Some(format!("vendor {}, product code {}", vendor?, code?))),
        products,
        serial: serial.as_deref().map(number),
        firmware: firmware.map(|data| format!("{}.{}", data[0], data[1])),
        ..Found::at(Target::Devicenet(slave))
    }))
}
