//! A frame as text, in the notation of `candump` and `cansend`.
//!
//! ```text
//!  18EA8021#00EE00   29-bit identifier (8 digits) and data
//!  60A#              11-bit identifier (3 digits), no data
//!  60A#R4            remote frame with DLC 4; R without a number: DLC 0
//! ```

use plumbline::can::{Frame, extended, standard};
use std::time::Duration;

/// The frame of a text. The error says what is wrong.
pub fn parse(text: &str) -> Result<Frame, String> {
    read(text).ok_or_else(|| format!("{text} is no frame"))
}

/// The frame of a text that is part of a test.
///
/// # Panics
/// The text is no frame.
#[track_caller]
pub fn frame(text: &str) -> Frame {
    match parse(text) {
        Ok(frame) => frame,
        Err(error) => panic!("{error}"),
    }
}

/// A line of `candump -L`, at a time since 1970.
pub fn log_line(time: Duration, interface: &str, frame: &Frame) -> String {
    format!(
        "({:010}.{:06}) {interface} {frame:?}",
        time.as_secs(),
        time.subsec_micros()
    )
}

fn read(text: &str) -> Option<Frame> {
    let (digits, data) = text.split_once('#')?;
    let number = hexadecimal(digits)?;
    let id = match digits.len() {
        3 if number <= 0x7FF => standard(number as u16),
        8 if number <= 0x1FFF_FFFF => extended(number),
        _ => return None,
    };
    match data.strip_prefix('R') {
        Some("") => Frame::remote(id, 0),
        Some(length) => Frame::remote(id, length.parse().ok()?),
        None => {
            let bytes = (0..data.len())
                .step_by(2)
                .map(|at| Some(hexadecimal(data.get(at..at + 2)?)? as u8));
            Frame::data(id, &bytes.collect::<Option<Vec<u8>>>()?)
        }
    }
}

/// A number of digits only: no sign.
fn hexadecimal(text: &str) -> Option<u32> {
    let is_number = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    u32::from_str_radix(text, 16).ok().filter(|_| is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_is_shown_as_its_text() {
        for text in [
            "000#",
            "7FF#0011223344556677",
            "00000000#FF",
            "1FFFFFFF#A0",
            "60A#R4",
        ] {
            assert_eq!(format!("{:?}", frame(text)), text);
        }
        assert_eq!(parse("60A#R"), Ok(frame("60A#R0")));
    }

    #[test]
    fn text_that_is_no_frame_is_refused() {
        for text in [
            "",
            "60A",
            "60A#4",
            "60A#4G",
            "60A#+4",
            "60A#R9",
            "800#",
            "20000000#",
            "0600#",
            "+0A#",
            "60A#001122334455667788",
            "60A#é0",
        ] {
            assert_eq!(parse(text), Err(format!("{text} is no frame")));
        }
    }
}
