//! Faults of the part and of its line, and parts with the same identifier.

use super::*;

#[test]
fn faults_affect_readings() {
    let mut bench = Bench::new();
    bench.write(0x10, &[ON]);
    bench.pass(10 * MILLISECOND);
    let before = bench.acceleration();
    for byte in [0x00, 0xFF] {
        bench.part.set_fault(bench.now, Fault::Silent(byte));
        assert_eq!(bench.read::<2>(0x0F), [byte; 2]);
    }
    bench.motion.0.set([4900 * 61; 3]);
    bench.part.set_fault(bench.now, Fault::Frozen);
    bench.pass(10 * MILLISECOND);
    assert_eq!((bench.status() & 1, bench.acceleration()), (1, before));
    bench.part.set_fault(bench.now, Fault::Stopped);
    bench.pass(10 * MILLISECOND);
    assert_eq!(bench.status() & 1, 0);
    bench.part.set_fault(bench.now, Fault::None);
    bench.pass(10 * MILLISECOND);
    assert_eq!(bench.acceleration(), [4900; 3]);
}

/// Acceleration and temperature in the FIFO, at 8 g.
fn with_fifo() -> Bench {
    let mut bench = Bench::new();
    bench.motion.0.set([250_000, -500_000, 1_000_000]);
    bench.write(0x09, &[0x07, 0x36]);
    bench.write(0x10, &[0x7C]);
    bench
}

#[test]
fn stuck_axis_has_one_value() {
    let mut bench = with_fifo();
    bench.part.set_fault(bench.now, Fault::Stuck(1, 77));
    bench.pass(10 * MILLISECOND);
    let [x, y, z] = bench.acceleration();
    assert!(x.abs_diff(1025) <= 1 && z.abs_diff(4098) <= 1, "{x} {z}");
    assert_eq!(y, 77);
}

#[test]
fn bit_error_is_in_each_byte_of_its_period() {
    let mut bench = Bench::new();
    bench.part.set_bit_errors(3);
    let bytes = bench.read::<9>(0x10);
    // The reset values, with bit 0, 1 and 2 inverted.
    assert_eq!(bytes, [0, 0, 4 ^ 1, 0, 0, 2, 0, 0, 0xE0 ^ 4]);
    bench.part.set_bit_errors(0);
    assert_eq!(bench.read::<9>(0x10), [0, 0, 4, 0, 0, 0, 0, 0, 0xE0]);
}

#[test]
fn spoilt_register_is_wrong_as_often_as_set() {
    let mut bench = Bench::new();
    bench.part.spoil(0x0F, 0x81, 2);
    let read = [(); 3].map(|()| bench.read::<2>(0x0F));
    assert_eq!(read, [[0xEA, 0], [0xEA, 0], [0x6B, 0]]);
}

#[test]
fn upset_register_changes_the_range() {
    let mut bench = with_fifo();
    bench.part.upset(bench.now, CTRL1_XL, 0b1100);
    assert_eq!(bench.part.register(CTRL1_XL), 0x70);
    bench.pass(10 * MILLISECOND);
    assert!(bench.acceleration()[2].abs_diff(16_393) <= 1);
    assert_eq!(bench.part.take_unmodelled(), None);
}

#[test]
fn lost_words_leave_a_gap_in_the_counter() {
    let mut bench = with_fifo();
    bench.pass(10 * MILLISECOND);
    let level = bench.read::<1>(0x3A)[0];
    let first = bench.read::<7>(0x78)[0];
    bench.part.lose_words(bench.now, 2);
    let next = bench.read::<7>(0x78)[0];
    assert_eq!((next >> 1 & 3).wrapping_sub(first >> 1 & 3) & 3, 3);
    assert_eq!(bench.read::<2>(0x3A), [level - 4, 0]);
}

/// The part loses its supply for a moment, the sensor does not.
#[test]
fn restarted_part_has_its_reset_values_and_no_samples() {
    let mut bench = with_fifo();
    bench.pass(10 * MILLISECOND);
    bench.part.power_on(bench.now);
    bench.pass(BOOT_TIME + 10 * MILLISECOND);
    assert_eq!(bench.read::<4>(0x07), [0; 4]);
    assert_eq!(bench.read::<10>(0x10), [0, 0, 4, 0, 0, 0, 0, 0, 0xE0, 0]);
    assert_eq!(bench.read::<2>(0x3A), [0, 0]);
}

#[test]
fn siblings_have_the_identifier_and_differ_as_in_their_headers() {
    for (sibling, gyroscope, counts) in [
        (Sibling::Ism330dhcx, 0x78, [1025, -2049, 4098]),
        (Sibling::Asm330lhh, 0x78, [1025, -2049, 4098]),
        // +-2 g instead of +-8 g
        (Sibling::Iis2iclx, 0x00, [4098, -8197, 0]),
    ] {
        let mut bench = with_fifo();
        bench.part.set_sibling(sibling);
        bench.write(CTRL1_XL, &[0x7C, 0x78]);
        assert_eq!(bench.read::<1>(WHO_AM_I), [0x6B]);
        assert_eq!(bench.read::<2>(CTRL1_XL), [0x7C, gyroscope], "{sibling:?}");
        bench.pass(60 * MILLISECOND);
        let values = bench.acceleration();
        let near = |axis: usize| values[axis].abs_diff(counts[axis]) <= 1;
        assert!((0..3).all(near), "{sibling:?}: {values:?}");
        assert_eq!(bench.status() & 0b010 != 0, gyroscope != 0, "{sibling:?}");
        assert_eq!(bench.part.take_unmodelled(), None);
        bench.write(FUNC_CFG_ACCESS, &[0]);
        let banks = bench.part.take_unmodelled().is_none();
        assert_eq!(banks, sibling != Sibling::Asm330lhh);
    }
}

#[test]
fn write_during_boot_is_recorded() {
    let mut bench = Bench::new();
    bench.now = 9 * MILLISECOND;
    bench.read::<1>(WHO_AM_I);
    assert_eq!(bench.part.take_complaint(), None);
    bench.write(FUNC_CFG_ACCESS, &[0]);
    assert!(bench.part.take_complaint().is_some());
    bench.now = 10 * MILLISECOND;
    bench.write(FUNC_CFG_ACCESS, &[0]);
    assert_eq!(bench.part.take_complaint(), None);
}

#[test]
fn software_reset_while_the_gyroscope_runs_is_recorded() {
    // Power-down with another range, then 833 Hz.
    for (gyroscope, complains) in [(0x08, false), (0x78, true)] {
        let mut bench = Bench::new();
        bench.write(CTRL2_G, &[gyroscope]);
        bench.write(CTRL3_C, &[SW_RESET]);
        assert_eq!(bench.part.take_complaint().is_some(), complains);
        assert_eq!(bench.part.take_complaint(), None);
    }
}
