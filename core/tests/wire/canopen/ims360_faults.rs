//! The faults of the IMS360 at the CAN frame level: emergency messages, error register, LEDs and bus-off, compared with tables 1 to 3
//! and 8 of the user manual "IMS360 CANopen".

use crate::tester::ims360::{Ims360Tester, booted, with_memory};
use crate::tester::leds;
use plumbline::measure::ONE_G;
use plumbline::node::{Action, BusEvent, BusState};

#[test]
fn supply_outside_its_limits_is_reported_with_hysteresis() {
    let mut tester = booted();
    for (millivolts, message) in [
        (24_000, None),
        (8_000, None),
        (7_990, Some("0B2#0031010000000000")),
        (8_490, None),
        (8_510, Some("0B2#0000000000000000")),
        (36_000, None),
        (36_010, Some("0B2#0031010000000000")),
        (35_510, None),
        (35_490, Some("0B2#0000000000000000")),
    ] {
        tester.supply(millivolts);
        let expected: Vec<_> = message.into_iter().collect();
        assert_eq!(tester.sent_text(), expected, "{millivolts} mV");
        tester.sample();
        let voltage = tester.read(0x2020, 1).unwrap();
        assert!(voltage.abs_diff(millivolts.into()) <= 1, "{voltage}");
    }
}

#[test]
fn clipping_is_out_of_range_on_both_axes_while_angle_is_sent() {
    let mut tester = booted();
    tester.clip(20);
    assert_eq!(tester.sent_text(), [""; 0], "100 ms");
    tester.clip(1);
    let begin = ["0B2#1050810000000000", "0B2#2050810000000000"];
    assert_eq!(tester.sent_text(), begin);
    assert_eq!(tester.read(0x1001, 0), Ok(0x81));
    assert_eq!(tester.read(0x6110, 0), Ok(0));
    assert_eq!(tester.wait_text(990), [], "at most one change in a second");
    let sent = tester.wait_text(15);
    let sent: Vec<_> = sent.iter().map(|(_, text)| &text[..]).collect();
    assert_eq!(sent, ["0B2#0000810000000000", "0B2#0000000000000000"]);
}

#[test]
fn repeated_clipping_changes_a_code_at_most_once_a_second() {
    let mut tester = booted();
    let mut messages = 0;
    for _ in 0..25 {
        for (clipped, ms) in [(true, 120), (false, 280)] {
            tester.clipped = clipped;
            messages += tester.wait(ms).len();
        }
    }
    // Two codes in 10 s.
    assert!((4..=22).contains(&messages), "{messages}");
    // 20 ms twice a second are no clipping.
    let mut tester = booted();
    for _ in 0..20 {
        for (clipped, ms) in [(true, 20), (false, 480)] {
            tester.clipped = clipped;
            assert_eq!(tester.wait(ms), []);
        }
    }
}

/// 3 g along the vertical for 20 ms, twice a second, at 30 deg.
#[test]
fn repeated_shocks_of_3_g_change_neither_codes_nor_angle() {
    let mut tester = booted();
    tester.tilt(30.0, 0.0);
    let still = tester.force;
    for _ in 0..20 {
        for (factor, ms) in [(4, 20), (1, 480)] {
            tester.force = still.map(|component| component * factor);
            assert_eq!(tester.wait(ms), []);
            assert!((tester.read_i32(0x6110) - 3_000).abs() <= 1);
        }
    }
}

#[test]
fn implausible_acceleration_is_that_of_defective_sensors() {
    let begin = ["0B2#01FF810000000000", "0B2#02FF810000000000"];
    let mut tester = booted();
    tester.hold([0, 0, ONE_G / 4], 120);
    assert_eq!(tester.sent_text(), begin);
    assert_eq!(tester.read(0x3000, 1), Ok(7), "ST0 bit 1");
    tester.hold([0, 0, ONE_G], 120);
    let end = ["0B2#0000810000000000", "0B2#0000000000000000"];
    assert_eq!(tester.sent_text(), end);
    tester.force = [0; 3];
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [&["732#00"][..], &begin].concat());
}

