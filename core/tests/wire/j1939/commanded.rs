//! Commanded Address of the IMS360 by BAM and by RTS/CTS: what acts, what changes nothing, and the times of the transport protocol
//! (S22, S24, S25, S29).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{CLAIM, LOWER, NAME, NO_CODES, claimed, with};

/// NAME and new address to all nodes, from `source`: the announcement and the packets.
fn to_all(source: u8, name: &str, address: u8) -> [String; 3] {
    [
        format!("1CECFF{source:02X}#20090002FFD8FE00"),
        format!("1CEBFF{source:02X}#01{}", &name[..14]),
        format!(
            "1CEBFF{source:02X}#02{}{address:02X}FFFFFFFFFF",
            &name[14..]
        ),
    ]
}

/// The same to the node at `own`, from 21h.
fn to_us(own: u8, address: u8) -> [String; 3] {
    [
        format!("1CEC{own:02X}21#10090002FFD8FE00"),
        format!("1CEB{own:02X}21#01{}", &NAME[..14]),
        format!("1CEB{own:02X}21#02{}{address:02X}FFFFFFFFFF", &NAME[14..]),
    ]
}

fn claim(address: u8) -> String {
    format!("18EEFF{address:02X}#{NAME}")
}

/// Sends frames. Returns the frames of the sensor.
fn send<'a>(
    tester: &mut Ims360Tester,
    frames: impl IntoIterator<Item = &'a String>,
) -> Vec<String> {
    let frames = frames.into_iter();
    frames.flat_map(|text| tester.exchange(text)).collect()
}

/// Checks that the address has not changed.
#[track_caller]
fn is_at(tester: &mut Ims360Tester, address: u8) {
    let sent = tester.exchange("18EAFF21#00EE00");
    assert_eq!(sent, [claim(address)]);
}

#[test]
fn every_address_is_taken_from_a_message_to_all_and_kept_by_a_save() {
    let mut tester = claimed();
    let mut own = 0x80;
    for address in 0..=255_u8 {
        let sent = send(&mut tester, &to_all(0xFD, NAME, address));
        if address > 253 {
            assert_eq!(sent, [""; 0]);
            is_at(&mut tester, own);
            continue;
        }
        own = address;
        assert_eq!(sent, [claim(own)]);
        assert_eq!(tester.wait_text(249), []);
        tester.wait(1);
        let client = own ^ 1;
        let reply = tester.exchange(&format!("18EF{own:02X}{client:02X}#4002210000000000"));
        assert_eq!(
            reply,
            [format!("18EF{client:02X}{own:02X}#4F022100{own:02X}000000")]
        );
    }
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
    tester.wait(250);
    send(&mut tester, &to_all(0x21, NAME, 0xA0));
    tester.wait(250);
    let reply = tester.exchange("18EFA021#2310100173617665");
    assert_eq!(reply, ["18EF21A0#6010100100000000"]);
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [claim(0xA0)]);
}

#[test]
fn present_address_and_address_of_another_node_are_claimed_too() {
    let mut tester = claimed();
    tester.exchange(&format!("18EEFF30#{LOWER}"));
    for address in [0x80, 0x30, 0x30] {
        let sent = send(&mut tester, &to_all(0x21, NAME, address));
        assert_eq!(sent, [claim(address)]);
        assert_eq!(tester.wait_text(249), []);
        let codes = NO_CODES.replace("80#", &format!("{address:02X}#"));
        assert_eq!(tester.wait_text(1), [(1, codes)]);
    }
}

#[test]
fn command_acts_while_claiming_and_its_address_can_be_lost() {
    let mut tester = with(&[(0x2104, 1, 2, 0)]);
    tester.wait(100);
    assert_eq!(send(&mut tester, &to_all(0x21, NAME, 0xA5)), [claim(0xA5)]);
    let sent = tester.exchange(&format!("18EEFFA5#{LOWER}"));
    assert_eq!(sent, [claim(0xA6)]);
    tester.wait(250);
    let reply = tester.exchange("18EFA621#4002210000000000");
    assert_eq!(reply, ["18EF21A6#4F022100A5000000"], "the commanded one");
}

