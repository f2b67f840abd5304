//! The measurement of the IMS360 at the CAN frame level: raw values, filters, fusion, TPDOs and layer setting services.

use crate::tester::canopen::in_g;
use crate::tester::ims360::booted;
use crate::tester::sweep::every;
use plumbline::measure::{Calibration, ONE_G};

#[test]
fn raw_values_are_in_units_of_manual() {
    let mut tester = booted();
    tester.rate = [655_360, -65_536 / 20 - 1, 4_000 << 16];
    tester.temperature = -7_51;
    tester.hold(in_g([0.5, -1.2344, 1.9]), 1);
    let forces = [0x3011, 0x3012, 0x3013].map(|index| tester.read_i32(index));
    assert_eq!(forces, [500, -1234, 1900]);
    let milli = [1, 2, 3].map(|sub| tester.read(0x3010, sub).unwrap() as i16);
    assert_eq!(milli, [500, -1234, 1900]);
    let rates = [0x3021, 0x3022, 0x3023].map(|index| tester.read_i32(index));
    assert_eq!(rates, [10_000, -50, 4_000_000]);
    let tenths = [1, 2, 3].map(|sub| tester.read(0x3020, sub).unwrap() as i16);
    assert_eq!(tenths, [100, -1, i16::MAX], "rounded, limited");
    assert_eq!(tester.read(0x6511, 0).unwrap() as i8, -8);
}

#[test]
fn calibrated_zero_rate_is_in_no_value() {
    let mut tester = booted();
    // 0.5, -1 and 2 deg/s, and 0.01 deg/s/K on X.
    let calibration = Calibration::IDENTITY.with_zero_rate([2048, -4096, 8192], [10_486, 0, 0]);
    tester.calibration = calibration.unwrap();
    tester.power_cycle();
    tester.sent_text();
    tester.rate = [32_768, -65_536, 131_072];
    tester.temperature = 25_00;
    tester.write(0x3110, 2, 1, 1).unwrap();
    tester.settle_at([0.0, 0.0, 1.0]);
    assert_eq!(tester.read_i32(0x6110), 0);
    for (temperature, expected) in [(25_00, [0; 3]), (35_00, [-100, 0, 0])] {
        tester.temperature = temperature;
        tester.sample();
        let rates = [0x3021, 0x3022, 0x3023].map(|index| tester.read_i32(index));
        assert_eq!(rates, expected);
        let tenths = [1, 2, 3].map(|sub| tester.read(0x3020, sub).unwrap() as i16);
        assert_eq!(tenths.map(i32::from), expected.map(|rate| rate / 100));
    }
}

#[test]
fn twenty_objects_can_be_mapped_and_no_other() {
    #[rustfmt::skip]
    let mappable = [
        0x3000_0108, 0x3010_0110, 0x3010_0210, 0x3010_0310, 0x3011_0020, 0x3012_0020, 0x3013_0020,
        0x3020_0110, 0x3020_0210, 0x3020_0310, 0x3021_0020, 0x3022_0020, 0x3023_0020,
        0x6110_0020, 0x6120_0020, 0x6511_0008, 0x3100_0108, 0x3110_0208, 0x3112_0108, 0x3112_0408,
    ];
    let mut tester = booted();
    tester.write(0x1A01, 0, 1, 0).unwrap();
    for entry in mappable {
        assert_eq!(tester.write(0x1A01, 1, 4, entry), Ok(()), "{entry:08X}");
    }
    let near = mappable.map(|entry| entry >> 16);
    let near = near.into_iter().flat_map(|index| index - 1..=index + 1);
    for index in near.chain((0x1000..0x7000_u32).step_by(every(37))) {
        for sub in 0..=8 {
            for bits in [8, 16, 32] {
                let entry = index << 16 | sub << 8 | bits;
                if sub > 0 && !(0x2000..0x3121).contains(&index) || mappable.contains(&entry) {
                    continue;
                }
                assert!(tester.write(0x1A01, 1, 4, entry).is_err(), "{entry:08X}");
            }
        }
    }
}

