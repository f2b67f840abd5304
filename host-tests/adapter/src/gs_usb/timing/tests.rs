use super::*;

/// A bxCAN, as in most candleLight adapters.
fn bxcan(clock: u32) -> Constants {
    Constants {
        features: 0,
        clock,
        segment_1: (1, 16),
        segment_2: (1, 8),
        jump: 4,
        prescaler: (1, 1024, 1),
    }
}

fn found(rate: BitRate, limits: &Constants) -> Option<(u32, u32, u32)> {
    let timing = BitTiming::find(rate, limits)?;
    let words = timing.words();
    assert_eq!(words[0] + words[1], timing.segment_1);
    assert_eq!(
        words[2..],
        [timing.segment_2, timing.jump, timing.prescaler]
    );
    Some((timing.prescaler, timing.segment_1, timing.segment_2))
}

#[test]
fn clock_of_48_mhz_has_all_ten_rates() {
    let expected = [
        (BitRate::K10, (300, 13, 2)),
        (BitRate::K20, (150, 13, 2)),
        (BitRate::K50, (60, 13, 2)),
        (BitRate::K62_5, (48, 13, 2)),
        (BitRate::K100, (30, 13, 2)),
        (BitRate::K125, (24, 13, 2)),
        (BitRate::K250, (12, 13, 2)),
        (BitRate::K500, (6, 13, 2)),
        (BitRate::K800, (4, 12, 2)),
        (BitRate::M1, (3, 13, 2)),
    ];
    for (rate, timing) in expected {
        assert_eq!(found(rate, &bxcan(48_000_000)), Some(timing), "{rate:?}");
    }
}

#[test]
fn other_clocks_have_the_sample_point_nearest_to_87_5_percent() {
    let cases = [
        // 45 clocks a bit: 15 quanta with 86.7 % are nearer than 9 with 88.9 %.
        (36_000_000, BitRate::K800, (3, 12, 2)),
        (16_000_000, BitRate::M1, (1, 13, 2)),
        // 20 clocks a bit: 10 quanta with 90 % and 20 with 85 % are equally near; more quanta win.
        (16_000_000, BitRate::K800, (1, 16, 3)),
        (170_000_000, BitRate::M1, (10, 14, 2)),
    ];
    for (clock, rate, timing) in cases {
        assert_eq!(found(rate, &bxcan(clock)), Some(timing), "{clock} {rate:?}");
    }
    let fdcan = Constants {
        segment_1: (1, 256),
        segment_2: (1, 128),
        jump: 128,
        prescaler: (1, 512, 1),
        ..bxcan(64_000_000)
    };
    assert_eq!(found(BitRate::K10, &fdcan), Some((25, 223, 32)));
    assert_eq!(BitTiming::find(BitRate::K10, &fdcan).unwrap().jump, 16);
}

#[test]
fn rate_that_is_no_fraction_of_the_clock_is_not_found() {
    // 212.5, 31.25 clocks a bit.
    assert_eq!(found(BitRate::K800, &bxcan(170_000_000)), None);
    assert_eq!(found(BitRate::K800, &bxcan(25_000_000)), None);
    // 480 clocks a bit, and no prescaler above 4.
    let narrow = Constants {
        prescaler: (1, 4, 1),
        ..bxcan(48_000_000)
    };
    assert_eq!(found(BitRate::K100, &narrow), None);
}

#[test]
fn limits_that_make_no_sense_find_nothing_and_do_not_panic() {
    let limits = Constants {
        segment_1: (9, 3),
        segment_2: (u32::MAX, 0),
        jump: 0,
        prescaler: (0, u32::MAX, 0),
        ..bxcan(4_294_000_000)
    };
    for rate in BitRate::ALL {
        assert_eq!(found(rate, &limits), None);
        assert_eq!(found(rate, &bxcan(1)), None);
    }
    let odd = Constants {
        prescaler: (0, u32::MAX, 0),
        ..bxcan(48_000_000)
    };
    assert_eq!(found(BitRate::K250, &odd), Some((12, 13, 2)));
}
