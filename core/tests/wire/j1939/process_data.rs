//! Process data of the IMS360 in J1939: angles, rates and accelerations, their quality and latency.

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{claimed, claimed_with};

/// The data of a group: SSI2, SSI, ARI, ACCS.
fn group(tester: &mut Ims360Tester, pgn: &str) -> String {
    let sent = tester.request_group("80", pgn);
    sent[0].split_once('#').unwrap().1.to_string()
}

const SSI2: &str = "29F000";
const SSI: &str = "13F000";
const ARI: &str = "2AF000";
const ACCS: &str = "2DF000";

/// The number in these bytes (2 digits each), least significant first.
fn number(data: &str, first: usize, bytes: usize) -> i64 {
    let digit = |at: usize| i64::from_str_radix(&data[2 * at..2 * at + 2], 16).unwrap();
    let places = (first..first + bytes).rev();
    places.fold(0, |sum, at| sum << 8 | digit(at))
}

/// An angle of SSI2 in deg.
fn fine(data: &str, first: usize) -> f64 {
    number(data, first, 3) as f64 / 32_768.0 - 250.0
}

#[test]
fn angles_are_not_rounded() {
    let mut tester = claimed();
    tester.tilt(12.345, -5.0);
    let data = group(&mut tester, SSI2);
    assert!((fine(&data, 0) - 12.345).abs() < 0.0005, "{data}");
    assert!((fine(&data, 3) + 5.0).abs() < 0.0005, "{data}");
    assert_eq!(&data[12..], "33FF");
    let data = group(&mut tester, SSI);
    assert_eq!(
        number(&data, 0, 2),
        ((12.345 + 64.0) * 500.0_f64).round() as i64
    );
    assert_eq!(number(&data, 2, 2), (59.0 * 500.0) as i64);
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
fn two_axes_have_the_bytes_of_their_angles() {
    let rows = [
        (1234, -500, "852B8300807A33", "1A953C73007DC0"),
        (0, 0, "00007D00007D33", "007D007D007DC0"),
        (-8950, 20, "0040509A197D33", "FFFF647D007DC3"),
        (10_000, 0, "0000AF00007D37", "FFFF007D007DC3"),
    ];
    for (pitch, roll, ssi2, ssi) in rows {
        // A level sensor with these offsets, with the factory filter and at 8 Hz.
        let mut tester = claimed();
        offset(&mut tester, 0x10, pitch);
        offset(&mut tester, 0x20, roll);
        for latency in ["FF", "81"] {
            assert_eq!(group(&mut tester, SSI2), format!("{ssi2}{latency}"));
            assert_eq!(group(&mut tester, SSI), format!("{ssi}{latency}"));
            tester.parameter("2B113100401F0000");
        }
    }
}

#[test]
fn one_axis_has_the_bytes_of_its_angle() {
    for (angle, ssi2, ssi) in [
        (27_000, "000050FFFFFFF3", "FFFFFFFF007DCF"),
        (3000, "00008CFFFFFFF3", "98B7FFFF007DCC"),
        (18_000, "000023FFFFFFF3", "FFFFFFFF007DCF"),
    ] {
        let mut tester = claimed_with(&[(0x3120, 1, 1, 0)]);
        tester.settle_at([0.0, 1.0, 0.0]);
        offset(&mut tester, 0x10, angle);
        assert_eq!(group(&mut tester, SSI2), format!("{ssi2}FF"));
        assert_eq!(group(&mut tester, SSI), format!("{ssi}FF"));
    }
}

#[test]
fn value_includes_offset_and_reports_out_of_range() {
    let mut tester = claimed();
    tester.parameter("2310320010270000"); // 100 deg
    let data = group(&mut tester, SSI2);
    assert_eq!(data, "0000AF00007D37FF");
    assert_eq!(group(&mut tester, SSI), "FFFF007D007DC3FF");
    tester.parameter("23103200FFFFFF7F");
    assert_eq!(group(&mut tester, SSI2), "FFFFFF00007D3FFF");
}

#[test]
fn angle_of_one_axis_is_within_180_deg() {
    let mut tester = claimed_with(&[(0x3120, 1, 1, 0)]);
    tester.settle_at([-1.0, 0.0, 0.0]); // 270 deg
    assert_eq!(group(&mut tester, SSI2), "000050FFFFFFF3FF");
    assert_eq!(group(&mut tester, SSI), "FFFFFFFF007DCFFF");
    tester.settle_at([0.5, 0.75_f64.sqrt(), 0.0]); // 30 deg
    let data = group(&mut tester, SSI2);
    assert!((fine(&data, 0) - 30.0).abs() < 0.0005, "{data}");
    assert_eq!(&group(&mut tester, SSI)[12..], "CCFF");
    tester.rate = [1 << 16, 2 << 16, 20 << 16];
    tester.sample();
    assert_eq!(group(&mut tester, ARI), "0087807D007EC0FF");
    assert_eq!(&group(&mut tester, SSI)[8..12], "10A4");
}

#[test]
fn rates_have_the_signs_of_the_angles() {
    let mut tester = claimed();
    tester.rate = [-15 << 16, 20 << 16, 5 << 16];
    tester.sample();
    assert_eq!(group(&mut tester, ARI), "00878075807FC0FF");
    assert_eq!(&group(&mut tester, SSI)[8..12], "10A4");
}

#[test]
fn acceleration_has_lateral_first() {
    let mut tester = claimed();
    tester.settle_at([1.0, 0.0, 0.0]);
    assert_eq!(group(&mut tester, ACCS), "007DD580007DC0FF");
    tester.settle_at([0.0, -1.0, 0.0]);
    assert_eq!(group(&mut tester, ACCS), "2B79007D007DC0FF");
}

#[test]
fn latency_matches_the_active_filter() {
    let mut tester = claimed();
    let latency = |tester: &mut Ims360Tester| group(tester, SSI2)[14..].to_string();
    assert_eq!(latency(&mut tester), "FF");
    tester.parameter("2B113100401F0000"); // 8 Hz
    assert_eq!(latency(&mut tester), "81", "47.6 and 16.7 ms");
    tester.parameter("2F10310101000000"); // Butterworth
    tester.parameter("2B113100A8610000"); // 25 Hz
    assert_eq!(latency(&mut tester), "5F", "31.0 and 16.7 ms");
    tester.parameter("2F10310100000000"); // off
    assert_eq!(latency(&mut tester), "21", "16.7 ms");
    tester.parameter("2F10310101000000");
    tester.parameter("2F10310201000000"); // fusion
    assert_eq!(latency(&mut tester), "0D", "6.3 ms");
}

#[test]
fn defective_sensor_sends_errors() {
    let mut tester = claimed();
    tester.wait_without_samples(200);
    assert_eq!(group(&mut tester, SSI2), "FEFEFEFEFEFEBBFF");
    assert_eq!(group(&mut tester, SSI), "FEFEFEFEFEFEEAFF");
    assert_eq!(group(&mut tester, ARI), "FEFEFEFEFEFEEAFF");
    tester.wait(10);
    assert_eq!(group(&mut tester, ACCS), "007D007DD580C0FF");
}

#[test]
fn rates_are_parameters_that_act_at_once() {
    let mut tester = claimed();
    assert_eq!(tester.parameter("2B04210214000000"), "6004210200000000");
    let times = |tester: &mut Ims360Tester, ms: u64, id: &str| -> Vec<u64> {
        let sent = tester.wait_text(ms).into_iter();
        sent.filter(|(_, text)| text.starts_with(id))
            .map(|(at, _)| at)
            .collect()
    };
    assert_eq!(times(&mut tester, 100, "0CF01380"), [20, 40, 60, 80, 100]);
    assert_eq!(tester.parameter("2B04210200000000"), "6004210200000000");
    assert_eq!(times(&mut tester, 100, "0CF01380"), []);
    for period in ["0900", "0100"] {
        let reply = tester.parameter(&format!("2B042102{period}0000"));
        assert_eq!(reply, "8004210230000906");
    }
    let mut all = claimed_with(&[
        (0x2104, 2, 2, 10),
        (0x2104, 3, 2, 30),
        (0x2104, 4, 2, 65_535),
    ]);
    assert_eq!(times(&mut all, 60, "0CF02A80"), [30, 60]);
    let once = times(&mut all, 70_000, "0CF02D80");
    assert_eq!(once, [65_535 - 60]);
}