#[test]
fn example_of_manual_maps_angular_rates() {
    let mut tester = booted();
    tester.rate = [1 << 16, 2 << 16, -(3 << 16)];
    tester.sample();
    // 6.1.3, steps 1 to 6.
    tester.write(0x1801, 1, 4, 0x8000_01B2).unwrap();
    tester.write(0x1A01, 0, 1, 0).unwrap();
    tester.write(0x1A01, 1, 4, 0x3020_0110).unwrap();
    tester.write(0x1A01, 2, 4, 0x3020_0210).unwrap();
    tester.write(0x1A01, 3, 4, 0x3020_0310).unwrap();
    tester.write(0x1A01, 0, 1, 3).unwrap();
    tester.write(0x1801, 1, 4, 0x0000_01B2).unwrap();
    tester.write(0x1801, 5, 2, 100).unwrap();
    tester.send("000#0132");
    let sent = tester.wait_text(250);
    let frame = "1B2#0A001400E2FF".to_string();
    assert_eq!(sent, [(100, frame.clone()), (200, frame)]);
}

/// Turns from -45 to 45 deg about the Y axis within 0.3 s, in samples of 5 ms, with these values of 3110h:02 and of the exponent of Q.
/// Returns the largest error in 0.01 deg.
fn largest_error(fusion: u32, exponent: i8) -> i32 {
    let at = |step: f64| -45.0 + 90.0 * (step / 60.0).clamp(0.0, 1.0);
    let force = |degrees: f64| in_g([-degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()]);
    let mut tester = booted();
    tester.hold(force(-45.0), 400);
    tester.write(0x3112, 2, 1, exponent as u8 as u32).unwrap();
    tester.write(0x3110, 2, 1, fusion).unwrap();
    tester.hold(force(-45.0), 400);
    let mut largest = 0;
    for step in 1..=80 {
        let step = f64::from(step);
        tester.rate = [
            0,
            ((at(step) - at(step - 1.0)) * 200.0 * 65_536.0) as i32,
            0,
        ];
        // The acceleration is older than the angular rate by 10.8 ms.
        tester.hold(force(at(step - 10.799 / 5.0)), 1);
        let error = tester.read_i32(0x6110) - (at(step) * 100.0).round() as i32;
        largest = largest.max(error.abs());
    }
    largest
}

#[test]
fn fusion_follows_rotation_without_delay() {
    assert!(largest_error(0, -3) > 1_000, "low-pass");
    for exponent in [-2, -3, -4] {
        let error = largest_error(1, exponent);
        assert!(error <= 30, "Q = 10^{exponent}: {error}");
    }
}

#[test]
fn angle_does_not_step_when_filter_changes() {
    let mut tester = booted();
    tester.tilt(20.0, 10.0);
    let level = [0, 0, ONE_G];
    tester.hold(level, 40);
    for (index, sub, value) in [
        (0x3110, 2, 1),
        (0x3110, 2, 0),
        (0x3110, 1, 1),
        (0x3110, 1, 2),
        (0x3110, 1, 0),
    ] {
        let before = tester.read_i32(0x6110);
        assert!(before > 0);
        tester.write(index, sub, 1, value).unwrap();
        let after = tester.read_i32(0x6110);
        assert!((after - before).abs() <= 1, "{before} {after}");
        tester.hold(level, 1);
    }
}

#[test]
fn lss_selects_by_identity_and_stores_node_id() {
    let mut tester = booted();
    for (command, number) in [(0x40, 0x195), (0x41, 0x1_869F), (0x42, 0)] {
        let number: u32 = number;
        let [a, b, c, d] = number.to_le_bytes();
        let sent = tester.exchange(&format!(
            "7E5#{command:02X}{a:02X}{b:02X}{c:02X}{d:02X}000000"
        ));
        assert_eq!(sent, [""; 0]);
    }
    assert_eq!(
        tester.exchange("7E5#4301020304000000"),
        ["7E4#4400000000000000"]
    );
    assert_eq!(
        tester.exchange("7E5#1107000000000000"),
        ["7E4#1100000000000000"]
    );
    assert_eq!(
        tester.exchange("7E5#1300020000000000"),
        ["7E4#1300000000000000"]
    );
    assert_eq!(tester.read(0x2002, 0), Ok(7));
    assert_eq!(tester.read(0x2001, 0), Ok(500_000));
    assert_eq!(
        tester.exchange("7E5#1300050000000000"),
        ["7E4#1301000000000000"]
    );
    assert_eq!(
        tester.exchange("7E5#1700000000000000"),
        ["7E4#1700000000000000"]
    );
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["707#00"]);
    tester.node_id = 7;
    assert_eq!(tester.read(0x2001, 0), Ok(500_000));
}