#[test]
fn node_without_an_address_acts_on_its_own_name_only() {
    let own = "0102E3FF00910000";
    let mut tester = with(&[(0x2106, 1, 1, 0)]);
    tester.exchange(&format!("18EEFF80#{LOWER}"));
    tester.wait(200);
    assert_eq!(send(&mut tester, &to_all(0x21, NAME, 0xA0)), [""; 0]);
    assert_eq!(send(&mut tester, &to_us(0xFE, 0xA0)), [""; 0]);
    assert_eq!(tester.wait_text(2000), []);
    let sent = send(&mut tester, &to_all(0x21, own, 0xA0));
    assert_eq!(sent, [format!("18EEFFA0#{own}")]);
}

#[test]
fn message_that_is_not_a_command_to_this_node_changes_nothing() {
    let [begin, first, second] = to_all(0x21, NAME, 0xA0);
    let [_, other_first, other_second] = to_all(0x35, NAME, 0xA0);
    let [_, us_first, us_second] = to_us(0x80, 0xA0);
    let f = |text: &str| text.to_string();
    let announced = |data: &str| format!("1CECFF21#{data}");
    let third = f("1CEBFF21#03FFFFFFFFFFFFFF");
    let cases: Vec<(&str, Vec<String>)> = vec![
        (
            "another NAME",
            to_all(0x21, "0202E3FF00910080", 0xA0).into(),
        ),
        ("not capable", to_all(0x21, "0102E3FF00910000", 0xA0).into()),
        ("address 254", to_all(0x21, NAME, 254).into()),
        ("address 255", to_all(0x21, NAME, 255).into()),
        ("one frame", vec![format!("18FED821#{NAME}")]),
        (
            "8 bytes",
            vec![announced("20080002FFD8FE00"), f(&first), f(&second)],
        ),
        (
            "10 bytes",
            vec![announced("200A0002FFD8FE00"), f(&first), f(&second)],
        ),
        (
            "1 byte",
            vec![
                announced("20010001FFD8FE00"),
                f("1CEBFF21#01A0FFFFFFFFFFFF"),
            ],
        ),
        ("packet 2 missing", vec![f(&begin), f(&first)]),
        ("packet 1 missing", vec![f(&begin), f(&second)]),
        ("exchanged", vec![f(&begin), f(&second), f(&first)]),
        (
            "packet 1 twice",
            vec![f(&begin), f(&first), f(&first), f(&second)],
        ),
        (
            "packet 0",
            vec![f(&begin), first.replace("#01", "#00"), f(&second)],
        ),
        (
            "of another node",
            vec![f(&begin), other_first, other_second],
        ),
        ("to one node", vec![f(&begin), us_first, us_second]),
        ("not announced", vec![f(&first), f(&second)]),
        (
            "3 packets announced",
            vec![announced("20090003FFD8FE00"), f(&first), f(&second)],
        ),
        (
            "3 packets",
            vec![announced("20090003FFD8FE00"), f(&first), f(&second), third],
        ),
        (
            "1 packet announced",
            vec![announced("20090001FFD8FE00"), f(&first), f(&second)],
        ),
        (
            "aborted",
            vec![
                f(&begin),
                f(&first),
                announced("FF03FFFFFFD8FE00"),
                f(&second),
            ],
        ),
        (
            "another PGN",
            vec![announced("20090002FFD9FE00"), f(&first), f(&second)],
        ),
        (
            "Proprietary A",
            vec![announced("20090002FF00EF00"), f(&first), f(&second)],
        ),
        (
            "replaced",
            vec![
                f(&begin),
                f(&first),
                announced("20140003FFCAFE00"),
                f(&second),
            ],
        ),
        (
            "short packet",
            vec![f(&begin), f(&first), second[..13].to_string()],
        ),
        (
            "short announcement",
            vec![begin[..23].to_string(), f(&first), f(&second)],
        ),
        (
            "to us alone",
            vec![begin.replace("ECFF", "EC80"), f(&first), f(&second)],
        ),
        (
            "page of the announcement",
            vec![begin.replace("1CEC", "1EEC"), f(&first), f(&second)],
        ),
        (
            "page of the packets",
            vec![
                f(&begin),
                first.replace("1CEB", "1EEB"),
                second.replace("1CEB", "1EEB"),
            ],
        ),
        (
            "from 254",
            vec![
                begin.replace("21#", "FE#"),
                first.replace("21#", "FE#"),
                second.replace("21#", "FE#"),
            ],
        ),
    ];
    for (name, frames) in cases {
        let mut tester = claimed();
        assert_eq!(send(&mut tester, &frames), [""; 0], "{name}");
        is_at(&mut tester, 0x80);
        assert_eq!(tester.parameter("4002210000000000"), "4F02210080000000");
        // A complete message acts.
        let sent = send(&mut tester, &to_all(0x21, NAME, 0xA1));
        assert_eq!(sent, [claim(0xA1)], "after: {name}");
    }
}

