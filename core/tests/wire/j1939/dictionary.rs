//! The objects of the IMS360 in J1939 are those of CANopen: every request has the same reply in both protocols (S20, S38).

use crate::tester::canopen::write_request;
use crate::tester::ims360::{Ims360Tester, booted};
use crate::tester::j1939::{CLAIM, claimed, select};
use crate::tester::sweep::every;
use plumbline::canopen::Product;
use plumbline::model::ims360::Ims360Product;
use std::collections::BTreeSet;

/// Two sensors with the same settings: in J1939, and in CANopen, where J1939 is stored but not in force.
struct Pair {
    j1939: Ims360Tester,
    canopen: Ims360Tester,
}

impl Pair {
    fn new() -> Self {
        let mut canopen = booted();
        canopen.write(0x2104, 1, 2, 0).unwrap();
        select(&mut canopen);
        Self {
            j1939: claimed(),
            canopen,
        }
    }

    /// Sends the bytes of a request to both. Returns the replies, which are the same.
    #[track_caller]
    fn ask(&mut self, request: &str) -> Vec<String> {
        let replies = |tester: &mut Ims360Tester, to: &str, from: &str| -> Vec<String> {
            let sent = tester.exchange(&format!("{to}#{request}"));
            // Trouble codes and emergencies are not compared.
            let own = sent.iter().filter_map(|text| text.strip_prefix(from));
            own.map(String::from).collect()
        };
        let expected = replies(&mut self.canopen, "632", "5B2#");
        let replies = replies(&mut self.j1939, "18EF8021", "18EF2180#");
        assert_eq!(replies, expected, "{request}");
        replies
    }

    /// Reads an object, also a text.
    #[track_caller]
    fn read(&mut self, index: u16, sub: u8) -> String {
        let [low, high] = index.to_le_bytes();
        let reply = self.ask(&format!("40{low:02X}{high:02X}{sub:02X}00000000"));
        if reply[0].starts_with("41") {
            self.ask("6000000000000000");
        }
        reply.concat()
    }
}

/// Index and sub-index of each object.
fn objects() -> BTreeSet<(u16, u8)> {
    let rows = Ims360Product::OBJECTS.iter();
    rows.flat_map(|row| (row.sub..=row.sub + (row.count - 1)).map(|sub| (row.index, sub)))
        .collect()
}

#[test]
fn every_object_is_read_as_in_canopen() {
    let mut pair = Pair::new();
    let all = objects();
    assert!(all.len() > 120, "{}", all.len());
    let near = all.iter().flat_map(|&(index, _)| index - 1..=index + 1);
    for index in near.chain((0..=u16::MAX).step_by(every(61))) {
        let reply = pair.read(index, 0);
        let exists = all.iter().any(|(own, _)| *own == index);
        assert_eq!(reply.ends_with("00000206"), !exists, "{index:04X}h");
    }
    for &(index, _) in &all {
        for sub in 0..=u8::MAX {
            let reply = pair.read(index, sub);
            let exists = all.contains(&(index, sub)) || index == 0x1003 && sub <= 8;
            assert!(
                exists || reply.ends_with("11000906"),
                "{index:04X}h:{sub:02X}h"
            );
        }
    }
}

#[test]
fn every_write_is_answered_as_in_canopen() {
    let values = [
        0,
        1,
        2,
        3,
        7,
        8,
        9,
        10,
        11,
        15,
        16,
        31,
        32,
        99,
        100,
        127,
        128,
        240,
        241,
        253,
        254,
        255,
        256,
        2047,
        2048,
        8000,
        8001,
        25_000,
        25_001,
        65_535,
        125_000,
        250_000,
        0x8000_0000,
        0xFFFF_FFFF,
        0x8000_01B2,
        0x1B2,
    ];
    let mut pair = Pair::new();
    for (index, sub) in objects() {
        // The restart by 2010h is another test.
        let restarts =
            |size: u8, value: u32| index == 0x2010 && sub == 1 && size == 1 && value == 1;
        for size in 1..=4 {
            for value in values {
                if !restarts(size, value & (u32::MAX >> (32 - 8 * u32::from(size)))) {
                    pair.ask(&write_request(index, sub, size, value));
                    pair.read(index, sub);
                }
            }
        }
        // Without a size, in segments with a size, and without it.
        let [low, high] = index.to_le_bytes();
        let object = format!("{low:02X}{high:02X}{sub:02X}");
        for request in [
            format!("22{object}05000000"),
            format!("21{object}04000000"),
            "0705000000000000".to_string(),
            format!("21{object}05000000"),
            "0505000000000000".to_string(),
            format!("20{object}00000000"),
            "0D05000000000000".to_string(),
        ] {
            if index != 0x2010 {
                pair.ask(&request);
            }
        }
        pair.read(index, sub);
    }
    // All values after all writes.
    for (index, sub) in objects() {
        pair.read(index, sub);
    }
}

#[test]
fn segmented_transfers_are_answered_as_in_canopen() {
    let mut pair = Pair::new();
    for request in [
        // 1008h: toggle 1 first, then a segment too many.
        "4008100000000000",
        "7000000000000000",
        "6000000000000000",
        "4008100000000000",
        "6000000000000000",
        "7000000000000000",
        // 3210h: toggle 1 first, whole, a wrong size, fewer bytes than announced.
        "2110320004000000",
        "174D000000000000",
        "4010320000000000",
        "2110320004000000",
        "074D000000000000",
        "4010320000000000",
        "2110320005000000",
        "2110320004000000",
        "094D000000000000",
        "4010320000000000",
        // An abort by the client, and a new request in a transfer.
        "4008100000000000",
        "8008100000000008",
        "6000000000000000",
        "4008100000000000",
        "4000100000000000",
        "6000000000000000",
    ] {
        pair.ask(request);
    }
}

