//! Block download: exact bytes, any length, lost and repeated segments, wrong ends.

use super::*;

#[test]
fn download_of_any_length_writes_all_bytes() {
    for length in [0, 1, 6, 7, 8, 14, 100, 216, 217, 218, 224, TEXT] {
        let mut t = booted();
        let data = text(length);
        assert_eq!(download(&mut t, &data, || false), [WRITTEN], "{length}");
        assert_eq!(t.read(0x2101, 0), Ok(length as u32));
        assert_eq!(t.wait(2000), []);
    }
}

#[test]
fn lost_segments_of_download_are_requested_again() {
    for lost in 0..35 {
        let mut t = booted();
        let mut place = 0;
        let lose = || {
            place += 1;
            place == lost || place == lost + 2
        };
        assert_eq!(download(&mut t, &text(TEXT), lose), [WRITTEN], "{lost}");
        assert_eq!(t.read(0x2101, 0), Ok(TEXT as u32));
    }
}

#[test]
fn repeated_segments_of_download_change_nothing() {
    let mut t = booted();
    let data = text(230);
    t.exchange(&initiate_download(data.len()));
    for bytes in segments(&data, 31) {
        let sent = t.exchange(&request(&bytes));
        assert_eq!(
            sent.len(),
            usize::from(bytes[0] == 31 || bytes[0] & 0x80 != 0)
        );
        assert_eq!(t.exchange(&request(&bytes)), NOTHING, "repeated");
    }
    assert_eq!(t.exchange(&download_end(&data, crc(&data))), [WRITTEN]);
    assert_eq!(t.read(0x2101, 0), Ok(230));
}

#[test]
fn download_without_size_or_crc_is_accepted() {
    for command in [0xC0, 0xC2, 0xC4] {
        let mut t = booted();
        let size = if command == 0xC2 { 10 } else { 0 };
        let initiate = request(&[command, 0x00, 0x21, 0x00, size]);
        assert_eq!(t.exchange(&initiate), [ACCEPTED]);
        let data = text(10);
        for bytes in segments(&data, 31) {
            t.exchange(&request(&bytes));
        }
        let sum = if command == 0xC4 { crc(&data) } else { 0x5555 };
        assert_eq!(t.exchange(&download_end(&data, sum)), [WRITTEN]);
        assert_eq!(t.read(0x2101, 0), Ok(10));
    }
}

#[test]
fn wrong_crc_or_length_is_aborted_and_changes_nothing() {
    let data = text(10);
    for (announced, sum, code) in [
        (10, crc(&data) ^ 1, CRC),
        (11, crc(&data), 0x0607_0010),
        (9, crc(&data), 0x0607_0010),
    ] {
        let mut t = booted();
        t.exchange(&initiate_download(announced));
        for bytes in segments(&data, 31) {
            t.exchange(&request(&bytes));
        }
        assert_eq!(t.exchange(&download_end(&data, sum)), aborted(code));
        assert_eq!(t.read(0x2101, 0), Ok(24));
    }
    // The application refuses the text.
    let mut t = booted();
    assert_eq!(download(&mut t, &[1, 2, 3], || false), aborted(0x0609_0030));
    assert_eq!(t.read(0x2101, 0), Ok(24));
}

#[test]
fn download_longer_than_object_is_aborted() {
    let mut t = booted();
    assert_eq!(t.exchange("632#C400210000000000"), [ACCEPTED]);
    let replies: Vec<_> = segments(&[7; 300], 31)
        .iter()
        .flat_map(|bytes| t.exchange(&request(bytes)))
        .take(2)
        .collect();
    assert_eq!(replies[0], "5B2#A21F1F0000000000");
    assert_eq!(replies[1..], aborted(0x0607_0012));
}

#[test]
fn segment_number_that_is_not_valid_is_aborted() {
    for command in [0x00, 0x60, 0x7F, 0xA1, 0xA2, 0xE0, 0xFF] {
        let mut t = booted();
        t.exchange(&initiate_download(24));
        t.exchange("632#0102030405060708");
        let sent = t.exchange(&request(&[command]));
        assert_eq!(sent, aborted(SEQUENCE_NUMBER), "{command:02X}");
        assert_eq!(t.wait(2000), []);
    }
}
