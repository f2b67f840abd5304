//! Frames for a sensor that speaks CANopen, and what it may send.
//!
//! Most frames are SDO requests for objects that exist, with sizes and values that are often permitted; the objects are those of
//! the JN2101.

use super::Source;
use plumbline::can::{Frame, extended, standard};
use plumbline::canopen::Model;
use plumbline::canopen::dictionary::{Home, Rule};
use plumbline::canopen::wire::{DISABLED, standard_id};
use plumbline::model::jn2101::Application;
use plumbline::node::Readout;

/// The node id of a sensor as delivered.
pub const FACTORY_NODE_ID: u8 = 10;

/// A frame for the node with this id, more or less.
pub fn frame(source: &mut impl Source, node_id: u8) -> Frame {
    let node = u16::from(node_id);
    let (id, data) = match source.byte() {
        0..=169 => (0x600 + node, request(source).to_vec()),
        170..=189 => (
            0x000,
            vec![nmt(source), if source.byte() < 200 { 0 } else { node_id }],
        ),
        190..=214 => (0x080, Vec::new()),
        215..=224 => return remote(0x700 + node, source),
        225..=234 => return remote(0x180 + node, source),
        235..=239 => return remote(0x280 + node, source),
        240..=247 => (source.number() as u16, bytes(source)),
        _ => {
            let frame = Frame::data(extended(source.number()), &bytes(source));
            return frame.expect("at most eight bytes");
        }
    };
    Frame::data(standard(id), &data).expect("at most eight bytes")
}

fn remote(id: u16, source: &mut impl Source) -> Frame {
    Frame::remote(standard(id), usize::from(source.byte() % 9)).expect("at most eight bytes")
}

fn bytes(source: &mut impl Source) -> Vec<u8> {
    let length = source.byte() % 9;
    (0..length).map(|_| source.byte()).collect()
}

/// Mostly a start, so that PDOs are sent.
fn nmt(source: &mut impl Source) -> u8 {
    match source.byte() {
        0..=149 => 1,
        150..=169 => 2,
        170..=209 => 128,
        210..=219 => 129,
        220..=239 => 130,
        _ => source.byte(),
    }
}

fn rule(source: &mut impl Source) -> &'static Rule {
    let rules = Application::RULES;
    &rules[usize::from(source.byte()) % rules.len()]
}

/// An SDO request.
fn request(source: &mut impl Source) -> [u8; 8] {
    let rule = rule(source);
    let [low, high] = rule.index().to_le_bytes();
    let sub = rule.sub() + source.byte() % (rule.count() + 1);
    match source.byte() {
        0..=59 => [0x40, low, high, sub, 0, 0, 0, 0],
        60..=159 => {
            let size = match rule.data_type().size() {
                0 => 1 + source.byte() % 4,
                size => size,
            };
            let [a, b, c, d] = value(rule, source).to_le_bytes();
            [0x23 | (4 - size) << 2, low, high, sub, a, b, c, d]
        }
        // Segmented, mostly of the right size.
        160..=179 => {
            let sized = source.byte() & 1;
            let size = match source.byte() {
                0..=199 => rule
                    .data_type()
                    .size()
                    .max(16 * u8::from(rule.home == Home::Key)),
                _ => source.byte(),
            };
            [0x20 | sized, low, high, sub, size, 0, 0, 0]
        }
        180..=209 => segment(source, rule.data_type().size()),
        210..=234 => [0x60 | (source.byte() & 1) << 4, 0, 0, 0, 0, 0, 0, 0],
        235..=239 => [0x80, low, high, sub, 0, 0, 0, 0],
        _ => std::array::from_fn(|_| source.byte()),
    }
}

/// A segment of a download: of the printed programming key, or of a small number.
fn segment(source: &mut impl Source, size: u8) -> [u8; 8] {
    const KEY: &[u8; 16] = b"D0UfZEgRKHAI5Ag=";
    let mut bytes = [0; 8];
    let toggle = (source.byte() & 1) << 4;
    let (data, last) = match source.byte() % 8 {
        0 => (&KEY[..7], false),
        1 => (&KEY[7..14], false),
        2 => (&KEY[14..], true),
        3 => (&KEY[..7], true),
        _ => (&[1, 0, 0, 0][..usize::from(size)], true),
    };
    bytes[0] = toggle | (7 - data.len() as u8) << 1 | u8::from(last);
    bytes[1..=data.len()].copy_from_slice(data);
    bytes
}

/// A value that is often permitted.
fn value(rule: &Rule, source: &mut impl Source) -> u32 {
    let raw = source.number();
    match (source.byte(), rule.home) {
        (0..=31, _) => raw,
        (_, Home::Range(_, low, high)) => u32::from(low) + raw % (u32::from(high - low) + 1),
        (_, Home::OneOf(_, list)) => list[raw as usize % list.len()].into(),
        (_, Home::SyncId(_)) => 0x80 | raw & DISABLED,
        (_, Home::Live(_)) if rule.index() == 0x1010 => u32::from_le_bytes(*b"save"),
        (_, Home::Live(_)) if rule.index() == 0x1011 => u32::from_le_bytes(*b"load"),
        _ => raw % 300,
    }
}

/// What every frame of such a sensor keeps to; the node id when it is a boot-up message.
///
/// # Panics
/// When this one does not.
pub fn check(frame: &Frame) -> Option<u8> {
    let id = standard_id(frame.id()).expect("no 29-bit identifiers");
    let node_id = (id & 0x7F) as u8;
    let data = frame.bytes();
    let keeps = match id & 0x780 {
        0x000 => id == 0 && data == [1, 0],
        0x080 | 0x280 | 0x580 => data.len() == 8,
        0x180 => data.len() == 4,
        0x700 => matches!(data, [0 | 4 | 5 | 127 | 0x84 | 0x85 | 0xFF]),
        _ => false,
    };
    assert!(keeps && !frame.is_remote(), "{frame:?}");
    (id & 0x780 == 0x700 && data == [0]).then_some(node_id)
}

/// Whether the angles are such as the sensor can have.
pub fn is_possible(readout: Readout) -> bool {
    let y = readout.y.is_some_and(|y| (-18_000..36_000).contains(&y));
    (-18_000..=18_000).contains(&readout.x) && y
}
