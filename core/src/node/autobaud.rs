//! Automatic bit rate detection: listen at one rate after the other until a frame is understood.
//!
//! The controller only listens, so a wrong rate disturbs nobody. A bus error shows that there is traffic at another rate: move
//! on at once. Silence, or traffic so different that it is not even seen as an error: move on after a dwell. The search never
//! ends by itself; a restart begins it anew.

use crate::can::BitRate;
use crate::time::{Duration, Instant, after, millis, reached};

/// The order of the search: the rates most used in vehicles and machines first.
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

/// The shortest dwell at one rate. The longest frame has 160 bits, 16 ms at 10 kbit/s; listening begins anywhere, so the rest
/// of one frame and one whole frame must fit, after up to 27 ms in which the controller changes its rate.
pub const DWELL_MIN: Duration = millis(80);

/// The longest dwell at one rate.
pub const DWELL_MAX: Duration = millis(180);

/// The search for the bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Autobaud {
    candidate: u8,
    /// The state of a generator of random numbers, one for each dwell.
    random: u16,
    until: Instant,
}

impl Autobaud {
    /// Begins to listen at the first candidate.
    pub fn start(now: Instant) -> Self {
        Self {
            candidate: 0,
            random: 1,
            until: after(now, DWELL_MIN),
        }
    }

    /// The rate to listen at.
    pub fn rate(&self) -> BitRate {
        CANDIDATES
            .get(usize::from(self.candidate))
            .copied()
            .unwrap_or(BitRate::K250)
    }

    /// A bus error was seen: on to the next candidate.
    pub fn error(&mut self, now: Instant) {
        self.next(now);
    }

    /// Moves on when the dwell is over; true when the rate has changed.
    pub fn poll(&mut self, now: Instant) -> bool {
        let over = reached(now, self.until);
        if over {
            self.next(now);
        }
        over
    }

    /// The end of the dwell.
    pub fn deadline(&self) -> Instant {
        self.until
    }

    fn next(&mut self, now: Instant) {
        self.candidate = (self.candidate + 1) % CANDIDATES.len() as u8;
        // A dwell of random length: if it were always the same, frames in step with it would meet the same wrong candidate for
        // ever. A linear congruential generator of full period; its upper bits are the better ones.
        self.random = self.random.wrapping_mul(25_173).wrapping_add(13_849);
        let extra = u32::from(self.random >> 8) * 100 / 255;
        self.until = after(now, DWELL_MIN + millis(extra));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONGEST_FRAME_BITS: u64 = 160;
    /// The longest time that a controller may take to change its rate: the end of a frame, and 11 recessive bits; in us.
    const RATE_CHANGE_MAX: u64 = 27_000;

    #[test]
    fn every_rate_is_a_candidate_once() {
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
    fn the_dwell_fits_the_slowest_frame_joined_late() {
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
    fn a_silent_bus_is_searched_for_ever() {
        let mut search = Autobaud::start(Instant::from_ticks(0));
        for round in 0..1000 {
            assert_eq!(search.rate(), CANDIDATES[round % 10]);
            let before = Instant::from_ticks(search.deadline().ticks() - 1);
            assert!(!search.poll(before));
            assert!(search.poll(search.deadline()));
        }
    }

    /// One frame every `period` us at `rate`, the first after `phase` us: how many frames until it is found? When `blind`, traffic
    /// at another rate is not even seen as an error.
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
        panic!("{rate:?} with a frame every {period} us from {phase} us on is never found");
    }

    #[test]
    fn no_frame_period_hides_a_rate() {
        for rate in BitRate::ALL {
            let frames = frames_until_found(rate, 10_000, 0, false);
            assert!(frames <= 11, "a busy bus is found within eleven frames");
            for ms in (20..25_000).step_by(7).chain([900, 950, 999, 1000, 20_970]) {
                assert!(frames_until_found(rate, ms * 1000, 0, false) <= 200);
            }
        }
    }

    #[test]
    fn no_frame_period_hides_a_rate_whose_frames_are_no_errors_elsewhere() {
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
