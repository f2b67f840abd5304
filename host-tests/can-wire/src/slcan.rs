//! A frame as a line of slcan (LAWICEL ASCII), without its CR, and the bit rates of its commands.
//!
//! ```text
//!  tiiil(dd)*       11-bit identifier (3 digits), length 0 to 8, the bytes (2 digits each)
//!  Tiiiiiiiil(dd)*  the same with a 29-bit identifier (8 digits)
//!  riiil            remote frame;  Riiiiiiiil the same with a 29-bit identifier
//!  S0 .. S8         10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s
//! ```
//!
//! Hexadecimal digits are read in either case and written in upper case.

use embedded_can::{ExtendedId, Id, StandardId};
use plumbline::can::{BitRate, Frame};

/// The bit rates of `S0`, `S1` and so on.
pub const RATES: [BitRate; 9] = [
    BitRate::K10,
    BitRate::K20,
    BitRate::K50,
    BitRate::K100,
    BitRate::K125,
    BitRate::K250,
    BitRate::K500,
    BitRate::K800,
    BitRate::M1,
];

/// Reads the line of a frame. Returns the frame and the rest of the line, which is a time stamp or empty; None if it is no frame.
pub fn read_frame(line: &[u8]) -> Option<(Frame, &[u8])> {
    let (&kind, rest) = line.split_first()?;
    let (id, rest) = match kind {
        b't' | b'r' => {
            let (digits, rest) = rest.split_at_checked(3)?;
            let id = u16::try_from(read_hex(digits)?).ok()?;
            (Id::Standard(StandardId::new(id)?), rest)
        }
        b'T' | b'R' => {
            let (digits, rest) = rest.split_at_checked(8)?;
            (Id::Extended(ExtendedId::new(read_hex(digits)?)?), rest)
        }
        _ => return None,
    };
    let (&length, rest) = rest.split_first()?;
    let length = usize::from(length.checked_sub(b'0').filter(|length| *length <= 8)?);
    if kind.eq_ignore_ascii_case(&b'r') {
        return Some((Frame::remote(id, length)?, rest));
    }
    let (digits, rest) = rest.split_at_checked(2 * length)?;
    let mut data = [0; 8];
    for (byte, digits) in data.iter_mut().zip(digits.chunks(2)) {
        *byte = read_hex(digits)? as u8;
    }
    Some((Frame::data(id, &data[..length])?, rest))
}

/// Appends the line of a frame.
pub fn write_frame(frame: &Frame, line: &mut Vec<u8>) {
    let kind = if frame.is_remote() { b'r' } else { b't' };
    match frame.id() {
        Id::Standard(id) => {
            line.push(kind);
            write_hex(id.as_raw().into(), 3, line);
        }
        Id::Extended(id) => {
            line.push(kind.to_ascii_uppercase());
            write_hex(id.as_raw().into(), 8, line);
        }
    }
    write_hex(frame.dlc() as u64, 1, line);
    for byte in frame.bytes() {
        write_hex((*byte).into(), 2, line);
    }
}

/// The value of up to 8 hexadecimal digits; None if there is another character.
pub fn read_hex(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |number: u32, digit| {
        Some(number << 4 | char::from(*digit).to_digit(16)?)
    })
}

/// Appends the low `digits` hexadecimal digits of `number`.
pub fn write_hex(number: u64, digits: u32, text: &mut Vec<u8>) {
    for shift in (0..digits).rev() {
        text.push(b"0123456789ABCDEF"[(number >> (4 * shift) & 0xF) as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::frame;

    #[test]
    fn frame_is_written_as_its_line_and_read_back() {
        for (text, line) in [
            ("300#00", "t300100"),
            ("7FF#0011223344556677", "t7FF80011223344556677"),
            ("18EA8021#00EE00", "T18EA8021300EE00"),
            ("60A#R4", "r60A4"),
            ("1FFFFFFF#R0", "R1FFFFFFF0"),
            ("000#", "t0000"),
        ] {
            let frame = frame(text);
            let mut written = Vec::new();
            write_frame(&frame, &mut written);
            assert_eq!(written, line.as_bytes());
            assert_eq!(read_frame(&written), Some((frame, &b""[..])));
            written.extend(b"1A2B");
            assert_eq!(read_frame(&written), Some((frame, &b"1A2B"[..])));
        }
    }

    #[test]
    fn line_that_is_no_frame_is_refused() {
        for line in [
            "",
            "t",
            "t30",
            "t3001",
            "t30010",
            "t300g00",
            "t3009",
            "t8000",
            "T200000000",
            "R1FFF0",
            "x300100",
            "t30010G",
            "t+00100",
        ] {
            assert_eq!(read_frame(line.as_bytes()), None, "{line}");
        }
    }
}
