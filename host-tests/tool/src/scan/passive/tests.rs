use super::*;
use plumbline::can::{extended, standard};

fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).unwrap()
}

fn addresses(frames: &[Frame]) -> Vec<(&'static str, String)> {
    rows(frames).iter().map(Row::address).collect()
}

const BOOT_UP: [u8; 8] = [0xFF, 3, 0x20, 3, 0, 0, 0x44, 3];

#[test]
fn boot_up_message_counts_only_twice() {
    let message = frame(0x321, &BOOT_UP);
    assert_eq!(addresses(&[message]), []);
    assert_eq!(addresses(&[message, message]), [("fsc", "320".to_owned())]);
    // Bits between the format and the identifier are not permitted.
    let other = frame(0x321, &[0xFF, 3, 0x20, 3, 1, 0, 0x44, 3]);
    assert_eq!(addresses(&[other, other]), []);
}

#[test]
fn nodes_of_all_protocols_are_recognised() {
    let claim = Frame::data(extended(0x18EE_FF80), &[0, 0, 0x40, 0x1F, 0, 0, 0, 0x80]).unwrap();
    let frames = [
        frame(0x70A, &[0]),
        frame(0x77F, &[0x7F]),
        frame(0x5FF, &[0, 0x62, 0x01, 1, 2, 3, 4]),
        claim,
        // None of these is a sign.
        frame(0x700, &[0]),
        frame(0x70B, &[1]),
        frame(0x70C, &[0, 0]),
        frame(0x181, &[1, 2, 3, 4]),
        frame(0x5FE, &[0, 0x62, 0x01, 1, 2, 3, 4]),
        frame(0x5F7, &[1, 0x62, 0x01, 1, 2, 3, 4]),
        Frame::remote(standard(0x70D), 1).unwrap(),
    ];
    let expected = [
        ("canopen", "10"),
        ("canopen", "127"),
        ("devicenet", "63"),
        ("j1939", "128"),
    ];
    let found = addresses(&frames);
    let found: Vec<(&str, &str)> = found
        .iter()
        .map(|(protocol, address)| (*protocol, address.as_str()))
        .collect();
    assert_eq!(found, expected);
    let serials: Vec<String> = rows(&frames)
        .iter()
        .map(|row| row.json(None)["serial"].to_string())
        .collect();
    assert_eq!(serials[2], 0x0403_0201.to_string());
}

#[test]
fn node_that_another_master_talks_to_is_not_asked() {
    let boot = frame(0x70A, &[0]);
    let row = &rows(&[boot])[0];
    assert_eq!(target(row, &[boot]), Some(Target::Canopen(10)));
    assert_eq!(target(row, &[boot, frame(0x60A, &[0x40])]), None);
    let message = frame(0x321, &BOOT_UP);
    let row = &rows(&[message, message])[0];
    assert!(target(row, &[message]).is_some());
    assert_eq!(target(row, &[message, frame(0x320, &[0])]), None);
}
