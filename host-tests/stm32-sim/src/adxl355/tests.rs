//! The part alone, as a driver sees it.

use super::*;
use plumbline::measure::{I32x3, ONE_G, Reading};

const MS: Picoseconds = 1000 * MICROSECOND;

/// A quiet part at this time, with 0.25, -0.5 and 1 g at 35 degC.
struct Bench {
    part: Adxl355,
    now: Picoseconds,
}

impl Bench {
    fn new() -> Self {
        let reading = Reading {
            acceleration: I32x3 {
                x: ONE_G / 4,
                y: -ONE_G / 2,
                z: ONE_G,
            },
            temperature: 35_00,
            ..Reading::default()
        };
        let mut part = Adxl355::new(Box::new(reading));
        part.set_noise(Noise::None);
        Self {
            part,
            now: BOOT_TIME,
        }
    }

    /// A part that measures at 1000 Hz and +-8 g since 20 ms.
    fn measuring() -> Self {
        let mut bench = Self::new();
        bench.write(FILTER, 2);
        bench.write(RANGE, 0x83);
        bench.write(POWER_CTL, 0);
        bench.now += 20 * MS;
        bench
    }

    fn exchange(&mut self, bytes: &mut [u8]) {
        self.part.select(self.now, true);
        for byte in bytes {
            *byte = self.part.transfer(self.now, *byte);
        }
        self.part.select(self.now, false);
    }

    fn write(&mut self, register: u8, value: u8) {
        self.exchange(&mut [register << 1, value]);
    }

    fn read<const N: usize>(&mut self, register: u8) -> [u8; N] {
        let mut bytes = vec![0; N + 1];
        bytes[0] = register << 1 | 1;
        self.exchange(&mut bytes);
        bytes[1..].try_into().unwrap()
    }

    /// Empties the FIFO, between two values.
    fn drain(&mut self) {
        self.now = self.now - self.now % MS + MS / 2;
        while self.read(FIFO_ENTRIES) != [0] {
            self.read::<3>(FIFO_DATA);
        }
    }

    /// The oldest value in the FIFO.
    fn value(&mut self) -> [i32; 3] {
        let bytes: [u8; 9] = self.read(FIFO_DATA);
        assert_eq!(
            [bytes[2], bytes[5], bytes[8]].map(|low| low & 0x0F),
            [1, 0, 0]
        );
        [0, 3, 6]
            .map(|at| i32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2] & 0xF0, 0]) >> 12)
    }
}

#[test]
fn part_answers_10_ms_after_power_up_with_its_identity() {
    let mut bench = Bench::new();
    bench.now -= 1;
    assert_eq!(bench.read(0), [0xFF; 4]);
    bench.now += 1;
    assert_eq!(bench.read(0), [0xAD, 0x1D, 0xED, 0x01]);
    bench.part.set_part(0xE9);
    assert_eq!(bench.read(2), [0xE9]);
    assert_eq!(bench.read(FILTER), [0, 0x60, 0, 0, 0x81, 0x01, 0]);
}

#[test]
fn values_have_64000_counts_per_g_in_the_fifo_and_in_the_registers() {
    let mut bench = Bench::measuring();
    for _ in 0..16 {
        bench.value();
    }
    assert_eq!(bench.value(), [16_000, -32_000, 64_000]);
    assert_eq!(
        bench.read(XDATA3),
        [0x03, 0xE8, 0x00, 0xF8, 0x30, 0x00, 0x0F, 0xA0, 0x00]
    );
    let [high, low] = bench.read(TEMP2);
    assert_eq!(u16::from_be_bytes([high, low]), 1885 - 90, "35 degC");
}

#[test]
fn axes_of_a_value_appear_one_after_the_other_and_an_empty_fifo_is_marked() {
    let mut bench = Bench::measuring();
    assert_eq!(bench.read(FIFO_ENTRIES), [20 * 3 - 2]);
    bench.now += 25 * MICROSECOND;
    assert_eq!(bench.read(FIFO_ENTRIES), [20 * 3 - 1]);
    bench.now += 20 * MICROSECOND;
    for _ in 0..20 {
        bench.value();
    }
    assert_eq!(bench.read(FIFO_DATA), [0, 0, 0b10]);
}

