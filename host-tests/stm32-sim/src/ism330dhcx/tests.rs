mod faults;

use super::super::timebase::SECOND;
use super::*;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::Instant;
use std::cell::Cell;
use std::rc::Rc;

const MILLISECOND: Picoseconds = SECOND / 1000;

/// 416 Hz at 2 g, without LPF2.
const ON: u8 = 0x60;

/// A part at rest with the acceleration of the test in 10^-6 g.
#[derive(Clone, Default)]
struct Still(Rc<Cell<[i32; 3]>>);

impl Motion for Still {
    fn reading(&mut self, _: Instant) -> Reading {
        let [x, y, z] = self
            .0
            .get()
            .map(|part| (f64::from(part) * 1e-6 * f64::from(ONE_G)).round() as i32);
        Reading {
            acceleration: I32x3 { x, y, z },
            angular_rate: I32x3 {
                x: 10 << 16,
                y: -100 * 65536,
                z: 0,
            },
            temperature: 3550,
            clipped: false,
        }
    }
}

struct Bench {
    part: Ism330dhcx,
    motion: Still,
    now: Picoseconds,
}

impl Bench {
    fn new() -> Self {
        let motion = Still::default();
        motion.0.set([0, -8192 * 61, 16_384 * 61]);
        let mut part = Ism330dhcx::new(Box::new(motion.clone()));
        part.set_noise(Noise::None);
        Self {
            part,
            motion,
            now: 20 * MILLISECOND,
        }
    }

    fn read<const N: usize>(&mut self, register: u8) -> [u8; N] {
        self.part.select(self.now, true);
        self.part.transfer(self.now, register | 0x80);
        let bytes = [(); N].map(|()| self.part.transfer(self.now, 0));
        self.part.select(self.now, false);
        bytes
    }

    fn write(&mut self, register: u8, bytes: &[u8]) {
        self.part.select(self.now, true);
        self.part.transfer(self.now, register);
        for &byte in bytes {
            self.part.transfer(self.now, byte);
        }
        self.part.select(self.now, false);
    }

    fn acceleration(&mut self) -> [i16; 3] {
        let bytes = self.read::<6>(0x28);
        [0, 2, 4].map(|at| i16::from_le_bytes([bytes[at], bytes[at + 1]]))
    }

    fn status(&mut self) -> u8 {
        self.read::<1>(STATUS_REG)[0]
    }

    fn pass(&mut self, time: Picoseconds) {
        self.now += time;
    }
}

#[test]
fn reset_values() {
    let mut bench = Bench::new();
    assert_eq!(bench.read::<2>(0x01), [0x00, 0x3F]);
    assert_eq!(bench.read::<1>(0x0F), [0x6B]);
    assert_eq!(bench.read::<10>(0x10), [0, 0, 4, 0, 0, 0, 0, 0, 0xE0, 0]);
    assert_eq!(bench.read::<2>(0x1E), [0, 0]);
    assert_eq!(bench.part.take_unmodelled(), None);
}

#[test]
fn part_does_not_answer_before_boot_or_when_not_selected() {
    let mut bench = Bench::new();
    bench.now = 9 * MILLISECOND;
    assert_eq!(bench.read::<1>(0x0F), [0xFF]);
    bench.now = 10 * MILLISECOND;
    assert_eq!(bench.read::<1>(0x0F), [0x6B]);
    assert_eq!(bench.part.transfer(bench.now, 0x8F), 0xFF);
    assert_eq!(bench.part.transfer(bench.now, 0), 0xFF);
}

#[test]
fn address_increments_unless_if_inc_is_0() {
    let mut bench = Bench::new();
    bench.write(0x13, &[0x11, 0x22]);
    assert_eq!(bench.read::<2>(0x13), [0x11, 0x22]);
    bench.write(0x12, &[0x00]);
    assert_eq!(bench.read::<2>(0x13), [0x11, 0x11]);
}

