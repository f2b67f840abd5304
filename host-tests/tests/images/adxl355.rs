//! The images for an ADXL355: what this part changes, with a product of each range of self-tests. `accelerometer.rs`, `invalid.rs` and
//! `jn2101.rs` have the rest.

use crate::accelerometer_line::{OPEN_LINES, polls_with_bit_errors};
use crate::jn2101;
use crate::rig::*;
use bench::Flash;
use bench::script::LEVEL;
use host_tests::effort;
use host_tests::vibration::{Shaker, check_cutoffs, check_residue};
use plumbline::can::BitRate;
use plumbline::measure::calibration::{Calibration, OFFSET_ONE_G, Part};
use plumbline::model::catalog::find;
use plumbline::store::Store;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::OnceLock;
use stm32_sim::Microcontroller;
use stm32_sim::adxl355::{Adxl355, Fault};
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware;
use stm32_sim::flash::Times;
use stm32_sim::ism330dhcx::Noise;

const RATE: BitRate = BitRate::K500;

/// The sensor error bits of both axes.
const ERRORS: u8 = status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y;

/// The time in ms after which the angles are right with the fastest filter.
const SETTLING: u64 = 300;

/// The first and the last register of the configuration, and the one of them without effect.
const OFFSET_X_H: u8 = 0x1E;
const SELF_TEST: u8 = 0x2E;
const ACT_COUNT: u8 = 0x27;

/// The image of a product for this part.
fn image(name: &str) -> Rc<Image> {
    static FILES: [OnceLock<BTreeMap<String, Vec<u8>>>; Board::ALL.len()] =
        [const { OnceLock::new() }; Board::ALL.len()];
    let place = Board::ALL.iter().position(|one| *one == board());
    let files = FILES[place.expect("all boards")].get_or_init(|| {
        let built = firmware::build_for_element(board(), &["is2", "jn2101"], "adxl355");
        let built = built.unwrap_or_else(|error| panic!("{error}"));
        let read = |path| std::fs::read(path).expect("the image can be read");
        let files = built.into_iter().map(|(name, path)| (name, read(path)));
        files.collect()
    });
    Rc::new(Image::parse(&files[name]).expect("an ELF file"))
}

/// A microcontroller with the part, which has its noise.
fn sensor(name: &str, flash: Flash, motion: Box<dyn bench::motion::Motion>) -> Microcontroller {
    let name = node_type(name).name;
    let sensor = Microcontroller::new(name, image(name), SERIAL, flash, motion);
    sensor.with_silicon(&silicon())
}

/// The memory of an is2 with the fastest filter: Butterworth, 25 Hz.
fn memory() -> Flash {
    let rate = [fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)];
    saved("is2", &[&rate, &[fsc::WRITE_FILTER, 0xA8, 0x61, 1]])
}

/// An is2 with these angles in degrees before its boot.
fn is2(x: f64, y: f64) -> Rig {
    Rig::of(sensor("is2", memory(), tilt("is2", x, y)), RATE)
}

/// The part, and the time in picoseconds.
fn part(rig: &mut Rig) -> (&mut Adxl355, u64) {
    let (io, now) = rig.io();
    (io.adxl355.as_mut().expect("the part"), now)
}

/// The angles of a reply without an error, in 0.01 deg.
#[track_caller]
fn angles(rig: &mut Rig) -> [i16; 2] {
    let reply = rig.poll();
    assert_eq!(reply[1], 0, "{reply:02X?}");
    [2, 4].map(|at| i16::from_le_bytes([reply[at], reply[at + 1]]))
}