#[test]
fn fifo_of_32_values_loses_the_oldest_and_tells_it_once() {
    let mut bench = Bench::measuring();
    bench.now += 12 * MS + MS / 2;
    assert_eq!(bench.read::<2>(STATUS), [0b011, 96]);
    bench.now += MS;
    assert_eq!(bench.read::<2>(STATUS), [0b111, 96]);
    assert_eq!(bench.read::<2>(STATUS), [0b010, 96]);
    bench.value();
    bench.part.sampling.fifo.lose();
    let [.., low] = bench.read::<3>(FIFO_DATA);
    assert_eq!(low & 1, 0, "an entry that is not X");
}

#[test]
fn reset_returns_to_standby_and_can_fail() {
    let mut bench = Bench::measuring();
    let shadows = bench.read::<5>(SHADOWS);
    bench.part.set_bad_starts(1);
    for is_right in [false, true] {
        bench.write(RESET, RESET_CODE);
        assert_eq!(
            bench.read::<2>(STATUS),
            [1 << 4, 0],
            "it loads its trimming"
        );
        bench.now += LOADING_TIME;
        assert_eq!(bench.read::<2>(STATUS), [0, 0]);
        assert_eq!(bench.read::<5>(SHADOWS) == shadows, is_right);
        assert_eq!(bench.read(POWER_CTL), [1]);
    }
}

#[test]
fn configuration_while_measuring_is_a_complaint() {
    let mut bench = Bench::measuring();
    assert_eq!(bench.part.take_complaint(), None);
    bench.write(SELF_TEST, 1);
    assert_eq!(bench.part.take_complaint(), None);
    bench.write(RANGE, 0x81);
    let reason = "written while the part measures";
    assert_eq!(bench.part.take_complaint(), Some((RANGE, reason)));
    bench.read::<1>(0x30);
    assert!(bench.part.take_complaint().is_some());
}

#[test]
fn self_test_force_moves_the_axes_by_the_typical_amount() {
    let mut bench = Bench::measuring();
    for (works, change) in [(true, [19_200, 19_200, 96_000]), (false, [0; 3])] {
        bench.part.set_self_test_works(works);
        let mut mean = |force| {
            bench.write(SELF_TEST, force);
            // Until the low-pass has settled.
            bench.now += 5 * MS;
            bench.drain();
            bench.now += MS;
            bench.value()
        };
        let (rest, pushed) = (mean(1), mean(3));
        for axis in [0, 1, 2] {
            let difference: i32 = pushed[axis] - rest[axis];
            // A digit that stays the same for long changes by one.
            assert!(
                difference.abs_diff(change[axis]) <= 1,
                "{axis}: {difference}"
            );
        }
    }
}

#[test]
fn faults_change_the_values() {
    let mut bench = Bench::measuring();
    let mut next = |fault| {
        bench.drain();
        bench.part.set_fault(bench.now, fault);
        bench.now += MS;
        let value = bench.read::<9>(FIFO_DATA);
        bench.part.set_fault(bench.now, Fault::None);
        bench.now += 2 * MS;
        value
    };
    assert_eq!(next(Fault::Zeros), [0, 0, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(next(Fault::StuckAxis(1))[3..6], [0xF8, 0x30, 0]);
    assert_eq!(next(Fault::Silent(0)), [0; 9]);
    assert_eq!(next(Fault::Stopped)[2], 0b10);
}

#[test]
fn clock_deviation_changes_the_data_rate() {
    for (percent, values) in [(0.0, 20), (5.0, 21), (-5.0, 19)] {
        let mut bench = Bench::measuring();
        bench.drain();
        bench.part.set_clock_deviation(bench.now, percent);
        bench.now += 20 * MS + MS / 5;
        assert_eq!(bench.read(FIFO_ENTRIES), [values * 3], "{percent}");
    }
}
