//! Automatic bit rate detection: listens at one bit rate after the other until it receives a valid frame.
//!
//! The controller is in listen-only mode, so a wrong bit rate does not disturb the bus. After a bus error, which shows traffic at
//! another bit rate, the search continues at once with the next candidate. Without traffic and without errors, it continues after
//! the dwell time. The search has no time limit; a restart begins it again.

use crate::can::BitRate;
use crate::time::{Duration, Instant, after, millis, reached};

/// The order of the search: the common bit rates of vehicles and machines first.
pub const CANDIDATES: [BitRate; 10] = [
    BitRate::K250,
    BitRate::K500,
    BitRate::K125,
    BitRate::M1,
    BitRate::K100,
    BitRate::K50,
    BitRate::K800,
    BitRate::K20,
    BitRate::K62_5,
    BitRate::K10,
];

/// The shortest dwell time at one bit rate. The longest frame has 160 bits, 16 ms at 10 kbit/s. Listening can begin within a
/// frame, so the rest of one frame and one complete frame must fit. The controller needs up to 27 ms to change its bit rate.
pub const DWELL_MIN: Duration = millis(80);

/// The longest dwell time at one bit rate.
pub const DWELL_MAX: Duration = millis(180);

/// The search for the bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Autobaud {
    candidate: u8,
    /// State of the random number generator: one number for each dwell time.
    random: u16,
    until: Instant,
}

impl Autobaud {
    /// Begins at the first candidate.
    pub fn start(now: Instant) -> Self {
        Self {
            candidate: 0,
            random: 1,
            until: after(now, DWELL_MIN),
        }
    }

    /// The bit rate to listen at.
    pub fn rate(&self) -> BitRate {
        CANDIDATES
            .get(usize::from(self.candidate))
            .copied()
            .unwrap_or(BitRate::K250)
    }

    /// Bus error: continues with the next candidate.
    pub fn error(&mut self, now: Instant) {
        self.next(now);
    }

    /// Continues with the next candidate at the end of the dwell time. Returns true if the bit rate has changed.
    pub fn poll(&mut self, now: Instant) -> bool {
        let over = reached(now, self.until);
        if over {
            self.next(now);
        }
        over
    }

    /// The end of the dwell time.
    pub fn deadline(&self) -> Instant {
        self.until
    }

    fn next(&mut self, now: Instant) {
        self.candidate = (self.candidate + 1) % CANDIDATES.len() as u8;
        // The dwell time is random: with a constant one, periodic frames could always arrive at the same wrong candidate. The
        // generator is a linear congruential one of full period. Its upper bits are more random than its lower bits.
        self.random = self.random.wrapping_mul(25_173).wrapping_add(13_849);
        let extra = u32::from(self.random >> 8) * 100 / 255;
        self.until = after(now, DWELL_MIN + millis(extra));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONGEST_FRAME_BITS: u64 = 160;
    /// The longest time, in us, that a controller needs to change its bit rate: the end of a frame, and 11 recessive bits.
    const RATE_CHANGE_MAX: u64 = 27_000;

    #[test]
    fn each_bit_rate_is_one_candidate() {
        for rate in BitRate::ALL {
            assert_eq!(
                CANDIDATES
                    .iter()
                    .filter(|&&candidate| candidate == rate)
                    .count(),
                1
            );
        }
    }

    #[test]
    fn dwell_time_is_long_enough_for_slowest_frame() {
        let slowest = 2 * LONGEST_FRAME_BITS * 1_000_000 / 10_000;
        assert!(DWELL_MIN.ticks() > RATE_CHANGE_MAX + slowest);
        let mut search = Autobaud::start(Instant::from_ticks(0));
        for _ in 0..1000 {
            let now = search.deadline();
            search.error(now);
            let dwell = search.deadline().ticks() - now.ticks();
            assert!((DWELL_MIN.ticks()..=DWELL_MAX.ticks()).contains(&dwell));
        }
    }

    #[test]
    fn search_on_silent_bus_has_no_end() {
        let mut search = Autobaud::start(Instant::from_ticks(0));
        for round in 0..1000 {
            assert_eq!(search.rate(), CANDIDATES[round % 10]);
            let before = Instant::from_ticks(search.deadline().ticks() - 1);
            assert!(!search.poll(before));
            assert!(search.poll(search.deadline()));
        }
    }

    /// The number of frames until `rate` is found, with one frame every `period` us and the first after `phase` us. With `blind`,
    /// traffic at another bit rate causes no bus error.
    fn frames_until_found(rate: BitRate, period: u64, phase: u64, blind: bool) -> u32 {
        let mut search = Autobaud::start(Instant::from_ticks(0));
        for frame in 0..5000 {
            let now = Instant::from_ticks(phase + u64::from(frame) * period);
            while search.deadline() < now {
                search.poll(search.deadline());
            }
            if search.rate() == rate {
                return frame + 1;
            }
            if !blind {
                search.error(now);
            }
        }
        panic!("{rate:?} with a frame every {period} us from {phase} us on is not found");
    }

    #[test]
    fn search_finds_bit_rate_for_any_frame_period() {
        for rate in BitRate::ALL {
            let frames = frames_until_found(rate, 10_000, 0, false);
            assert!(
                frames <= 11,
                "frames every 10 ms: found within eleven frames"
            );
            for ms in (20..25_000).step_by(7).chain([900, 950, 999, 1000, 20_970]) {
                assert!(frames_until_found(rate, ms * 1000, 0, false) <= 200);
            }
        }
    }

    #[test]
    fn search_without_bus_errors_finds_bit_rate_for_any_frame_period() {
        for rate in BitRate::ALL {
            for ms in [
                100, 250, 400, 500, 800, 1000, 1300, 1800, 2000, 5000, 10_000,
            ] {
                for phase in (0..2000).step_by(90) {
                    assert!(frames_until_found(rate, ms * 1000, phase * 1000, true) <= 500);
                }
            }
        }
    }
}
