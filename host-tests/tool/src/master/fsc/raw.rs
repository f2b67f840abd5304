//! One request, as hexadecimal bytes: the code and its data.

use super::tables;
use crate::error::{Error, Next, Refusal};
use crate::link::Link;
use crate::master::fsc::request::{self as fsc, Sensor};
use crate::ops::raw::{bad, bytes};
use plumbline::fsc::table::{Function, Operation};
use plumbline::model::catalog::PRODUCTS;
use plumbline::model::listing::fsc::Tables;

/// Sends a request and returns the bytes of its reply.
pub(super) fn send(link: &mut Link, sensor: Sensor, request: &str) -> Result<Vec<u8>, Error> {
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

/// The tables of all products.
fn all() -> impl Iterator<Item = &'static Tables> {
    PRODUCTS.iter().filter_map(|product| tables(product))
}

/// The bits of the status that tell a refusal, which all GEMAC sensors have at the same places.
fn errors() -> u8 {
    let errors = all().map(fsc::errors);
    errors.reduce(|all, own| all & own).unwrap_or(0)
}

/// The sensor has refused a request. The bits stay until the status is read.
fn refused(request: &str, reply: &fsc::Reply) -> Error {
    Refusal::Status(request.to_owned(), reply.status, Next::List).into()
}

/// Whether a request writes. A read of the status has the bits of earlier requests.
fn changes(code: u8, data: &[u8]) -> bool {
    let is_status = |own: &Function| own.code == code && own.operation == Operation::ReadStatus;
    let reads_status = all().any(|tables| tables.functions.iter().any(is_status));
    !data.is_empty() || !(only_reads(code) || reads_status)
}

/// Whether a code without data changes nothing in any product, so that it can be repeated.
fn only_reads(code: u8) -> bool {
    let functions = || all().flat_map(|tables| tables.functions);
    let access = || all().flat_map(|tables| tables.access);
    let mut operations = functions().filter(|own| own.code == code);
    operations.all(|own| matches!(own.operation, Operation::Read | Operation::Inclination))
        && !access().any(|own| own.write == code)
        && (access().any(|own| own.read == code) || functions().any(|own| own.code == code))
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
