//! `raw`: one request of the protocol, as hexadecimal bytes.

use super::Report;
use crate::error::{Error, RequestError};
use crate::link::Link;
use crate::master::Target;

/// Sends one request to the sensor at this address.
///
/// # Errors
/// The request is not valid, the sensor refuses, nobody answers, or the adapter fails.
pub(crate) fn send(link: &mut Link, target: Target, request: &str) -> Result<Report, Error> {
    let answer = target.raw(link, request)?;
    Ok(Report::Raw {
        request: request.to_owned(),
        answer: joined(&answer),
    })
}

/// Bytes as hexadecimal digits.
pub(crate) fn joined(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

/// Hexadecimal bytes, with or without spaces.
pub(crate) fn bytes(text: &str) -> Result<Vec<u8>, Error> {
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

/// The request is not valid.
pub(crate) fn bad(request: &str) -> Error {
    RequestError::BadRequest(request.to_owned()).into()
}
