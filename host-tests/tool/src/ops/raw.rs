//! `raw`: one request of the protocol, as hexadecimal bytes.

use super::Report;
use crate::client::devicenet::Path;
use crate::client::sdo::{Answer, reason};
use crate::client::{Link, fsc, j1939, refusal};
use crate::error::Error;
use crate::master::{Ca, Target};
use plumbline::canopen::Abort;
use plumbline::fsc::table::{Function, Operation};
use plumbline::model::catalog::{PRODUCTS, Protocol};

/// The abort codes of a write with the wrong number of bytes.
const LENGTHS: [u32; 3] = [
    Abort::Length as u32,
    Abort::TooLong as u32,
    Abort::TooShort as u32,
];

/// Sends one request to the sensor at this address.
///
/// # Errors
/// The request is not valid, the sensor refuses, nobody answers, or the adapter fails.
pub(crate) fn send(link: &mut Link, target: Target, request: &str) -> Result<Report, Error> {
    let answer = answered(link, target, request)?;
    Ok(Report::Raw {
        request: request.to_owned(),
        answer: joined(&answer),
    })
}

fn answered(link: &mut Link, target: Target, request: &str) -> Result<Vec<u8>, Error> {
    match target {
        Target::Fsc(sensor) => {
            let bytes = bytes(request)?;
            let (&code, data) = bytes.split_first().ok_or_else(|| bad(request))?;
            let reply = match data {
                [] if only_reads(code) => fsc::must(link, sensor, code, fsc::SAVED)?,
                _ => fsc::once(link, sensor, code, data, fsc::SAVED)?,
            };
            if changes(code, data) && reply.status & errors() != 0 {
                return Err(refused(request, &reply));
            }
            Ok([&[code, reply.status], &reply.data[..]].concat())
        }
        Target::J1939(Ca(address)) if !request.contains(':') => group(link, address, request),
        Target::Canopen(_) | Target::J1939(_) => {
            let server = target.server().ok_or_else(|| bad(request))?.patient();
            let (address, data) = match request.split_once('=') {
                Some((address, data)) => (address, Some(bytes(data)?)),
                None => (request, None),
            };
            let (index, sub) = address.split_once(':').unwrap_or((address, "0"));
            let index = u16::from_str_radix(index.trim(), 16).map_err(|_| bad(request))?;
            let sub = u8::from_str_radix(sub.trim(), 16).map_err(|_| bad(request))?;
            let what = format!("{index:04X}h:{sub:02X}");
            match data {
                Some(data) => {
                    let answer = server.write(link, index, sub, &data)?;
                    if let Answer::Aborted(code) = answer
                        && LENGTHS.contains(&code)
                        && let Answer::Done(own) = server.read(link, index, sub)?
                    {
                        return Err(wrong_length(&what, code, data, own.len()));
                    }
                    answer.must(server, &what)?;
                    Ok(Vec::new())
                }
                None => server.read(link, index, sub)?.must(server, &what),
            }
        }
        Target::Devicenet(slave) => {
            let bytes = bytes(request)?;
            let [service, class, instance, ref data @ ..] = bytes[..] else {
                return Err(bad(request));
            };
            slave.allocate(link)?;
            let path = Path { class, instance };
            let response = slave.explicit(link, service, path, data);
            link.end();
            slave.release(link)?;
            response?.must(slave.mac, "the request")
        }
    }
}

/// The bits of the status that tell a refusal, which all GEMAC sensors have at the same places.
fn errors() -> u8 {
    let fsc = PRODUCTS
        .iter()
        .filter_map(|product| match &product.protocol {
            Protocol::Fsc(tables) => Some(fsc::errors(tables)),
            _ => None,
        });
    fsc.reduce(|all, own| all & own).unwrap_or(0)
}

/// A GEMAC sensor has refused a request. The bits stay until the status is read.
fn refused(request: &str, reply: &fsc::Reply) -> Error {
    let message = format!(
        "the sensor refused {request}, or an earlier request: its answer has the status {:02X}h. {}; `plumbline raw 02` reads and clears the status",
        reply.status,
        refusal::LIST
    );
    Error::refused("refused", message)
}