#[test]
fn software_reset_takes_50_us() {
    let mut bench = Bench::new();
    bench.write(0x10, &[ON]);
    bench.write(0x12, &[0x05]);
    bench.pass(49 * MICROSECOND);
    assert_eq!(bench.read::<3>(0x10), [ON, 0, 0x05]);
    bench.pass(MICROSECOND);
    assert_eq!(bench.read::<3>(0x10), [0, 0, 0x04]);
}

#[test]
fn boot_bit_clears_itself_and_keeps_settings() {
    let mut bench = Bench::new();
    bench.write(0x10, &[ON]);
    bench.write(0x12, &[0x84]);
    bench.pass(BOOT_TIME);
    assert_eq!(bench.read::<3>(0x10), [ON, 0, 0x04]);
}

#[test]
fn data_ready_is_set_at_data_rate_and_cleared_by_high_byte() {
    let mut bench = Bench::new();
    bench.write(0x10, &[ON]);
    // 16 / 6667 Hz = 2.400 ms
    bench.pass(2_399 * MICROSECOND);
    assert_eq!(bench.status(), 0);
    bench.pass(2 * MICROSECOND);
    assert_eq!(bench.status(), 1);
    bench.read::<1>(0x28);
    assert_eq!(bench.status(), 1, "after a low byte");
    bench.read::<1>(0x2B);
    assert_eq!(bench.status(), 0, "after a high byte of one axis");
}

#[test]
fn counts_match_each_full_scale() {
    // Datasheet, LA_So: 0.061, 0.122, 0.244, 0.488 mg per count
    for (code, ratio) in [(0b00, 1), (0b10, 2), (0b11, 4), (0b01, 8)] {
        let mut bench = Bench::new();
        bench.write(0x10, &[ON | code << 2]);
        bench.pass(10 * MILLISECOND);
        assert_eq!(
            bench.acceleration(),
            [0, -8192 / ratio, 16_384 / ratio],
            "FS_XL {code:02b}"
        );
    }
}

#[test]
fn counts_saturate_at_full_scale() {
    let mut bench = Bench::new();
    bench.motion.0.set([2_500_000, -2_500_000, 2_000_000]);
    bench.write(0x10, &[ON]);
    bench.pass(10 * MILLISECOND);
    assert_eq!(bench.acceleration(), [32_767, -32_768, 32_767]);
}

#[test]
fn gyroscope_and_temperature_counts_match_datasheet() {
    // Datasheet, G_So in mdps per count
    for (code, unit) in [
        (0b0000, 8.75),
        (0b0100, 17.5),
        (0b1000, 35.0),
        (0b1100, 70.0),
        (0b0010, 4.375),
        (0b0001, 140.0),
    ] {
        let mut bench = Bench::new();
        bench.write(0x11, &[0x60 | code]);
        bench.pass(30 * MILLISECOND);
        assert_eq!(bench.status() & 0b010, 0, "it turns on within 35 ms");
        bench.pass(10 * MILLISECOND);
        assert_eq!(bench.status(), 0b110);
        let bytes = bench.read::<8>(0x20);
        let value = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        // 256 counts per degree from 25 degC: 35.5 degC
        assert_eq!(value(0), 2688);
        for (at, mdps) in [(2, 10_000.0), (4, -100_000.0)] {
            let error = f64::from(value(at)) - f64::max(mdps / unit, -32768.0);
            assert!(error.abs() <= 1.0, "{code:04b}: {error}");
        }
        assert_eq!(bench.status(), 0);
    }
}

