//! The programming key (manual 9.11): ten parameters as a text, for copying the configuration to another sensor.
//!
//! The format of the ifm key is not completely known. The key of a sensor with factory values is printed in the manual and is
//! used unchanged. All other keys have a different layout, so keys cannot be exchanged with sensors of ifm:
//!
//! ```text
//!  byte 0     1         2           4           5           6           7               9
//!       +-----+---------+-----------+-----------+-----------+-----------+---------------+-----------+
//!       | 'P' | node id | bit rate  | quadrant, | filter,   | resistor, | resolution,   | CRC-16    |
//!       | 50h | u8      | kbit/s    | heating   | definition| teach     | zero in bits  | of the    |
//!       |     |         | u16       | 4 bits    | 4 bits    | 4 bits    | 12..15, u16   | rest, u16 |
//!       +-----+---------+-----------+-----------+-----------+-----------+---------------+-----------+
//! ```
//!
//! The first of two names is in the lower bits. All numbers are little-endian. The CRC is CRC-16/IBM-3740. The eleven bytes are
//! coded in Base64 with sixteen characters.

use super::parameters::{ABSOLUTE, id};
use super::{Jn2101Product, base64};
use crate::param::{ParameterId, Parameters};
use crc::{CRC_16_IBM_3740, Crc, NoTable};

/// The programming key of a sensor with factory values.
const FACTORY: &[u8] = b"D0UfZEgRKHAI5Ag=";

const MARK: u8 = 0x50;
const SIZE: usize = 11;

const CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_IBM_3740);

/// The parameters in the programming key.
pub(super) const IDS: [ParameterId; 10] = [
    id::NODE_ID,
    id::BAUD_RATE,
    id::QUADRANT,
    id::HEATING,
    id::FILTER,
    id::DEFINITION,
    id::TERMINATION,
    id::TEACH,
    id::RESOLUTION,
    id::ZERO,
];

type Values = Parameters<Jn2101Product>;

/// The programming key of these parameters.
pub(super) fn compose(parameters: &Values) -> heapless::Vec<u8, { super::NAME }> {
    if IDS
        .iter()
        .all(|&id| parameters.get(id) == Values::factory_value(id))
    {
        return heapless::Vec::from_slice(FACTORY).unwrap_or_default();
    }
    let at = |id| parameters.get(id);
    let pair = |low, high| (at(low) | at(high) << 4) as u8;
    let [rate0, rate1] = (at(id::BAUD_RATE) as u16).to_le_bytes();
    let last = at(id::RESOLUTION) | at(id::ZERO) << 12;
    let [last0, last1] = (last as u16).to_le_bytes();
    let body = [
        MARK,
        at(id::NODE_ID) as u8,
        rate0,
        rate1,
        pair(id::QUADRANT, id::HEATING),
        pair(id::FILTER, id::DEFINITION),
        pair(id::TERMINATION, id::TEACH),
        last0,
        last1,
    ];
    let [crc0, crc1] = CRC.checksum(&body).to_le_bytes();
    let [a, b, c, d, e, f, g, h, i] = body;
    let bytes: [u8; SIZE] = [a, b, c, d, e, f, g, h, i, crc0, crc1];
    base64::encode(&bytes)
}

/// Writes the parameters of a programming key. Returns None without a change if the key is not valid or one of its values is not
/// permitted. Some tools end a text with NUL.
///
/// A key does not contain the reference frame and the zero point. It can switch teach-in and zero point off, but not on.
pub(super) fn write(text: &[u8], parameters: &mut Values) -> Option<()> {
    let text = match text {
        [key @ .., 0] if key.len() == FACTORY.len() => key,
        _ => text,
    };
    let numbers = if text == FACTORY {
        IDS.map(Values::factory_value)
    } else {
        parse(text)?
    };
    let permitted = |(id, number): (ParameterId, u32)| Values::check(id, number).is_ok();
    if !IDS.into_iter().zip(numbers).all(permitted) {
        return None;
    }
    for (id, number) in IDS.into_iter().zip(numbers) {
        if number == ABSOLUTE || !matches!(id, id::TEACH | id::ZERO) {
            parameters.set(id, number);
        }
    }
    Some(())
}

/// The numbers in a programming key of the layout above; None if it is not valid.
fn parse(text: &[u8]) -> Option<[u32; 10]> {
    let bytes: [u8; SIZE] = base64::decode(text)?;
    let (body, crc) = bytes.split_last_chunk::<2>()?;
    let &[
        mark,
        node_id,
        rate0,
        rate1,
        quadrant,
        filter,
        resistor,
        last0,
        last1,
    ] = body
    else {
        return None;
    };
    if mark != MARK || CRC.checksum(body) != u16::from_le_bytes(*crc) {
        return None;
    }
    let last = u16::from_le_bytes([last0, last1]);
    let numbers = [
        node_id.into(),
        u16::from_le_bytes([rate0, rate1]),
        (quadrant & 15).into(),
        (quadrant >> 4).into(),
        (filter & 15).into(),
        (filter >> 4).into(),
        (resistor & 15).into(),
        (resistor >> 4).into(),
        last & 0x0FFF,
        last >> 12,
    ];
    Some(numbers.map(u32::from))
}
