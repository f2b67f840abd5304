//! One request: a group, or an object as in CANopen.

use super::Ca;
use crate::error::{Error, Refusal, Silence};
use crate::link::Link;
use crate::master::canopen;
use crate::master::j1939::groups as j1939;
use crate::ops::raw::bad;

/// Sends a request and returns the bytes of its answer.
pub(super) fn send(link: &mut Link, ca: Ca, request: &str) -> Result<Vec<u8>, Error> {
    match request.contains(':') {
        true => canopen::raw::send(link, ca.server(), request),
        false => group(link, ca.0, request),
    }
}

/// Requests a group.
fn group(link: &mut Link, address: u8, request: &str) -> Result<Vec<u8>, Error> {
    const HIGHEST: u32 = 0x3_FFFF;
    let pgn = u32::from_str_radix(request.trim(), 16).map_err(|_| bad(request))?;
    if pgn > HIGHEST {
        return Err(bad(request));
    }
    match j1939::get(link, address, pgn)? {
        j1939::Answer::Data(data) => Ok(data),
        j1939::Answer::Refused => Err(Refusal::Group(pgn).into()),
        j1939::Answer::Silent => Err(Silence::J1939Address(address).into()),
    }
}
