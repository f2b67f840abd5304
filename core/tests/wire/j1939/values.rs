//! The process data of the IMS360 in J1939 against formulas in double precision: every offset, angles, turn rates, accelerations,
//! latencies (S30 to S36).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{claimed, claimed_with};
use crate::tester::sweep::every;
use std::f64::consts::PI;

const SSI2: &str = "29F000";
const SSI: &str = "13F000";
const ARI: &str = "2AF000";
const ACCS: &str = "2DF000";

/// 1-axis (3120h:01 = 0).
const ONE_AXIS: (u16, u8, u8, u32) = (0x3120, 1, 1, 0);

/// The values of a figure of merit.
const GOOD: u64 = 0;
const DEGRADED: u64 = 1;
const NOT_AVAILABLE: u64 = 3;

/// The data of a group as a number, least significant byte first.
fn group(tester: &mut Ims360Tester, pgn: &str) -> u64 {
    let sent = tester.request_group("80", pgn);
    // Trouble codes can be sent at the same time.
    let head = format!("0C{}{}80#", &pgn[2..4], &pgn[..2]);
    let data = sent.iter().find_map(|text| text.strip_prefix(&head));
    let data = data.unwrap_or_else(|| panic!("{sent:?}"));
    u64::from_str_radix(data, 16).unwrap().swap_bytes()
}

/// The bits of a number from `first` on.
fn bits(data: u64, first: u32, count: u32) -> u64 {
    data >> first & ((1 << count) - 1)
}

/// A field with a value: its bits, the value of one bit, and the value of the number 0.
#[derive(Clone, Copy)]
struct Scale {
    bits: u32,
    per_bit: f64,
    offset: f64,
}

const FINE: Scale = scale(24, 1.0 / 32_768.0, -250.0);
const COARSE: Scale = scale(16, 0.002, -64.0);
const RATE: Scale = scale(16, 1.0 / 128.0, -250.0);
const ACCELERATION: Scale = scale(16, 0.01, -320.0);

const fn scale(bits: u32, per_bit: f64, offset: f64) -> Scale {
    Scale {
        bits,
        per_bit,
        offset,
    }
}

impl Scale {
    /// The number of a value; None if the field has no number for it (S34).
    fn raw(self, value: f64) -> Option<u64> {
        let number = ((value - self.offset) / self.per_bit).round();
        let valid = 0.0..f64::from(0xFB_u32 << (self.bits - 8));
        valid.contains(&number).then_some(number as u64)
    }

    /// The figure of merit of a value that is `merit` if it can be sent.
    fn merit(self, value: Option<f64>, merit: u64) -> u64 {
        match value.and_then(|value| self.raw(value)) {
            Some(_) => merit,
            None => NOT_AVAILABLE,
        }
    }

    /// Checks the field from bit `first` on. The number may differ by `tolerance`.
    #[track_caller]
    fn check(self, data: u64, first: u32, value: Option<f64>, tolerance: u64) {
        let got = bits(data, first, self.bits);
        let Some(raw) = value.and_then(|value| self.raw(value)) else {
            assert_eq!(got, (1 << self.bits) - 1, "{data:016X}: {value:?}");
            return;
        };
        assert!(
            got.abs_diff(raw) <= tolerance && got < 0xFB << (self.bits - 8),
            "{data:016X}: {value:?} is {got:X}, not {raw:X}"
        );
    }
}

/// Checks SSI2 and SSI with these angles, their figures of merit if they can be sent, and the pitch rate.
#[track_caller]
fn check_slopes(
    tester: &mut Ims360Tester,
    angles: [Option<f64>; 2],
    merits: [u64; 2],
    rate: f64,
    tolerance: u64,
) {
    let data = group(tester, SSI2);
    let [pitch, roll] = angles;
    FINE.check(data, 0, pitch, tolerance);
    FINE.check(data, 24, roll, tolerance);
    let quality = |scale: Scale| [scale.merit(pitch, merits[0]), scale.merit(roll, merits[1])];
    // Compensation is always 3, not available.
    let [first, second] = quality(FINE);
    assert_eq!(bits(data, 48, 8), 3 | first << 2 | 3 << 4 | second << 6);
    let data = group(tester, SSI);
    let tolerance = tolerance.min(1);
    COARSE.check(data, 0, pitch, tolerance);
    COARSE.check(data, 16, roll, tolerance);
    COARSE.check(data, 32, Some(rate), 1);
    let [first, second] = quality(COARSE);
    let third = COARSE.merit(Some(rate), GOOD);
    let expected = first | second << 2 | third << 4 | 3 << 6;
    assert_eq!(bits(data, 48, 8), expected, "{data:016X}");
}