#[test]
fn sensor_on_its_back_is_out_of_range_on_both_axes() {
    let mut tester = booted();
    tester.settle_at([0.0, 0.5, -0.8]);
    let begin = ["0B2#1050810000000000", "0B2#2050810000000000"];
    assert_eq!(tester.sent_text(), begin);
    tester.settle_at([0.0, 1.0, 0.01]);
    assert_eq!(tester.wait_text(1100), [], "until 0.02 g");
    tester.settle_at([0.0, 1.0, 0.03]);
    assert_eq!(tester.sent_text().len(), 2);
}

#[test]
fn angle_beyond_90_deg_with_offset_is_out_of_range() {
    let mut tester = booted();
    tester.write(0x3220, 0, 4, 9_000).unwrap();
    assert_eq!(tester.sent_text(), [""; 0]);
    let sent = tester.exchange("632#2320320029230000");
    assert_eq!(sent, ["5B2#6020320000000000", "0B2#2050810000000000"]);
    let sent = tester.exchange("632#23203200D8DCFFFF");
    assert_eq!(sent.len(), 1, "a code changes at most once a second");
    let sent = tester.wait_text(1005);
    let sent: Vec<_> = sent.iter().map(|(_, text)| &text[..]).collect();
    assert_eq!(sent, ["0B2#0000000000000000"]);
    tester.write(0x3210, 0, 4, -9_000_i32 as u32).unwrap();
    assert_eq!(tester.sent_text(), [""; 0]);
}

#[test]
fn missing_samples_are_defective_sensors() {
    let mut tester = booted();
    let sent = tester.wait_without_samples(150);
    let sent: Vec<_> = sent.iter().map(|(_, frame)| format!("{frame:?}")).collect();
    assert_eq!(sent, ["0B2#01FF810000000000", "0B2#02FF810000000000"]);
    assert_eq!(tester.read(0x3000, 1), Ok(7), "ST0 bit 1");
    tester.sample();
    assert_eq!(
        tester.sent_text(),
        ["0B2#0000810000000000", "0B2#0000000000000000"]
    );
    assert_eq!(tester.read(0x3000, 1), Ok(5));
}

/// A sensor whose variant in force has one axis.
fn one_axis() -> Ims360Tester {
    let mut tester = booted();
    tester.write(0x3120, 1, 1, 0).unwrap();
    tester.store();
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["732#00"]);
    tester
}

#[test]
fn one_axis_sensor_that_clips_has_both_codes() {
    let mut tester = one_axis();
    tester.clip(21);
    let both = ["0B2#1050810000000000", "0B2#2050810000000000"];
    assert_eq!(tester.sent_text(), both);
}

#[test]
fn one_axis_sensor_has_no_lateral_fault() {
    let mut tester = one_axis();
    tester.write(0x3210, 0, 4, 20_000).unwrap();
    assert_eq!(tester.sent_text(), [""; 0], "360 deg have no limit");
    let sent = tester.wait_without_samples(150);
    let sent: Vec<_> = sent.iter().map(|(_, frame)| format!("{frame:?}")).collect();
    assert_eq!(sent, ["0B2#01FF810000000000"]);
}

#[test]
fn overrun_and_bus_off_are_momentary() {
    let mut tester = booted();
    tester.bus(BusEvent::Overrun);
    let overrun = ["0B2#1081110000000000", "0B2#0000000000000000"];
    assert_eq!(tester.sent_text(), overrun);
    tester.send("000#0132");
    tester.bus(BusEvent::State(BusState::BusOff));
    assert!(tester.actions.contains(&Action::Recover));
    assert_eq!(tester.sent_text(), [""; 0]);
    assert_eq!(tester.leds, leds(true, true));
    tester.bus(BusEvent::State(BusState::Active));
    let recovered = ["0B2#14FF110000000000", "0B2#0000000000000000"];
    assert_eq!(tester.sent_text(), recovered, "no boot-up");
    assert_eq!(tester.read(0x1001, 0), Ok(0));
    assert_eq!(tester.read(0x1003, 0), Ok(2));
    assert_eq!(tester.read(0x1003, 1), Ok(0xFF14));
    assert_eq!(tester.read(0x1003, 2), Ok(0x8110));
    tester.write(0x1017, 0, 2, 10).unwrap();
    assert_eq!(
        tester.wait_text(10),
        [(10, "732#05".to_string())],
        "still operational"
    );
}

