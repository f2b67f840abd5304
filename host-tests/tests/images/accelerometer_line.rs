//! Errors on the line from the accelerometer, at places that nothing knows: wrong bits, and an open contact.

use crate::accelerometer::{ERRORS, quick};
use crate::accelerometer_faults::is_within;
use crate::rig::*;
use host_tests::effort;
use stm32_sim::ism330dhcx::Noise;

/// Polls for this time in ms while bits are wrong. Each reply has an error, or angles within the noise (0.07 degrees) and what is left of a
/// wrong bit (0.06 degrees). Returns the time of the first error in ms.
#[track_caller]
pub fn polls_with_bit_errors(rig: &mut Rig, ms: u64, name: &str) -> Option<u64> {
    let mut reported = None;
    for passed in (0..ms).step_by(5) {
        let reply = rig.poll();
        if reply[1] != 0 {
            assert_eq!(reply[1], ERRORS, "{name}: {reply:02X?}");
            reported = reported.or(Some(passed));
        } else {
            assert!(
                is_within(&reply, 15),
                "{name}: {reply:02X?} after {passed} ms"
            );
        }
        rig.run(4);
    }
    reported
}

/// Random errors in all that the accelerometer sends, with its noise, behind the fastest filter.
#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
fn random_bit_errors_are_reported_or_leave_the_angle_right() {
    // The probability of a wrong bit, and the latest report in ms.
    let rates = [(1e-2, 250), (1e-3, 400), (1e-4, 4_000), (1e-5, u64::MAX)];
    for (rate, latest) in rates {
        for seed in 0..effort::choose(2, 20) {
            let mut rig = quick();
            let io = rig.io().0;
            io.imu.set_noise(Noise::Real);
            io.imu.set_bit_error_rate(rate, seed);
            let name = format!("{rate:e}, seed {seed}");
            let reported = polls_with_bit_errors(&mut rig, 10_000, &name);
            println!("{name}: reported after {reported:?} ms");
            let in_time = reported.is_some_and(|time| time <= latest);
            assert!(in_time || latest == u64::MAX, "{name}: {reported:?}");
        }
    }
}

/// What a line reads as whose contact is open for a moment, and for how many bytes.
pub const OPEN_LINES: [(u8, u32); 12] = [
    (0xFF, 1),
    (0xFF, 2),
    (0xFF, 3),
    (0xFF, 5),
    (0xFF, 8),
    (0xFF, 40),
    (0x00, 1),
    (0x00, 2),
    (0x00, 3),
    (0x00, 5),
    (0x00, 8),
    (0x00, 40),
];

/// Beginning with each byte of a reading.
#[test]
fn line_that_is_open_for_a_moment_is_reported_or_leaves_the_angle_right() {
    let mut rig = quick();
    // A normal run has one of the cases at each place.
    let share = effort::choose(OPEN_LINES.len(), 1);
    for skipped in 0..45 {
        for (number, (level, count)) in OPEN_LINES.into_iter().enumerate() {
            if !(skipped as usize + number).is_multiple_of(share) {
                continue;
            }
            rig.io().0.imu.open_line(skipped, count, level);
            let name = format!("{level:02X}h in {count} bytes after {skipped}");
            polls_with_bit_errors(&mut rig, 150, &name);
            // Until an error is a single one again.
            rig.run(1_200);
        }
    }
}