/// 10 and 5 degrees. The noise behind 25 Hz is 0.006 deg.
#[track_caller]
fn assert_right(rig: &mut Rig) {
    let [x, y] = angles(rig);
    assert!(x.abs_diff(1000) <= 3 && y.abs_diff(500) <= 3, "{x} {y}");
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
pub fn first_frame_comes_within_100_ms_with_a_right_angle() {
    let mut rig = is2(10.0, 5.0);
    rig.boot_up();
    let start = rig.log[0].start / 1_000_000;
    println!("the first frame starts {start} us after power-up");
    assert!(start < 80_000, "{start} us");
    rig.run(SETTLING);
    assert_right(&mut rig);
}

/// The accuracy of GEMAC up to 60 deg is 0.05 deg. Here it is that of the conversion, with the noise.
#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn angles_are_right_at_each_clock_of_the_part() {
    for (clock, x, y) in [(0.0, 60.0, 0.0), (-5.0, -30.0, 45.0), (4.8, 0.0, -60.0)] {
        let mut rig = is2(x, y);
        part(&mut rig).0.set_clock_deviation(0, clock);
        rig.boot_up();
        // The data rate is measured after 1.3 s.
        for time in [SETTLING, 1500, 3000] {
            rig.run(time);
            let found = angles(&mut rig).map(|angle| f64::from(angle) / 100.0);
            let error = (found[0] - x).abs().max((found[1] - y).abs());
            assert!(error <= 0.05, "{clock} %: {found:?}");
        }
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn vibration_is_suppressed_and_the_cutoff_is_exact_at_each_clock_of_the_part() {
    for clock in [-5.0, 4.8] {
        let mut shaker = Shaker::new(|bus, motion| {
            let flash = fixed("is2", host_tests::vibration::RATE);
            let mut sensor = sensor("is2", flash, motion);
            let part = sensor.io_mut().adxl355.as_mut().expect("the part");
            part.set_noise(Noise::Alternating);
            part.set_clock_deviation(0, clock);
            bus.attach(sensor);
        });
        check_residue(&mut shaker, &[199, 400]);
        shaker.settle();
        check_cutoffs(&mut shaker, &[host_tests::vibration::SHORTEST]);
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
pub fn failure_is_reported_and_cleared_after_recovery() {
    let faults = [
        (Fault::Silent(0xFF), 200),
        (Fault::Silent(0), 200),
        (Fault::Stopped, 200),
        // 32 equal values, then none for 100 ms.
        (Fault::Zeros, 200),
        (Fault::Frozen, 200),
        (Fault::StuckAxis(0), 200),
        (Fault::StuckAxis(2), 200),
        // 60,000 values, then none for 100 ms.
        (Fault::StuckTemperature, 60_200),
    ];
    let mut rig = is2(10.0, 5.0);
    rig.boot_up();
    for (fault, limit) in faults {
        rig.run(SETTLING);
        assert_right(&mut rig);
        let (part, now) = part(&mut rig);
        part.set_fault(now, fault);
        rig.run(limit);
        assert_eq!(rig.poll()[1], ERRORS, "{fault:?}");
        let (part, now) = self::part(&mut rig);
        part.set_fault(now, Fault::None);
        // It must be without an error for 0.5 s; the temperature changes within 1 s.
        rig.run(1_050);
    }
}

/// An erase of a page stalls the processor for 40 ms, and the FIFO holds 32 ms.
#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn values_lost_in_an_erase_are_no_error_and_no_wrong_angle() {
    let mut rig = is2(10.0, 5.0);
    rig.boot_up();
    rig.io().0.flash.set_times(Times::longest(chip()));
    let erased = rig.flash().erased();
    let mut saves = 0;
    while rig.flash().erased() == erased {
        rig.save();
        assert_right(&mut rig);
        saves += 1;
        assert!(saves < 200, "no save has erased a page");
    }
    assert!(part(&mut rig).0.take_overruns() > 0, "values were lost");
    for _ in 0..20 {
        rig.run(10);
        assert_right(&mut rig);
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn part_that_is_another_one_is_an_error_from_the_boot_up_messages_on() {
    // An ADXL359 has the same registers and another range.
    for number in [0xE9, 0x00] {
        let mut rig = is2(10.0, 5.0);
        part(&mut rig).0.set_part(number);
        rig.run(150);
        let sent = rig.frames();
        assert_eq!(sent[0].bytes()[1], ERRORS, "{sent:?}");
        assert_eq!(rig.poll()[1], ERRORS);
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn part_that_starts_badly_is_reset_again() {
    let mut rig = is2(10.0, 5.0);
    part(&mut rig).0.set_bad_starts(2);
    rig.boot_up();
    assert_eq!(rig.poll()[1], 0);
    rig.run(SETTLING);
    assert_right(&mut rig);
}

/// Polls for this time in ms; each angle must be right.
#[track_caller]
fn stays_right(rig: &mut Rig, ms: u64, name: &str) {
    for passed in (0..ms).step_by(5) {
        let [x, y] = angles(rig);
        let is_right = x.abs_diff(1000) <= 4 && y.abs_diff(500) <= 4;
        assert!(is_right, "{name}: {x} {y} after {passed} ms");
        rig.run(4);
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
pub fn disturbed_register_is_restored_without_a_wrong_angle() {
    let mut rig = is2(10.0, 5.0);
    rig.boot_up();
    rig.run(SETTLING);
    let registers = (OFFSET_X_H..=SELF_TEST).filter(|register| *register != ACT_COUNT);
    for (register, bit) in registers.flat_map(|register| (0..8).map(move |bit| (register, bit))) {
        let name = format!("register {register:02X}h, bit {bit}");
        let (part, now) = part(&mut rig);
        let before = part.register(register);
        part.disturb(now, register, 1 << bit);
        stays_right(&mut rig, 120, &name);
        assert_eq!(self::part(&mut rig).0.register(register), before, "{name}");
    }
    let (part, now) = part(&mut rig);
    part.power_on(now);
    stays_right(&mut rig, 500, "reset of the part");
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn random_bit_errors_are_reported_or_leave_the_angle_right() {
    // The probability of a wrong bit, and the latest report in ms.
    let rates = [(1e-2, 250), (1e-3, 400), (1e-4, 4_000), (1e-5, u64::MAX)];
    for (rate, latest) in rates {
        for seed in 0..effort::choose(2, 20) {
            let mut rig = is2(10.0, 5.0);
            rig.boot_up();
            rig.run(SETTLING);
            part(&mut rig).0.set_bit_error_rate(rate, seed);
            let name = format!("{rate:e}, seed {seed}");
            let reported = polls_with_bit_errors(&mut rig, 10_000, &name);
            println!("{name}: reported after {reported:?} ms");
            let in_time = reported.is_some_and(|time| time <= latest);
            assert!(in_time || latest == u64::MAX, "{name}: {reported:?}");
        }
    }
}

/// An open line reads as FFh, because it has a pull-up. A short to ground for the end of a value and the begin of the next one is not found.
#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn line_that_is_open_for_a_moment_is_reported_or_leaves_the_angle_right() {
    let mut rig = is2(10.0, 5.0);
    rig.boot_up();
    rig.run(SETTLING);
    let cases = OPEN_LINES.iter().filter(|(level, _)| *level == 0xFF);
    let share = effort::choose(6, 1);
    for skipped in 0..75 {
        for (number, (level, count)) in cases.clone().enumerate() {
            if !(skipped as usize + number).is_multiple_of(share) {
                continue;
            }
            part(&mut rig).0.open_line(skipped, *count, *level);
            let name = format!("{level:02X}h in {count} bytes after {skipped}");
            polls_with_bit_errors(&mut rig, 150, &name);
            // Until an error is a single one again.
            rig.run(1_200);
        }
    }
}

/// A calibration of this part with an offset of 0.1 g in X, or of the other one.
#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn calibration_of_another_part_is_not_used() {
    let calibration = Calibration::new([OFFSET_ONE_G / 10, 0, 0], [[0; 3]; 3], [0; 3]);
    let calibration = calibration.expect("within the ranges");
    for (of, expected) in [(Part::Ism330dhcx, 0), (Part::Adxl355, 574)] {
        let owner = find("is2").expect("a product").owner(SERIAL);
        let mut store = Store::<Flash, [u8; bench::STORE_BUFFER]>::open(memory(), owner);
        store.calibrate(&calibration.of(of));
        while store.step().is_none() {}
        let sensor = sensor("is2", store.into_memory(), tilt("is2", 0.0, 0.0));
        let mut rig = Rig::of(sensor, RATE);
        rig.boot_up();
        rig.run(SETTLING);
        let [x, _] = angles(&mut rig);
        assert!(x.unsigned_abs().abs_diff(expected) <= 3, "{of:?}: {x}");
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
pub fn self_test_reports_the_working_axes() {
    for (works, register) in [(true, 0b110), (false, 0)] {
        let mut bench = jn2101::Bench::of(sensor("jn2101", blank(), Box::new(LEVEL)));
        let io = bench.chip_mut().io_mut();
        io.adxl355
            .as_mut()
            .expect("the part")
            .set_self_test_works(works);
        bench.exchange("000#010A");
        bench.download(0x4004, 1, [1]);
        assert_eq!(bench.upload(0x4004, 1), 1, "the self-test runs");
        let emergencies = bench.wait(2500);
        assert_eq!(bench.upload(0x4004, 1), 0);
        assert_eq!(bench.upload(0x4004, 2), register);
        let expected = if works {
            &[][..]
        } else {
            &["08A#0010010100000000"]
        };
        assert_eq!(emergencies, expected);
        assert_eq!(
            bench.exchange("080#")[0],
            "18A#00000000",
            "it measures again"
        );
    }
}

#[test]
#[ignore = "another measuring element: `.ci/long ignored`"]
fn product_with_a_gyroscope_does_not_compile_with_this_part() {
    let error = firmware::build_for_element(board(), &["ims360"], "adxl355").unwrap_err();
    assert!(error.to_string().contains("cargo build"), "{error}");
}
