//! The bit timing (RM0008, 24.7.7 and CAN_BTR).
//!
//! | Bits | Field | Content |
//! |---|---|---|
//! | 31, 30 | SILM, LBKM | silent mode, loop back mode |
//! | 25..24 | SJW | resynchronization jump width - 1, in time quanta |
//! | 22..20 | TS2 | time quanta from the sample point to the end of the bit - 1 |
//! | 19..16 | TS1 | time quanta from the synchronization segment to the sample point - 1 |
//! | 9..0 | BRP | clock cycles of a time quantum - 1 |

use can_wire::protocol::{BitTiming, Picoseconds};

/// CAN_BTR after a reset.
pub(super) const RESET: u32 = 0x0123_0000;
/// CAN_BTR.LBKM.
const LOOP_BACK: u32 = 1 << 30;
const SILENT: u32 = 1 << 31;
const IMPLEMENTED: u32 = 0xC37F_03FF;

const PICOSECONDS_PER_SECOND: u64 = 1_000_000_000_000;

/// The highest bit rate of CAN, and of bxCAN (RM0008, 24.2).
const HIGHEST_RATE: u32 = 1_000_000;

/// The minimum number of time quanta in a bit (ISO 11898-1).
const LEAST_QUANTA: u32 = 8;

/// The value of CAN_BTR.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Timing(u32);

impl Default for Timing {
    fn default() -> Self {
        Self(RESET)
    }
}

impl Timing {
    pub(super) fn new(value: u32) -> Self {
        Self(value & IMPLEMENTED)
    }

    pub(super) fn value(self) -> u32 {
        self.0
    }

    pub(super) fn is_silent(self) -> bool {
        self.0 & SILENT != 0
    }

    pub(super) fn is_looped_back(self) -> bool {
        self.0 & LOOP_BACK != 0
    }

    fn prescaler(self) -> u32 {
        (self.0 & 0x3FF) + 1
    }

    /// Time quanta of segments 1 and 2.
    fn segments(self) -> (u32, u32) {
        ((self.0 >> 16 & 0xF) + 1, (self.0 >> 20 & 7) + 1)
    }

    fn jump(self) -> u32 {
        (self.0 >> 24 & 3) + 1
    }

    /// Time quanta of a bit: the synchronization segment is one.
    fn quanta(self) -> u32 {
        let (before, after) = self.segments();
        1 + before + after
    }

    /// The bit timing with this clock (PCLK1, in Hz).
    pub(super) fn bit_timing(self, clock: u32) -> BitTiming {
        let length = |quanta: u32| -> Picoseconds {
            u64::from(quanta * self.prescaler()) * PICOSECONDS_PER_SECOND / u64::from(clock)
        };
        let (before, _) = self.segments();
        BitTiming {
            bit: length(self.quanta()),
            sample: length(1 + before),
            jump: length(self.jump()),
        }
    }

    /// Bits per second, rounded to nearest.
    pub(super) fn bit_rate(self, clock: u32) -> u32 {
        let cycles = self.quanta() * self.prescaler();
        (clock + cycles / 2) / cycles
    }

    /// The reason why this timing must not be used, if there is one.
    pub(super) fn fault(self, clock: u32) -> Option<String> {
        let (_, after) = self.segments();
        let (quanta, jump, rate) = (self.quanta(), self.jump(), self.bit_rate(clock));
        if rate > HIGHEST_RATE {
            Some(format!("{rate} bit/s are more than CAN permits"))
        } else if quanta < LEAST_QUANTA {
            Some(format!(
                "{quanta} time quanta in a bit: the clock is too slow for this rate"
            ))
        } else if jump > after {
            Some(format!(
                "SJW of {jump} time quanta, but the sample point is only {after} before the end of the bit"
            ))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(prescaler: u32, before: u32, after: u32, jump: u32) -> Timing {
        Timing::new((jump - 1) << 24 | (after - 1) << 20 | (before - 1) << 16 | (prescaler - 1))
    }

    #[test]
    fn bit_is_one_quantum_and_two_segments() {
        // 32 MHz, prescaler 4: quanta of 125 ns; 1 + 13 + 2 quanta are 2 us.
        let at_500k = timing(4, 13, 2, 2);
        assert_eq!(at_500k.value(), 0x011C_0003);
        assert_eq!(
            at_500k.bit_timing(32_000_000),
            BitTiming {
                bit: 2_000_000,
                sample: 1_750_000,
                jump: 250_000
            }
        );
        assert_eq!(at_500k.bit_rate(32_000_000), 500_000);
    }

    #[test]
    fn bit_time_scales_with_clock() {
        assert_eq!(timing(4, 13, 2, 2).bit_rate(36_000_000), 562_500);
        assert_eq!(timing(5, 6, 1, 1).bit_rate(32_000_000), 800_000);
        assert_eq!(timing(200, 13, 2, 2).bit_rate(32_000_000), 10_000);
        // Not an integer: 36 MHz / 7 / 16.
        assert_eq!(timing(7, 13, 2, 2).bit_rate(36_000_000), 321_429);
    }

    #[test]
    fn each_field_accepts_its_maximum() {
        let longest = timing(1024, 16, 8, 4);
        assert_eq!(longest.value(), 0x037F_03FF);
        assert_eq!(longest.bit_timing(1_024_000).bit, 25_000_000_000);
        assert_eq!(longest.bit_timing(1_024_000).sample, 17_000_000_000);
        assert_eq!(longest.bit_timing(1_024_000).jump, 4_000_000_000);
    }

    #[test]
    fn reset_value() {
        // RM0008: 0x0123_0000, that is, 1 + 4 + 3 time quanta of one clock cycle and a jump width of 2.
        assert_eq!(Timing::default(), timing(1, 4, 3, 2));
        assert!(!Timing::default().is_silent());
        assert!(Timing::new(0x8000_0000).is_silent());
    }

    #[test]
    fn invalid_timings_have_a_reason() {
        let fault = |timing: Timing, clock| timing.fault(clock).unwrap_or_default();
        assert!(fault(timing(1, 13, 2, 2), 32_000_000).contains("more than CAN permits"));
        assert!(fault(timing(1, 4, 2, 1), 7_000_000).contains("clock is too slow"));
        assert!(fault(timing(4, 13, 2, 3), 32_000_000).contains("SJW of 3"));
        assert_eq!(timing(2, 13, 2, 2).fault(32_000_000), None);
        assert_eq!(timing(5, 6, 1, 1).fault(32_000_000), None);
    }
}
