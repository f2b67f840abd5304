//! One request to an SDO server: INDEX:SUB reads, INDEX:SUB=DATA writes, hexadecimal.

use crate::error::{Error, Refusal, What};
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server, reason};
use crate::ops::raw::{bad, bytes, joined};
use plumbline::canopen::Abort;

/// The abort codes of a write with the wrong number of bytes.
const LENGTHS: [u32; 3] = [
    Abort::Length as u32,
    Abort::TooLong as u32,
    Abort::TooShort as u32,
];

/// Sends a request and returns the bytes of its answer.
pub(in crate::master) fn send(
    link: &mut Link,
    server: Server,
    request: &str,
) -> Result<Vec<u8>, Error> {
    let server = server.patient();
    let (address, data) = match request.split_once('=') {
        Some((address, data)) => (address, Some(bytes(data)?)),
        None => (request, None),
    };
    let (index, sub) = address.split_once(':').unwrap_or((address, "0"));
    let index = u16::from_str_radix(index.trim(), 16).map_err(|_| bad(request))?;
    let sub = u8::from_str_radix(sub.trim(), 16).map_err(|_| bad(request))?;
    let what = What::Name(format!("{index:04X}h:{sub:02X}"));
    match data {
        Some(data) => {
            let answer = server.write(link, index, sub, &data)?;
            if let Answer::Aborted(code) = answer
                && LENGTHS.contains(&code)
                && let Answer::Done(own) = server.read(link, index, sub)?
            {
                return Err(wrong_length(what, code, data, own.len()));
            }
            answer.must(server, what)?;
            Ok(Vec::new())
        }
        None => server.read(link, index, sub)?.must(server, what),
    }
}

/// The sensor has refused the number of bytes.
fn wrong_length(what: What, code: u32, mut data: Vec<u8>, length: usize) -> Error {
    data.resize(length, 0);
    Refusal::Length(what, reason(code), code, length.into(), joined(&data)).into()
}