#[test]
fn block_data_update_keeps_both_bytes_of_one_sample() {
    let torn = |ctrl3: u8| {
        let mut bench = Bench::new();
        bench.motion.0.set([0, 0, 0x0106 * 61]);
        bench.write(0x12, &[ctrl3]);
        bench.write(0x10, &[ON]);
        bench.pass(10 * MILLISECOND);
        let low = bench.read::<1>(0x2C)[0];
        bench.motion.0.set([0, 0, 0x4009 * 61]);
        bench.pass(10 * MILLISECOND);
        let high = bench.read::<1>(0x2D)[0];
        (i16::from_le_bytes([low, high]), bench.acceleration()[2])
    };
    assert_eq!(torn(0x44), (0x0106, 0x4009));
    assert_eq!(torn(0x04), (0x4006, 0x4009));
}

#[test]
fn data_rate_follows_clock_of_part() {
    let samples = |percent| {
        let mut bench = Bench::new();
        bench.part.set_clock_deviation(bench.now, percent);
        bench.write(0x10, &[ON]);
        let mut count = 0;
        for _ in 0..100_000 {
            bench.pass(100 * MICROSECOND);
            if bench.status() & 1 != 0 {
                count += 1;
                bench.acceleration();
            }
        }
        count
    };
    // 6667 Hz / 16, for 10 s
    assert_eq!(samples(0.0), 4166);
    assert_eq!(samples(5.0), 4375);
    assert_eq!(samples(-5.0), 3958);
}

#[test]
fn frequency_fine_is_deviation_in_steps_of_0_15_percent() {
    for (percent, fine) in [(0.0, 0), (4.95, 33), (-4.95, -33), (0.15, 1)] {
        let mut bench = Bench::new();
        bench.part.set_clock_deviation(bench.now, percent);
        assert_eq!(bench.read::<1>(0x63)[0] as i8, fine, "{percent} %");
    }
}

#[test]
fn fifo_holds_each_acceleration_and_the_temperature() {
    let mut bench = Bench::new();
    // Acceleration at 833 Hz, temperature at 52 Hz, continuous mode.
    bench.write(0x09, &[0x07, 0x36]);
    bench.write(0x10, &[0x70]);
    bench.pass(20 * MILLISECOND);
    // 16 * 8 / 6667 Hz = 19.2 ms: the sixteenth acceleration comes together with the first temperature.
    assert_eq!(bench.read::<2>(0x3A), [17, 0]);
    for number in 1..=16 {
        let [tag, x0, x1, y0, y1, z0, z1] = bench.read::<7>(0x78);
        assert_eq!((tag >> 3, tag >> 1 & 3), (2, number % 4));
        assert_eq!(tag.count_ones() % 2, 0, "parity of {tag:02X}h");
        let counts = [[x0, x1], [y0, y1], [z0, z1]].map(i16::from_le_bytes);
        assert_eq!(counts, [0, -8192, 16_384]);
    }
    let word = bench.read::<7>(0x78);
    assert_eq!(
        (word[0] >> 3, &word[1..]),
        (3, &[0x80, 0x0A, 0, 0, 0, 0][..])
    );
    assert_eq!(bench.read::<2>(0x3A), [0, 0]);
    assert_eq!(bench.read::<7>(0x78), [0; 7]);
    assert_eq!(bench.part.take_unmodelled(), None);
}

#[test]
fn fifo_words_follow_each_other_in_one_transfer() {
    let mut bench = Bench::new();
    bench.write(0x09, &[0x07, 0x06]);
    bench.write(0x10, &[0x70]);
    bench.pass(10 * MILLISECOND);
    let words = bench.read::<14>(0x78);
    assert_eq!((words[0] >> 3, words[7] >> 3), (2, 2));
    assert_eq!(words[1..7], words[8..14]);
    assert_eq!(bench.read::<1>(0x3A), [6]);
}

#[test]
fn full_fifo_drops_oldest_word_and_bypass_mode_clears_it() {
    let mut bench = Bench::new();
    bench.write(0x09, &[0x07, 0x06]);
    bench.write(0x10, &[0x70]);
    bench.motion.0.set([0, 0, 0]);
    bench.pass(100 * MILLISECOND);
    bench.motion.0.set([16_384 * 61, 0, 0]);
    bench.read::<1>(0x0F);
    bench.pass(1000 * MILLISECOND);
    assert_eq!(bench.read::<2>(0x3A), [0x00, 0x02 | 0x68]);
    assert_eq!(bench.read::<3>(0x78)[1..], 16_384_i16.to_le_bytes());
    bench.write(0x0A, &[0x00]);
    assert_eq!(bench.read::<2>(0x3A), [0, 0]);
}