#[test]
fn block_transfers_are_answered_as_in_canopen() {
    let mut pair = Pair::new();
    // 1008h and 2000h:03, with different sizes of the block; a repeated segment; the end.
    for object in ["081000", "002003", "001000", "FE5F00"] {
        for size in ["00", "01", "7F", "80"] {
            for acknowledged in ["00", "01", "02"] {
                pair.ask(&format!("A4{object}{size}000000"));
                pair.ask("A300000000000000");
                pair.ask(&format!("A2{acknowledged}7F0000000000"));
                pair.ask("A2017F0000000000");
                pair.ask("A100000000000000");
            }
        }
    }
    // 3210h = 77 with its CRC (polynomial 1021h from 0), with a wrong one, without; a wrong number; an object that is read-only.
    for (begin, segment, end) in [
        ("C610320004000000", "814D000000000000", "CD1A570000000000"),
        ("C610320004000000", "814D000000000000", "CD00000000000000"),
        ("C210320004000000", "814E000000000000", "CD00000000000000"),
        ("C010320000000000", "814F000000000000", "CD00000000000000"),
        ("C610320005000000", "8150000000000000", "CD00000000000000"),
        ("C210320004000000", "8250000000000000", "CD00000000000000"),
        ("C200100004000000", "8150000000000000", "CD00000000000000"),
        ("C208100006000000", "8150000000000000", "C500000000000000"),
    ] {
        for request in [begin, segment, end, "4010320000000000"] {
            pair.ask(request);
        }
    }
}

#[test]
fn transfer_times_out_as_in_canopen() {
    let mut pair = Pair::new();
    for begin in [
        "4008100000000000",
        "2110320004000000",
        "A40810007F000000",
        "C210320004000000",
    ] {
        assert_eq!(pair.ask(begin).len(), 1);
        let aborts = |tester: &mut Ims360Tester, id: &str| -> Vec<(u64, String)> {
            let sent = tester.wait_text(2000).into_iter();
            sent.filter_map(|(at, text)| Some((at, text.strip_prefix(id)?.to_string())))
                .collect()
        };
        let expected = aborts(&mut pair.canopen, "5B2#");
        assert_eq!(expected.len(), 1, "{begin}");
        assert_eq!(aborts(&mut pair.j1939, "18EF2180#"), expected);
    }
}

/// A random frame that must change no object: requests, the transport protocol for other groups, uploads, claims of other nodes.
fn harmless(random: &mut impl Iterator<Item = u8>) -> String {
    let mut byte = || random.next().unwrap();
    let (kind, source, destination) = (
        byte() % 7,
        byte() % 254,
        if byte() < 128 { 0x80 } else { 0xFF },
    );
    let source = if source == 0x80 { 0x21 } else { source };
    let bytes: Vec<u8> = (0..8).map(|_| byte()).collect();
    let mut data: String = bytes.iter().map(|one| format!("{one:02X}")).collect();
    let (format, destination, source) = match kind {
        0 => (0xEA, destination, source),
        // Not Commanded Address.
        1 => {
            data.replace_range(
                10..,
                ["EBFE00", "C5FD00", "CAFE00"][usize::from(bytes[7] % 3)],
            );
            (0xEC, destination, source)
        }
        2 => (0xEB, destination, source),
        // Neither a download nor a segment or a block of one.
        3 => {
            let command = [0x40, 0x60, 0x80, 0xA0, 0xE0][usize::from(bytes[7] % 5)];
            data.replace_range(..2, &format!("{:02X}", command | bytes[0] & 0x1F));
            (0xEF, destination, source)
        }
        4 => (0xEE, 0xFF, source),
        // A higher NAME.
        5 => {
            data.replace_range(..14, "FFFFFFFFFFFFFF");
            data.replace_range(14.., &format!("{:02X}", 0x80 | bytes[7]));
            (0xEE, 0xFF, 0x80)
        }
        _ => (0xF0 | bytes[0] & 7, bytes[1], source),
    };
    let length = match byte() {
        0..200 => 8,
        other => usize::from(other % 9),
    };
    format!(
        "18{format:02X}{destination:02X}{source:02X}#{}",
        &data[..2 * length]
    )
}

#[test]
fn random_frames_that_write_nothing_change_no_object() {
    let mut state = 1939_u32;
    let mut random = std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    let mut tester = claimed();
    let values = |tester: &mut Ims360Tester| -> Vec<String> {
        let read = |(index, sub): (u16, u8)| {
            let [low, high] = index.to_le_bytes();
            tester.parameter(&format!("40{low:02X}{high:02X}{sub:02X}00000000"))
        };
        objects().into_iter().map(read).collect()
    };
    let before = values(&mut tester);
    for number in 0..20_000 {
        tester.exchange(&harmless(&mut random));
        if number % 20 == 0 {
            tester.wait(1);
        }
    }
    // Open transfers end.
    tester.wait(2000);
    assert_eq!(tester.request_group("FF", "00EE00"), [CLAIM]);
    assert_eq!(values(&mut tester), before);
    assert_eq!(
        tester.request_group("80", "EBFE00").len(),
        1,
        "a connection"
    );
}