/// The sensor has refused the number of bytes.
fn wrong_length(what: &str, code: u32, mut data: Vec<u8>, length: usize) -> Error {
    data.resize(length, 0);
    let message = format!(
        "the sensor refused {what}: {} ({code:08X}h). The object has {length} bytes: write all bytes of the object, for example {}",
        reason(code),
        joined(&data)
    );
    Error::refused("refused", message)
}

fn joined(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

/// Whether a request writes. A read of the status has the bits of earlier requests.
fn changes(code: u8, data: &[u8]) -> bool {
    let is_status = |own: &Function| own.code == code && own.operation == Operation::ReadStatus;
    let reads_status = || {
        PRODUCTS.iter().any(|product| match &product.protocol {
            Protocol::Fsc(tables) => tables.functions.iter().any(is_status),
            _ => false,
        })
    };
    !data.is_empty() || !(only_reads(code) || reads_status())
}

/// Whether a code without data changes nothing in any product, so that it can be repeated.
fn only_reads(code: u8) -> bool {
    let tables = || {
        PRODUCTS
            .iter()
            .filter_map(|product| match &product.protocol {
                Protocol::Fsc(tables) => Some(tables),
                _ => None,
            })
    };
    let functions = || tables().flat_map(|tables| tables.functions);
    let access = || tables().flat_map(|tables| tables.access);
    let mut operations = functions().filter(|own| own.code == code);
    operations.all(|own| matches!(own.operation, Operation::Read | Operation::Inclination))
        && !access().any(|own| own.write == code)
        && (access().any(|own| own.read == code) || functions().any(|own| own.code == code))
}

/// Requests a group of a J1939 node.
fn group(link: &mut Link, address: u8, request: &str) -> Result<Vec<u8>, Error> {
    const HIGHEST: u32 = 0x3_FFFF;
    let pgn = u32::from_str_radix(request.trim(), 16).map_err(|_| bad(request))?;
    if pgn > HIGHEST {
        return Err(bad(request));
    }
    match j1939::get(link, address, pgn)? {
        j1939::Answer::Data(data) => Ok(data),
        j1939::Answer::Refused => Err(Error::refused(
            "refused",
            format!(
                "the node does not have the group {pgn:05X}h, or cannot send it now: check the number, or repeat"
            ),
        )),
        j1939::Answer::Silent => Err(Error::silent(
            "no-answer",
            format!(
                "the J1939 address {address} does not answer: `plumbline scan` finds the sensor"
            ),
        )),
    }
}

/// Hexadecimal bytes, with or without spaces.
fn bytes(text: &str) -> Result<Vec<u8>, Error> {
    let digits: Vec<u8> = text
        .bytes()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    if !digits.len().is_multiple_of(2) || !digits.iter().all(u8::is_ascii_hexdigit) {
        return Err(bad(text));
    }
    let value = |digit: u8| char::from(digit).to_digit(16).unwrap_or(0) as u8;
    Ok(digits
        .chunks(2)
        .map(|pair| value(pair[0]) << 4 | value(pair[1]))
        .collect())
}

fn bad(request: &str) -> Error {
    let message = format!(
        "{request:?} is not a valid request: use bytes like 0300 (GEMAC), INDEX:SUB like 1018:1 or 6000:0=0A00 (CANopen), 0E650172 (DeviceNet), FEEB (J1939)"
    );
    Error::usage("bad-request", message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_that_set_the_zero_point_or_clear_the_status_are_not_repeated() {
        for code in [0x03, 0x10, 0x18] {
            assert!(only_reads(code), "{code:02X}h");
        }
        for code in [0x02, 0x20, 0x28, 0x29, 0x50, 0x51, 0x52, 0xEE, 0xFF] {
            assert!(!only_reads(code), "{code:02X}h");
        }
    }
}