#[test]
fn lpf2_settling_time_matches_cutoff() {
    // LPF2 at ODR / 20 = 20.8 Hz: a Butterworth filter of second order reaches 10 % after 0.0855 / f and 90 % after 0.427 / f.
    let mut bench = Bench::new();
    bench.motion.0.set([0, 0, 0]);
    bench.write(0x17, &[0b010 << 5]);
    bench.write(0x10, &[ON | 0b10]);
    bench.pass(500 * MILLISECOND);
    assert_eq!(bench.acceleration(), [0; 3]);
    bench.motion.0.set([0, 0, 16_384 * 61]);
    let mut rise = None;
    let mut settled = None;
    for step in 0..5000_u32 {
        bench.pass(100 * MICROSECOND);
        let mg = f64::from(bench.acceleration()[2]) * 0.061;
        if mg >= 100.0 {
            rise.get_or_insert(step);
        }
        if mg >= 900.0 {
            settled.get_or_insert(step);
        }
    }
    let milliseconds = f64::from(settled.unwrap() - rise.unwrap()) / 10.0;
    // 10 to 90 %: 0.342 / 20.8 Hz = 16.4 ms, plus or minus one sample.
    assert!((milliseconds - 16.4).abs() < 2.5, "{milliseconds} ms");
    assert_eq!(bench.acceleration()[2], 16_384);
}

#[test]
fn self_test_moves_axes_within_limits() {
    let change = |works, bits| {
        let mut bench = Bench::new();
        bench.part.set_self_test_works(works);
        bench.write(0x10, &[ON]);
        bench.pass(100 * MILLISECOND);
        let before = bench.acceleration();
        bench.write(0x14, &[bits]);
        bench.pass(100 * MILLISECOND);
        let after = bench.acceleration();
        [0, 1, 2].map(|axis| f64::from(after[axis] - before[axis]) * 0.061)
    };
    // Datasheet: 90 to 1700 mg.
    assert!(
        change(true, 0b01)
            .iter()
            .all(|mg| (90.0..1700.0).contains(mg))
    );
    assert!(
        change(true, 0b10)
            .iter()
            .all(|mg| (-1700.0..-90.0).contains(mg))
    );
    assert!(change(false, 0b01).iter().all(|mg| mg.abs() < 90.0));
}

#[test]
fn part_restarts_when_mounted_again() {
    let mut bench = Bench::new();
    bench.write(0x10, &[ON]);
    bench.part.unmount();
    assert_eq!(bench.read::<1>(0x0F), [0xFF]);
    bench.part.power_on(bench.now);
    assert_eq!(bench.read::<1>(0x10), [0xFF]);
    bench.pass(BOOT_TIME);
    assert_eq!(bench.read::<1>(0x10), [0x00]);
}

#[test]
fn access_not_modelled_is_recorded() {
    let mut bench = Bench::new();
    assert_eq!(bench.read::<1>(0x35), [0]);
    assert_eq!(bench.part.take_unmodelled(), Some(0x35));
    // Another bank hides the user's registers; FUNC_CFG_ACCESS selects the first bank again.
    bench.write(0x01, &[0x80]);
    assert_eq!(bench.read::<1>(0x0F), [0]);
    assert_eq!(bench.part.take_unmodelled(), Some(0x0F));
    bench.write(0x01, &[0x00]);
    assert_eq!(bench.read::<1>(0x0F), [0x6B]);
    bench.write(0x0F, &[0x00]);
    assert_eq!(bench.part.take_unmodelled(), Some(0x0F));
}
