//! Bit timing of bxCAN for the ten bit rates, from a peripheral clock of 32 MHz.
//!
//! A bit has 1 + BS1 + BS2 time quanta of `prescaler` clock periods each. Both boards run APB1 at 32 MHz. Then all bit rates are
//! exact with the sample point at 87.5 %. With the usual 36, 42 and 45 MHz this is not possible at 800 kbit/s.

use plumbline::can::BitRate;

/// The peripheral clock in Hz.
pub const CLOCK: u32 = 32_000_000;

/// The bit timing part of CAN_BTR: SJW-1 in bits 24..26, BS2-1 in 20..23, BS1-1 in 16..20, prescaler-1 in 0..10. The mode bits
/// (silent 31, loop back 30) are zero.
pub const fn btr(rate: BitRate) -> u32 {
    match rate {
        BitRate::K10 => fields(200, 13, 2),
        BitRate::K20 => fields(100, 13, 2),
        BitRate::K50 => fields(40, 13, 2),
        BitRate::K62_5 => fields(32, 13, 2),
        BitRate::K100 => fields(20, 13, 2),
        BitRate::K125 => fields(16, 13, 2),
        BitRate::K250 => fields(8, 13, 2),
        BitRate::K500 => fields(4, 13, 2),
        BitRate::K800 => fields(5, 6, 1),
        BitRate::M1 => fields(2, 13, 2),
    }
}

/// The register fields. The synchronization jump width is 2, limited to phase segment 2.
const fn fields(prescaler: u32, bs1: u32, bs2: u32) -> u32 {
    let sjw = if bs2 < 2 { bs2 } else { 2 };
    ((sjw - 1) << 24) | ((bs2 - 1) << 20) | ((bs1 - 1) << 16) | (prescaler - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Prescaler, BS1, BS2 and SJW in the register (RM0008, CAN_BTR).
    fn decode(btr: u32) -> (u32, u32, u32, u32) {
        (
            (btr & 0x3FF) + 1,
            (btr >> 16 & 0xF) + 1,
            (btr >> 20 & 0x7) + 1,
            (btr >> 24 & 0x3) + 1,
        )
    }

    #[test]
    fn bit_rates_are_exact() {
        for rate in BitRate::ALL {
            let (prescaler, bs1, bs2, _) = decode(btr(rate));
            let clocks = prescaler * (1 + bs1 + bs2);
            assert_eq!(rate.bits_per_second() * clocks, CLOCK, "{rate:?}");
        }
    }

    #[test]
    fn sample_points_are_at_87_5_percent() {
        for rate in BitRate::ALL {
            let (_, bs1, bs2, _) = decode(btr(rate));
            assert_eq!((1 + bs1) * 8, (1 + bs1 + bs2) * 7, "{rate:?}");
        }
    }

    #[test]
    fn jump_width_does_not_exceed_phase_segment_2() {
        for rate in BitRate::ALL {
            let (_, _, bs2, sjw) = decode(btr(rate));
            assert!(sjw <= bs2 && sjw <= 2, "{rate:?}");
        }
    }

    #[test]
    fn only_timing_fields_are_used() {
        for rate in BitRate::ALL {
            assert_eq!(btr(rate) & !0x037F_03FF, 0, "{rate:?}");
        }
    }

    /// Register values calculated by hand.
    #[test]
    fn register_values_match_manual_calculation() {
        assert_eq!(btr(BitRate::K10), 0x011C_00C7);
        assert_eq!(btr(BitRate::K250), 0x011C_0007);
        assert_eq!(btr(BitRate::K800), 0x0005_0004);
        assert_eq!(btr(BitRate::M1), 0x011C_0001);
    }
}