#[track_caller]
fn check_vector(tester: &mut Ims360Tester, pgn: &str, scale: Scale, values: [f64; 3]) {
    let data = group(tester, pgn);
    for (place, value) in (0..).zip(values) {
        scale.check(data, 16 * place, Some(value), 1);
        assert_eq!(bits(data, 48 + 2 * place, 2), GOOD, "{data:016X}");
    }
    // Compensation and latency are not available.
    assert_eq!(bits(data, 54, 10), 0x3FF);
}

/// Writes 3210h and 3220h in 0.01 deg.
fn offsets(tester: &mut Ims360Tester, values: [i32; 2]) {
    for (object, value) in ["10", "20"].into_iter().zip(values) {
        let data = value.cast_unsigned().swap_bytes();
        let sent = tester.exchange(&format!("18EF8021#23{object}3200{data:08X}"));
        assert_eq!(sent[0], format!("18EF2180#60{object}320000000000"));
    }
}

#[test]
fn every_offset_of_two_axes_is_sent_with_its_figure_of_merit() {
    let mut tester = claimed();
    let limits = (8_990..=9_010).chain(-9_010..=-8_990);
    let last = [i32::MIN, i32::MAX, 100_000, -100_000];
    let all = (-27_000..=27_000).step_by(every(61));
    let mut before = [GOOD; 2];
    for offset in all.chain(limits).chain(last) {
        let pair = [offset, offset.saturating_neg() / 2];
        offsets(&mut tester, pair);
        // +-90 deg are within the range (S36).
        let merits = pair.map(|value| match value.abs_diff(0) {
            0..=9000 => GOOD,
            _ => DEGRADED,
        });
        if merits != before {
            // They change at most once a second.
            tester.wait(1000);
            before = merits;
        }
        let angles = pair.map(|value| Some(f64::from(value) / 100.0));
        check_slopes(&mut tester, angles, merits, 0.0, 0);
    }
}

#[test]
fn every_offset_of_one_axis_is_sent_from_minus_180_to_180_deg() {
    let mut tester = claimed_with(&[ONE_AXIS]);
    tester.settle_at([0.0, 1.0, 0.0]);
    let last = [i32::MIN, i32::MAX, 40_000, -40_001];
    for offset in (-36_001..=36_001).step_by(3 * every(23)).chain(last) {
        // The lateral offset has no effect (S61).
        offsets(&mut tester, [offset, 20_000]);
        let angle = (i64::from(offset) + 18_000).rem_euclid(36_000) - 18_000;
        let angle = angle as f64 / 100.0;
        check_slopes(&mut tester, [Some(angle), None], [GOOD; 2], 0.0, 1);
    }
}

#[test]
fn angles_and_accelerations_of_two_axes_are_sent() {
    let fixed = [
        (12.34, -5.0),
        (-89.5, 0.2),
        (30.0, 0.0),
        (0.0, -30.0),
        (63.99, 0.0),
        (-63.99, 0.0),
        (64.4, 0.0),
        (64.6, 0.0),
        (-64.1, 0.0),
        (0.0, 64.4),
        (0.0, 64.6),
        (0.0, -64.1),
        (89.9, 0.0),
        (0.0, -89.9),
        (0.01, -0.01),
        (45.0, 44.0),
        (-44.0, 44.0),
    ];
    let grid =
        (-8..=8).flat_map(|x| (-8..=8).map(move |y| (11.03 * f64::from(x), 10.97 * f64::from(y))));
    let grid = grid.filter(|(x, y)| x.abs() + y.abs() < 89.0);
    let mut tester = claimed();
    for (pitch, roll) in fixed.into_iter().chain(grid) {
        tester.tilt(pitch, roll);
        // A trouble code at the range of 90 deg is not expected.
        check_slopes(&mut tester, [Some(pitch), Some(roll)], [GOOD; 2], 0.0, 2);
        let (x, y) = (-pitch.to_radians().sin(), roll.to_radians().sin());
        let up = [y, x, (1.0 - x * x - y * y).sqrt()];
        check_vector(&mut tester, ACCS, ACCELERATION, up.map(|one| one * 9.80665));
    }
}

#[test]
fn angle_of_one_axis_is_sent_with_the_rate_about_its_axis() {
    let turns = [
        [0.0; 3],
        [3.0, -4.0, 20.0],
        [0.0, 0.0, -15.0],
        [10.0, 0.0, 0.0],
    ];
    let mut tester = claimed_with(&[ONE_AXIS]);
    for (number, turn) in (0..120).zip(turns.into_iter().cycle()) {
        let angle = 3.0 * f64::from(number) + 0.34;
        let cross = 10.0 * f64::from(number % 3);
        let (sin, cos) = angle.to_radians().sin_cos();
        let plane = cross.to_radians().cos();
        tester.rate = turn.map(|one| (one * 65_536.0) as i32);
        tester.settle_at([sin * plane, cos * plane, cross.to_radians().sin()]);
        let pitch = if angle < 180.0 { angle } else { angle - 360.0 };
        check_slopes(&mut tester, [Some(pitch), None], [GOOD; 2], turn[2], 2);
        let [x, y, z] = turn;
        check_vector(&mut tester, ARI, RATE, [z, x, y]);
    }
}

