//! Frames for a sensor that speaks FSC, and what it may send.

use super::Source;
use plumbline::can::{Frame, extended, standard};
use plumbline::node::Readout;

/// A frame: mostly a request, mostly of a code that exists.
pub fn frame(source: &mut impl Source) -> Frame {
    let raw = source.number();
    let id = match source.byte() {
        0..=199 => standard(0x300),
        200..=229 => standard(0x100),
        230..=242 => standard(raw as u16),
        _ => extended(raw),
    };
    let length = usize::from(source.byte() % 9);
    let mut data: [u8; 8] = std::array::from_fn(|_| source.byte());
    match source.byte() {
        // A write of something small, which is often permitted.
        0..=79 => {
            data[0] = 0x20 + data[0] % 10;
            data[2..].iter_mut().for_each(|byte| *byte &= 0x03);
        }
        80..=109 => data[0] %= 0x30,
        110..=119 => data[..5].copy_from_slice(b"\x50SAVE"),
        120..=124 => data[..5].copy_from_slice(b"\x40LOAD"),
        125..=129 => data[..6].copy_from_slice(b"\xFFRESET"),
        // Identifiers that bring the sensor back to where most requests go.
        130..=139 => data[..5].copy_from_slice(&[0x20, 0x00, 0x03, 0, 0]),
        _ => {}
    }
    let frame = if source.byte() < 8 {
        Frame::remote(id, length)
    } else {
        Frame::data(id, &data[..length])
    };
    frame.expect("at most eight bytes")
}

/// What every frame of such a sensor keeps to, `heated` or not.
///
/// # Panics
/// When this one does not.
pub fn check(frame: &Frame, heated: bool) {
    assert!(!frame.is_remote(), "{frame:?}");
    let [_, status, ..] = *frame.bytes() else {
        panic!("a reply has a code and a status: {frame:?}");
    };
    let never = if heated { 0x80 } else { 0xC0 };
    assert_eq!(
        status & never,
        0,
        "reserved bits and AccuracyWarning: {frame:?}"
    );
}

/// Whether the angles are such as the sensor can have.
pub fn is_possible(readout: Readout) -> bool {
    let within = readout.y.is_none_or(|y| (-9000..=9000).contains(&y));
    (-9000..36_000).contains(&readout.x) && within
}
