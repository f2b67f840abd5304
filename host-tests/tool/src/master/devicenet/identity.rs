//! What a sensor reports about itself.

use super::connection::IDENTITY;
use crate::error::{Error, What};
use crate::master::devicenet::explicit::{Response, Slave};
use crate::ops::identity::{Values, numbers, texts};
use crate::session::Session;
use descriptors::unit::Value;
use plumbline::devicenet::service;

/// The number of times a sensor is asked the same.
const TRIES: u8 = 3;

/// The attributes of the identity object.
pub(super) fn read(session: &mut Session, slave: Slave) -> Result<Values, Error> {
    let mut get = |attribute: u8| {
        let mut response = Response::Silent;
        for _ in 0..TRIES {
            response = slave.request_in(session, service::GET, IDENTITY, &[attribute])?;
            if response != Response::Silent {
                break;
            }
        }
        match response {
            Response::Refused(..) => Ok(None),
            response => response.must(slave.mac, What::Identity).map(Some),
        }
    };
    let mut values = numbers([
        ("vendor", get(1)?),
        ("device-type", get(2)?),
        ("product-code", get(3)?),
        ("serial", get(6)?),
    ]);
    if let Some(&[major, minor]) = get(4)?.as_deref() {
        values.push(("revision", Value::Text(format!("{major}.{minor}"))));
    }
    // The first byte is the length.
    let name = get(7)?.and_then(|name| name.get(1..).map(<[u8]>::to_vec));
    values.extend(texts([("name", name)]));
    Ok(values)
}
