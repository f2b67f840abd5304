//! Byte examples of each message of the IMS360 in J1939: a sensor with the serial number 1 at 80h, and a node at 21h.

use crate::tester::Tester;
use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{NO_CODES, select};
use plumbline::model::ims360::Ims360;
use plumbline::node::Boot;

const CLAIM: &str = "18EEFF80#0100E0FF00910080";

/// A sensor with these objects that has claimed its address.
fn claimed(objects: &[(u16, u8, u8, u32)]) -> Ims360Tester {
    let start = |now, boot: &Boot| Ims360::new(now, &Boot { serial: 1, ..*boot });
    let mut tester = Tester::power_up(Boot::default(), start);
    tester.node_id = 50;
    assert_eq!(tester.sent_text(), ["732#00"]);
    for &(index, sub, size, value) in objects {
        assert_eq!(tester.write(index, sub, size, value), Ok(()));
    }
    assert_eq!(tester.write(0x2104, 1, 2, 0), Ok(()));
    select(&mut tester);
    tester.power_cycle();
    tester.wait(250);
    tester
}

/// Sends each frame and expects these frames in return.
#[track_caller]
fn talk(tester: &mut Ims360Tester, rows: &[(&str, &[&str])]) {
    for (request, replies) in rows {
        assert_eq!(tester.exchange(request), *replies, "{request}");
    }
}

/// Writes 3210h or 3220h, in 0.01 deg. A trouble code can follow the reply.
fn offset(tester: &mut Ims360Tester, object: u8, angle: i32) {
    let bytes = angle.to_le_bytes();
    let bytes: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    let sent = tester.exchange(&format!("18EF8021#23{object:02X}3200{bytes}"));
    assert_eq!(sent[0], format!("18EF2180#60{object:02X}320000000000"));
    // Changes of the trouble codes are at least 50 ms apart.
    tester.wait(60);
}

#[test]
fn requests_and_their_answers() {
    let mut tester = claimed(&[]);
    let rows: &[(&str, &[&str])] = &[
        ("18EAFF21#00EE00", &[CLAIM]),
        ("18EA8021#EEFE00", &["18E8FF80#01FFFFFF21EEFE00"]),
        ("18EA8021#2AF000", &["0CF02A80#007D007D007DC0FF"]),
        ("18EA8021#2DF000", &["0CF02D80#007D007DD580C0FF"]),
        ("18EA8021#CAFE00", &[NO_CODES]),
    ];
    talk(&mut tester, rows);
}

#[test]
fn slopes_with_two_axes() {
    let rows = [
        (12_34, -5_00, "852B8300807A33", "1A953C73007DC0"),
        (0, 0, "00007D00007D33", "007D007D007DC0"),
        (-89_50, 20, "0040509A197D33", "FFFF647D007DC3"),
        (100_00, 0, "0000AF00007D37", "FFFF007D007DC3"),
    ];
    for (pitch, roll, ssi2, ssi) in rows {
        // A level sensor with these offsets, with the factory filter and at 8 Hz.
        let mut tester = claimed(&[]);
        offset(&mut tester, 0x10, pitch);
        offset(&mut tester, 0x20, roll);
        for latency in ["FF", "60"] {
            let rows: &[(&str, &[&str])] = &[
                ("18EA8021#29F000", &[&format!("0CF02980#{ssi2}{latency}")]),
                ("18EAFF21#13F000", &[&format!("0CF01380#{ssi}{latency}")]),
            ];
            talk(&mut tester, rows);
            tester.parameter("2B113100401F0000");
        }
    }
}

#[test]
fn slopes_with_one_axis() {
    for (angle, ssi2, ssi) in [
        (270_00, "000050FFFFFFF3", "FFFFFFFF007DCF"),
        (30_00, "00008CFFFFFFF3", "98B7FFFF007DCC"),
        (180_00, "000023FFFFFFF3", "FFFFFFFF007DCF"),
    ] {
        let mut tester = claimed(&[(0x3120, 1, 1, 0)]);
        tester.settle_at([0.0, 1.0, 0.0]);
        offset(&mut tester, 0x10, angle);
        let rows: &[(&str, &[&str])] = &[
            ("18EA8021#29F000", &[&format!("0CF02980#{ssi2}FF")]),
            ("18EA8021#13F000", &[&format!("0CF01380#{ssi}FF")]),
        ];
        talk(&mut tester, rows);
    }
}

#[test]
fn code_of_a_pitch_above_its_range() {
    let mut tester = claimed(&[]);
    tester.wait(100);
    offset(&mut tester, 0x10, 100_00);
    assert_eq!(
        tester.exchange("18EA8021#CAFE00"),
        ["18FECA80#04FF70130001FFFF"]
    );
}

#[test]
fn component_identification_to_one_node() {
    let mut tester = claimed(&[]);
    let packets: [&str; 3] = [
        "1CEB2180#01506C756D626C69",
        "1CEB2180#026E652A494D5333",
        "1CEB2180#0336302A312A2AFF",
    ];
    let rows: &[(&str, &[&str])] = &[
        ("18EA8021#EBFE00", &["1CEC2180#10140003FFEBFE00"]),
        ("1CEC8021#110301FFFFEBFE00", &packets),
        ("1CEC8021#13140003FFEBFE00", &[]),
        ("18EA8021#EBFE00", &["1CEC2180#10140003FFEBFE00"]),
    ];
    talk(&mut tester, rows);
    let sent = tester.wait_text(1250);
    assert_eq!(sent.last().unwrap().1, "1CEC2180#FF03FFFFFFEBFE00");
}

