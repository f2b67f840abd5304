//! What a sensor reports about itself.

use crate::error::Error;
use crate::master::j1939::groups::{self as j1939, Answer};
use crate::ops::identity::{Values, texts};
use crate::session::Session;
use descriptors::unit::Value;
use plumbline::j1939::identifier::{COMPONENT_IDENTIFICATION, SOFTWARE_IDENTIFICATION};

/// The number of times a sensor is asked the same.
const TRIES: u8 = 3;

/// Only standard requests: the objects of another maker's sensor are not in the proprietary group.
pub(super) fn read(session: &mut Session, address: u8) -> Result<Values, Error> {
    let mut group = |pgn| {
        for _ in 0..TRIES {
            match j1939::get(&mut session.link, address, pgn)? {
                Answer::Data(data) => return Ok(Some(data)),
                Answer::Refused => break,
                Answer::Silent => {}
            }
        }
        Ok::<_, Error>(None)
    };
    let field = |data: &[u8], place: usize| {
        let field = data.split(|byte| *byte == b'*').nth(place);
        field.map(<[u8]>::to_vec)
    };
    let component = group(COMPONENT_IDENTIFICATION)?.unwrap_or_default();
    let software = group(SOFTWARE_IDENTIFICATION)?.unwrap_or_default();
    let serial = field(&component, 2).and_then(|text| String::from_utf8(text).ok());
    let serial = serial.and_then(|text| text.trim().parse().ok());
    let mut values: Values = serial
        .map(|serial| ("serial", Value::Number(serial)))
        .into_iter()
        .collect();
    // The first byte of the software identification is a count.
    let version = software.get(1..).and_then(|data| field(data, 0));
    values.extend(texts([
        ("name", field(&component, 1)),
        ("software-version", version),
    ]));
    Ok(values)
}