#[test]
fn error_passive_lasts() {
    let mut tester = booted();
    tester.bus(BusEvent::State(BusState::Passive));
    assert_eq!(tester.sent_text(), ["0B2#2081110000000000"]);
    assert_eq!(tester.read(0x1001, 0), Ok(0x11));
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.sent_text(), ["0B2#0000000000000000"]);
}

#[test]
fn bus_off_without_recovery_lasts_until_power_up() {
    let mut tester = booted();
    tester.write(0x3100, 2, 1, 0).unwrap();
    tester.bus(BusEvent::State(BusState::BusOff));
    assert!(!tester.actions.contains(&Action::Recover));
    assert_eq!(tester.wait_text(1000), []);
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["732#00"]);
}

#[test]
fn faults_are_announced_after_stopped_and_after_boot_up() {
    let mut tester = booted();
    tester.send("000#0232");
    tester.supply(5_000);
    assert_eq!(tester.sent_text(), [""; 0]);
    assert_eq!(tester.exchange("000#8032"), ["0B2#0031010000000000"]);
    for reset in ["000#8232", "000#8132"] {
        assert_eq!(tester.exchange(reset), ["732#00", "0B2#0031010000000000"]);
    }
    assert_eq!(tester.write(0x1014, 0, 4, 0x8000_00B2), Ok(()));
    tester.supply(24_000);
    assert_eq!(tester.sent_text(), [""; 0]);
}

#[test]
fn stored_mapping_that_does_not_fit_switches_its_tpdo_off() {
    let mut tester = booted();
    tester.store();
    let mut image = tester.memory.clone().unwrap();
    let entry = 0x6110_0020_u32.to_le_bytes();
    let place = image.windows(4).position(|bytes| bytes == entry).unwrap();
    image[place..place + 4].copy_from_slice(&0x6111_0008_u32.to_le_bytes());
    let mut tester = with_memory(Some(&image));
    assert_eq!(tester.sent_text(), ["732#00", "0B2#00FF810000000000"]);
    assert_eq!(tester.read(0x1800, 1), Ok(0x8000_01B2));
    assert_eq!(tester.read(0x1A00, 0), Ok(0));
    assert_eq!(tester.read(0x1A00, 1), Ok(0));
}

#[test]
fn leds_show_nmt_states_and_warning_limit() {
    let mut tester = booted();
    // The green LED at 20, 60, 100 ms and so on.
    let green = |tester: &mut Ims360Tester| {
        tester.wait(20);
        let lit = (0..30).map(|_| {
            let lit = tester.leds.run;
            tester.wait(40);
            lit
        });
        lit.collect::<Vec<_>>()
    };
    let blinking: Vec<_> = (0..30).map(|place| place / 5 % 2 == 0).collect();
    assert_eq!(green(&mut tester), blinking, "pre-operational");
    tester.send("000#0132");
    tester.sent();
    assert!(green(&mut tester).iter().all(|on| *on), "operational: on");
    tester.send("000#0232");
    let stopped = green(&mut tester);
    assert_eq!(
        stopped.iter().filter(|on| **on).count(),
        5,
        "200 of 1200 ms"
    );
    tester.bus(BusEvent::State(BusState::Warning));
    let red = (0..30)
        .filter(|_| {
            tester.wait(40);
            tester.leds.error
        })
        .count();
    assert_eq!(red, 5, "single flash");
}

#[test]
fn guarding_request_is_not_answered() {
    let mut tester = booted();
    assert_eq!(tester.exchange("732#R1"), [""; 0]);
}

#[test]
fn filter_begins_again_after_missing_samples() {
    let mut tester = booted();
    tester.hold([ONE_G, 0, ONE_G], 100);
    assert_ne!(tester.read_i32(0x6110), 0);
    tester.wait_without_samples(200);
    tester.hold([0, 0, ONE_G], 2);
    tester.sent_text();
    assert_eq!(tester.read_i32(0x6110), 0);
}