#[test]
fn message_is_received_between_others() {
    // A new announcement begins anew; two nodes command at the same time: the first complete one acts.
    let mut tester = claimed();
    let a = to_all(0x21, NAME, 0xB1);
    let b = to_all(0x35, NAME, 0xB2);
    assert_eq!(
        send(&mut tester, [&a[0], &a[1], &a[0], &a[1], &a[2]]),
        [claim(0xB1)]
    );
    tester.wait(250);
    assert_eq!(
        send(&mut tester, [&a[0], &b[0], &a[1], &b[1], &b[2]]),
        [claim(0xB2)]
    );
    tester.wait(250);
    // A connection while a message to all is in progress, of the same node too.
    let c = to_us(0xB2, 0xB3);
    let sent = send(&mut tester, [&a[0], &c[0], &a[1], &c[1], &c[2]]);
    let expected = [
        "1CEC21B2#110201FFFFD8FE00".to_string(),
        "1CEC21B2#13090002FFD8FE00".to_string(),
        claim(0xB3),
    ];
    assert_eq!(sent, expected);
}

#[test]
fn frames_without_a_connection_are_ignored() {
    let mut tester = claimed();
    let [_, first, second] = to_us(0x80, 0xA0);
    for text in [
        "1CEC8021#110101FFFFEBFE00",
        "1CEC8021#13140003FFEBFE00",
        "1CEC8021#FF03FFFFFFEBFE00",
        "1CEC8021#05090002FFD8FE00",
        "1CEC8021#10090002FFD8",
        "1CECFF21#10090002FFD8FE00",
        "1CEC80FE#10090002FFD8FE00",
        &first,
        &second,
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
    }
    is_at(&mut tester, 0x80);
}

#[test]
fn connection_for_anything_else_is_aborted() {
    let mut tester = claimed();
    for (size, packets, pgn) in [
        ("1400", "03", "EBFE00"),
        ("6400", "0F", "CAFE00"),
        ("0900", "02", "00EF00"),
        ("F906", "FF", "EEFE00"),
        ("0900", "02", "000000"),
        ("0900", "02", "CAFE01"),
        ("0800", "02", "D8FE00"),
        ("0A00", "02", "D8FE00"),
        ("F906", "FF", "D8FE00"),
        ("0900", "01", "D8FE00"),
        ("0900", "03", "D8FE00"),
    ] {
        let sent = tester.exchange(&format!("1CEC8021#10{size}{packets}FF{pgn}"));
        assert_eq!(sent, [format!("1CEC2180#FF02FFFFFF{pgn}")]);
    }
    is_at(&mut tester, 0x80);
}

#[test]
fn sender_repeats_and_ends_its_connection() {
    let mut tester = claimed();
    let [rts, first, second] = to_us(0x80, 0xA2);
    let cts = "1CEC2180#110201FFFFD8FE00";
    assert_eq!(tester.exchange(&rts), [cts]);
    assert_eq!(tester.exchange(&first), [""; 0]);
    assert_eq!(tester.exchange("1CEC8021#FF03FFFFFFD8FE00"), [""; 0]);
    assert_eq!(tester.exchange(&second), [""; 0], "aborted");
    assert_eq!(tester.exchange(&rts), [cts]);
    assert_eq!(tester.exchange(&rts), [cts], "repeated");
    assert_eq!(tester.exchange(&first), [""; 0]);
    let sent = tester.exchange(&second);
    assert_eq!(sent, ["1CEC2180#13090002FFD8FE00".to_string(), claim(0xA2)]);
}

#[test]
fn times_between_packets_have_their_limits() {
    // T1 of a message to all, T2 after CTS, T1 within a connection. One ms later the message has no effect.
    let connection = [0, 1249, 749];
    for (message, pauses) in [
        (to_all(0x21, NAME, 0xA0), [0, 749, 749]),
        (to_us(0x80, 0xA0), connection),
    ] {
        for late in [None, Some(1), Some(2)] {
            let mut tester = claimed();
            let mut sent = Vec::new();
            for (place, (text, pause)) in message.iter().zip(pauses).enumerate() {
                tester.wait(pause + u64::from(late == Some(place)));
                sent = tester.exchange(text);
            }
            let acts = sent.last() == Some(&claim(0xA0));
            assert_eq!(acts, late.is_none(), "{message:?} {late:?}: {sent:?}");
        }
    }
}