#[test]
fn component_identification_to_all() {
    let mut tester = claimed(&[]);
    let mut sent = tester.exchange("18EAFF21#EBFE00");
    sent.extend(tester.wait_text(200).into_iter().map(|(_, text)| text));
    let expected = [
        "1CECFF80#20140003FFEBFE00",
        "1CEBFF80#01506C756D626C69",
        "1CEBFF80#026E652A494D5333",
        "1CEBFF80#0336302A312A2AFF",
    ];
    assert_eq!(sent, expected);
}

#[test]
fn commanded_address_to_all() {
    let mut tester = claimed(&[]);
    let rows: &[(&str, &[&str])] = &[
        ("1CECFF21#20090002FFD8FE00", &[]),
        ("1CEBFF21#010100E0FF009100", &[]),
        ("1CEBFF21#0280A0FFFFFFFFFF", &["18EEFFA0#0100E0FF00910080"]),
    ];
    talk(&mut tester, rows);
}

#[test]
fn parameters_with_the_bytes_of_an_sdo() {
    let mut tester = claimed(&[]);
    let rows: &[(&str, &[&str])] = &[
        ("18EF8021#4000100000000000", &["18EF2180#430010009A010407"]),
        ("18EF8021#4011310000000000", &["18EF2180#4B113100D0070000"]),
        ("18EF8021#2B113100401F0000", &["18EF2180#6011310000000000"]),
        ("18EF8021#40FE5F0000000000", &["18EF2180#80FE5F0000000206"]),
        ("18EF8021#2B04210214000000", &["18EF2180#6004210200000000"]),
        ("18EF8021#2310100173617665", &["18EF2180#6010100100000000"]),
        ("18EF8021#2F00310102000000", &["18EF2180#6000310100000000"]),
        ("18EF8021#2310100173617665", &["18EF2180#6010100100000000"]),
        ("18EF8021#2F10200101000000", &["18EF2180#6010200100000000"]),
    ];
    talk(&mut tester, rows);
    let sent = tester.wait_text(1000);
    assert_eq!(sent.last().unwrap().1, "732#00");
}

#[test]
fn change_from_canopen() {
    let start = |now, boot: &Boot| Ims360::new(now, &Boot { serial: 1, ..*boot });
    let mut tester = Tester::power_up(Boot::default(), start);
    assert_eq!(tester.sent_text(), ["732#00"]);
    let rows: &[(&str, &[&str])] = &[
        ("632#2F00310101000000", &["5B2#6000310100000000"]),
        ("632#2310100173617665", &["5B2#6010100100000000"]),
        ("000#8132", &[CLAIM]),
    ];
    talk(&mut tester, rows);
}

/// S20 and S21: the limits of each object of this protocol, its factory value, and when it acts.
#[test]
fn objects_have_their_limits_and_factory_values() {
    let mut tester = claimed(&[]);
    let rows: [(u16, u8, u8, u32, u32); 18] = [
        (0x2102, 0, 1, 0x80, 254),
        (0x2104, 1, 2, 0, 9),
        (0x2104, 2, 2, 0, 1),
        (0x2104, 3, 2, 0, 5),
        (0x2104, 4, 2, 0, 9),
        (0x2105, 1, 1, 3, 8),
        (0x2105, 2, 1, 3, 8),
        (0x2105, 3, 1, 3, 255),
        (0x2105, 4, 1, 3, 8),
        (0x2106, 1, 1, 1, 2),
        (0x2106, 2, 1, 0, 8),
        (0x2106, 3, 1, 0, 16),
        (0x2106, 4, 1, 0, 128),
        (0x2106, 6, 1, 0, 32),
        (0x2106, 7, 1, 0, 8),
        (0x2106, 8, 2, 2047, 2048),
        (0x3100, 1, 1, 1, 0),
        (0x3100, 1, 1, 1, 3),
    ];
    for (index, sub, size, value, beyond) in rows {
        let [low, high] = index.to_le_bytes();
        let object = format!("{low:02X}{high:02X}{sub:02X}");
        let number = |number: u32| -> String {
            let bytes = number.to_le_bytes();
            bytes.iter().map(|byte| format!("{byte:02X}")).collect()
        };
        let (read, write) = if size == 1 {
            ("4F", "2F")
        } else {
            ("4B", "2B")
        };
        let present = format!("{read}{object}{}", number(value));
        let request = format!("40{object}00000000");
        assert_eq!(tester.parameter(&request), present);
        let refused = tester.parameter(&format!("{write}{object}{}", number(beyond)));
        // The range is exceeded, or the value is too high.
        let codes = ["30000906", "31000906"].map(|code| format!("80{object}{code}"));
        let listed = matches!(index, 0x2104 | 0x3100);
        assert!(
            refused == codes[0] || refused == codes[1] && !listed,
            "{refused}"
        );
        assert_eq!(tester.parameter(&request), present);
    }
    // The identity number is read-only. The function takes every value.
    assert_eq!(tester.parameter("2306210905000000"), "8006210902000106");
    assert_eq!(tester.parameter("4006210900000000"), "4306210901000000");
    assert_eq!(tester.parameter("2F062105FF000000"), "6006210500000000");
    assert_eq!(tester.parameter("2F022100FD000000"), "6002210000000000");
    // Address and NAME act after store and restart.
    assert_eq!(tester.request_group("80", "00EE00"), [CLAIM]);
    assert_eq!(tester.request_group("FD", "00EE00"), [""; 0]);
    tester.parameter("2310100173617665");
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["18EEFFFD#0100E0FF00FF0080"]);
}
