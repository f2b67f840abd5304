//! The numbers of the JN2101's filter select the cut-off frequencies of the manual (7.7, 9.4).

use crate::tester::canopen::*;

/// The largest inclination X, in parts of the input's amplitude, for a sine of this frequency in Hz after this filter.
fn gain(filter: u32, frequency: f64) -> f64 {
    const AMPLITUDE: f64 = 10.0;
    let mut t = booted();
    t.write(0x2043, 0, 1, filter).unwrap();
    // Settle for 8 s, then measure for 8 s; a sample takes 5 ms.
    let mut highest = 0;
    for sample in 0..3200 {
        let phase = std::f64::consts::TAU * frequency * f64::from(sample) * 0.005;
        let angle = (AMPLITUDE * phase.sin()).to_radians();
        t.hold(in_g([-angle.sin(), 0.0, angle.cos()]), 1);
        if sample >= 1600 {
            highest = highest.max(t.read_i16(0x6010));
        }
    }
    f64::from(highest) / (100.0 * AMPLITUDE)
}

#[test]
fn filter_number_selects_the_cut_off_frequency() {
    for (filter, cut_off) in [(1, 10.0), (2, 5.0), (3, 1.0), (4, 0.5)] {
        // -3 dB; the sine is a little off a divisor of the sample rate, so that its peaks are sampled.
        let at_cut_off = gain(filter, cut_off * 1.003);
        assert!((0.67..0.74).contains(&at_cut_off), "{filter}: {at_cut_off}");
        assert!(gain(filter, cut_off / 4.0) > 0.94, "{filter}");
        assert!(gain(filter, cut_off * 4.0) < 0.02, "{filter}");
    }
    assert!(gain(0, 20.03) > 0.99, "off");
}