#[test]
fn lss_bit_timing_takes_the_five_rates_of_table_0() {
    let mut t = booted();
    t.send("7E5#0401000000000000");
    let rates = [1_000_000, 800_000, 500_000, 250_000, 125_000];
    for (place, rate) in (0_u8..).zip(rates) {
        let sent = t.exchange(&format!("7E5#1300{place:02X}0000000000"));
        assert_eq!(sent, ["7E4#1300000000000000"]);
        assert_eq!(t.read(0x2001, 0), Ok(rate));
    }
    for other in ["0005", "0006", "0007", "0008", "0009", "0100", "8000"] {
        let sent = t.exchange(&format!("7E5#13{other}0000000000"));
        assert_eq!(sent, ["7E4#1301000000000000"], "{other}");
        assert_eq!(t.read(0x2001, 0), Ok(125_000));
    }
}

#[test]
fn block_upload_sends_name_with_crc() {
    let mut tester = booted();
    let sent = tester.exchange("632#A408100001000000");
    assert_eq!(sent, ["5B2#C608100006000000"]);
    assert_eq!(
        tester.exchange("632#A300000000000000"),
        ["5B2#81494D5333363000"]
    );
}

#[test]
fn event_timer_inhibit_time_and_change_of_value_trigger_tpdos() {
    let mut tester = booted();
    tester.write(0x1800, 2, 1, 255).unwrap();
    tester.write(0x1800, 3, 2, 500).unwrap();
    tester.send("000#0132");
    assert_eq!(
        tester.sent_text(),
        ["1B2#0000000000000000"],
        "at the beginning of operational"
    );
    assert_eq!(tester.wait_text(100), []);
    tester.temperature = 4_000;
    assert_eq!(tester.wait_text(100), [], "not mapped");
    let sent = tester.exchange("632#2310320001000000");
    assert_eq!(sent, ["5B2#6010320000000000", "1B2#0100000000000000"]);
    tester.write(0x3210, 0, 4, 2).unwrap();
    tester.write(0x3210, 0, 4, 3).unwrap();
    let sent = tester.wait_text(100);
    assert_eq!(
        sent,
        [(50, "1B2#0300000000000000".to_string())],
        "inhibit time"
    );
}

#[test]
fn mapped_settings_and_status_are_sent() {
    let mut tester = booted();
    tester.map(
        1,
        &[
            0x3000_0108,
            0x3100_0108,
            0x3112_0408,
            0x3110_0208,
            0x6511_0008,
        ],
    );
    tester.write(0x1801, 2, 1, 1).unwrap();
    tester.send("000#0132");
    assert_eq!(tester.exchange("080#"), ["2B2#0102010019"]);
}

#[test]
fn angle_is_that_of_each_sample_only_with_filter_type_0() {
    let level = in_g([0.0, 0.0, 1.0]);
    let tilted = in_g([0.5, 0.0, 0.866_025]);
    for (kind, expected) in [(0, 2_999..=3_001), (1, 0..=20), (2, 0..=20)] {
        let mut tester = booted();
        // 0.1 Hz.
        tester.write(0x3111, 0, 2, 100).unwrap();
        tester.write(0x3110, 1, 1, kind).unwrap();
        tester.hold(level, 100);
        tester.hold(tilted, 1);
        let angle = tester.read_i32(0x6110).abs();
        assert!(expected.contains(&angle), "type {kind}: {angle}");
    }
}