#[test]
fn turn_rates_are_sent_with_the_axis_and_the_sign_of_their_angle() {
    let mut tester = claimed();
    let ends = [63.9, 64.45, 64.6, -63.9, -64.1, 240.0, -240.0];
    let steps = (-60..=60).map(|step| f64::from(step) * 1.07);
    for turn in ends.into_iter().chain(steps) {
        for axis in 0..3 {
            let mut rate = [1.0, -2.0, 3.0];
            rate[axis] = turn;
            tester.rate = rate.map(|one| (one * 65_536.0) as i32);
            tester.sample();
            let [x, y, z] = rate;
            check_vector(&mut tester, ARI, RATE, [y, x, z]);
            check_slopes(&mut tester, [Some(0.0); 2], [GOOD; 2], y, 0);
        }
    }
}

#[test]
fn latency_of_every_cut_off_frequency_is_sent() {
    let mut tester = claimed();
    // Kind (3110h:01), the sum of the dampings of its sections, the factor of its cut-off frequency, and the highest frequency.
    let factor = (2_f64.powf(0.125) - 1.0).powf(-0.5);
    for (kind, damping, factor, highest) in [(1, 5.125_83, 1.0, 25_000_u16), (2, 8.0, factor, 8000)]
    {
        tester.parameter("2B113100D0070000");
        let reply = tester.parameter(&format!("2F103101{kind:02X}000000"));
        assert_eq!(reply, "6010310100000000");
        for frequency in (100..=highest).step_by(every(31)) {
            let [low, high] = frequency.to_le_bytes();
            tester.parameter(&format!("2B113100{low:02X}{high:02X}0000"));
            // The digital filter takes 200 samples in a second.
            let turn = (PI * f64::from(frequency) / 200_000.0).tan();
            let delay = 16.7 + 2.5 * damping / (factor * turn);
            // 0.5 ms; more than 125 ms cannot be sent. The sensor calculates with an error below 0.1 ms.
            if (delay - 125.0).abs() < 0.1 {
                continue;
            }
            let expected = if delay > 125.0 { 255.0 } else { delay * 2.0 };
            for pgn in [SSI2, SSI] {
                let data = group(&mut tester, pgn);
                let got = bits(data, 56, 8) as f64;
                assert!((got - expected).abs() < 0.55, "{frequency} mHz: {got}");
            }
        }
    }
    // No low-pass, and the Kalman filter.
    for (write, expected) in [("2F10310100000000", 33), ("2F10310201000000", 13)] {
        tester.parameter(write);
        for pgn in [SSI2, SSI] {
            assert_eq!(bits(group(&mut tester, pgn), 56, 8), expected);
        }
    }
    tester.parameter("2F10310200000000");
    tester.parameter("2B113100401F0000");
    tester.parameter("2F10310102000000");
    assert_eq!(bits(group(&mut tester, SSI2), 56, 8), 0x81);
}

#[test]
fn angles_are_degraded_while_the_accelerometer_clips() {
    for (objects, ssi2, ssi) in [
        (&[][..], [0x33, 0x77], [0xC0, 0xC5]),
        (&[ONE_AXIS], [0xF3, 0xF7], [0xCC, 0xCD]),
    ] {
        let mut tester = claimed_with(objects);
        tester.settle_at([0.0, 0.6, 0.8]);
        let before = [SSI2, SSI].map(|pgn| group(&mut tester, pgn));
        // From 100 ms on, for a second at least.
        for (clipped, ms, place) in [(20, 0, 0), (1, 0, 1), (0, 990, 1), (0, 20, 0)] {
            tester.clip(clipped);
            tester.wait(ms);
            let after = [SSI2, SSI].map(|pgn| group(&mut tester, pgn));
            assert_eq!(bits(after[0], 48, 8), ssi2[place], "{clipped} {ms}");
            assert_eq!(bits(after[1], 48, 8), ssi[place], "{clipped} {ms}");
            for (before, after) in before.into_iter().zip(after) {
                assert_eq!(bits(before, 0, 48), bits(after, 0, 48), "the values");
            }
            assert_eq!(bits(group(&mut tester, ACCS), 48, 8), 0xC0);
        }
    }
}
