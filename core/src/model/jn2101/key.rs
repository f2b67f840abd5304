//! The programming key (manual 9.11): ten parameters as a text, to make one sensor like another.
//!
//! How ifm packs its key is not known in full. The key of an untouched sensor, which the manual prints, is given and taken as it
//! is; every other key is of our own layout, and of no use to a sensor of ifm, nor theirs to us:
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
//! The first of two names is in the lower bits. All little-endian; the CRC is CRC-16/IBM-3740; the eleven bytes are written in
//! Base64, sixteen characters.

use super::{base64, slots};
use crate::canopen::dictionary::Rule;
use crate::canopen::values::check;
use crate::canopen::{Abort, Text, Values};
use crc::{CRC_16_IBM_3740, Crc, NoTable};

/// The key of a sensor as delivered.
const FACTORY: &[u8] = b"D0UfZEgRKHAI5Ag=";

const MARK: u8 = 0x50;
const SIZE: usize = 11;

const CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_IBM_3740);

/// The slots that the key carries.
const SLOTS: [u8; 10] = [
    slots::NODE_ID,
    slots::BIT_RATE,
    slots::QUADRANT,
    slots::HEATING,
    slots::FILTER,
    slots::DEFINITION,
    slots::TERMINATION,
    slots::TEACH,
    slots::RESOLUTION,
    slots::ZERO,
];

/// The key of these values.
pub(super) fn compose(values: &Values, factory: &Values) -> Text {
    if SLOTS
        .iter()
        .all(|&slot| values.at(slot) == factory.at(slot))
    {
        return Text::from_slice(FACTORY).unwrap_or_default();
    }
    let at = |slot| values.at(slot);
    let pair = |low, high| (at(low) | at(high) << 4) as u8;
    let [rate0, rate1] = (at(slots::BIT_RATE) as u16).to_le_bytes();
    let last = at(slots::RESOLUTION) | at(slots::ZERO) << 12;
    let [last0, last1] = (last as u16).to_le_bytes();
    let body = [
        MARK,
        at(slots::NODE_ID) as u8,
        rate0,
        rate1,
        pair(slots::QUADRANT, slots::HEATING),
        pair(slots::FILTER, slots::DEFINITION),
        pair(slots::TERMINATION, slots::TEACH),
        last0,
        last1,
    ];
    let [crc0, crc1] = CRC.checksum(&body).to_le_bytes();
    let [a, b, c, d, e, f, g, h, i] = body;
    let bytes: [u8; SIZE] = [a, b, c, d, e, f, g, h, i, crc0, crc1];
    base64::encode(&bytes)
}

/// The values that a key stands for, on top of `values`; each of them is permitted by `rules`.
pub(super) fn parse(
    text: &[u8],
    values: &Values,
    factory: &Values,
    rules: &[Rule],
) -> Result<Values, Abort> {
    let mut parsed = *values;
    if text == FACTORY {
        parsed.copy(factory, SLOTS);
        return Ok(parsed);
    }
    let bytes: [u8; SIZE] = base64::decode(text).ok_or(Abort::Value)?;
    let (body, crc) = bytes.split_last_chunk::<2>().ok_or(Abort::Value)?;
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
        return Err(Abort::Value);
    };
    if mark != MARK || CRC.checksum(body) != u16::from_le_bytes(*crc) {
        return Err(Abort::Value);
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
    for (slot, number) in SLOTS.into_iter().zip(numbers.map(u32::from)) {
        let rule = rules.iter().find(|rule| rule.home.slot() == Some(slot));
        let home = rule.ok_or(Abort::Value)?.home;
        check(home, number).map_err(|_| Abort::Value)?;
        parsed.set(slot, number);
    }
    Ok(parsed)
}
