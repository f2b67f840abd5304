//! Automatic bit rate detection: listens at the measured bit rate until it receives a valid frame.
//!
//! The controller is in listen-only mode, so a wrong bit rate does not disturb the bus. [`PulseMeter`](super::PulseMeter) measures
//! the bit time of each frame, at any bit rate of the controller, so one frame is sufficient to find the bit rate. A silent bus
//! changes nothing: there is no dwell time, and the search has no time limit. The search begins at power-up. If it ends before the
//! first reading, the node waits for the reading and continues to listen.
//!
//! The measured bit rate can be wrong: receivers at a distance lengthen the ACK slot, transceivers change the length of each dominant
//! pulse, and a frame that nobody acknowledges can have no dominant pulse of one bit. If the controller detects bus errors at the
//! measured bit rate and the next frame measures the same bit rate, the search tries the next faster bit rates at which the measured
//! pulse has at most 4 bits. Then it tries the next slower bit rate, then the measured one again.

use crate::can::BitRate;
use crate::walk::{each, put};

/// The length of a bit, in units of 1/16 us.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitTime(pub u16);

impl BitTime {
    /// The number of units in a microsecond.
    pub const PER_US: u32 = 16;

    /// The bit time of a bit rate; an integer number of units for all of them.
    pub const fn of(rate: BitRate) -> Self {
        Self((Self::PER_US * 1_000_000 / rate.bits_per_second()) as u16)
    }

    /// The bit times of [`BitRate::ALL`].
    const ALL: [Self; BitRate::ALL.len()] = {
        let mut times = [Self(0); BitRate::ALL.len()];
        each!(place, rate in &BitRate::ALL => { put(&mut times, place, Self::of(*rate)) });
        times
    };

    /// The bit rate with the nearest bit time.
    pub fn nearest_rate(self) -> BitRate {
        let pairs = BitRate::ALL.into_iter().zip(Self::ALL);
        let nearest = pairs.min_by_key(|(_, time)| time.0.abs_diff(self.0));
        nearest.map_or(Autobaud::FIRST, |(rate, _)| rate)
    }
}

/// The search for the bit rate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Autobaud {
    rate: BitRate,
    /// The last measured bit rate.
    measured: Option<BitRate>,
    /// There was a bus error at the present bit rate.
    failed: bool,
    /// There was a valid frame at the present bit rate.
    found: bool,
}

impl Autobaud {
    /// The bit rate before the first measurement: the most common one of vehicles and machines.
    const FIRST: BitRate = BitRate::K250;

    /// The start of a search.
    pub const START: Self = Self {
        rate: Self::FIRST,
        measured: None,
        failed: false,
        found: false,
    };

    /// The bit rate to listen at.
    pub fn rate(&self) -> BitRate {
        self.rate
    }

    /// A frame without error was received: the bit rate is the right one.
    pub fn receive(&mut self) {
        self.found = true;
    }

    /// The bit rate at which there was a valid frame.
    pub fn found(&self) -> Option<BitRate> {
        self.found.then_some(self.rate)
    }

    /// There was a bus error, so the bit rate can be wrong.
    pub fn error(&mut self) {
        self.failed = true;
    }

    /// Handles a measured bit time. Returns true if the bit rate to listen at has changed.
    pub fn measured(&mut self, time: BitTime) -> bool {
        let rate = time.nearest_rate();
        let next = match self.measured.replace(rate) {
            Some(last) if last == rate => {
                if !self.failed {
                    return false;
                }
                self.neighbour(rate, time)
            }
            // A short pulse may be missing, because the processor was busy. The next frame decides.
            Some(last) if (rate as u8) < last as u8 => return false,
            _ => rate,
        };
        self.failed = false;
        let changed = core::mem::replace(&mut self.rate, next) != next;
        self.found &= !changed;
        changed
    }

    /// The bit rate to try after errors at the present one: the next faster one if the measured pulse has at most 4 bits there,
    /// otherwise the next slower one than the measured bit rate. Without a slower one, the measured bit rate.
    fn neighbour(&self, measured: BitRate, time: BitTime) -> BitRate {
        let faster = BitRate::ALL.get(self.rate as usize + 1).copied();
        let slower = BitRate::ALL.get((measured as usize).wrapping_sub(1));
        faster
            .filter(|&rate| u32::from(time.0) < 5 * u32::from(BitTime::of(rate).0))
            .or(slower.copied())
            .unwrap_or(measured)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_begins_at_250_kbit() {
        assert_eq!(Autobaud::START.rate(), BitRate::K250);
    }

    #[test]
    fn each_bit_rate_is_found_with_first_measurement() {
        for rate in BitRate::ALL {
            let mut search = Autobaud::START;
            search.error();
            let changed = search.measured(BitTime::of(rate));
            assert_eq!(changed, rate != BitRate::K250);
            assert_eq!(search.rate(), rate);
            assert!(!search.measured(BitTime::of(rate)));
        }
    }

    #[test]
    fn valid_frame_ends_search_until_bit_rate_changes() {
        let mut search = Autobaud::START;
        assert_eq!(search.found(), None);
        search.receive();
        assert_eq!(search.found(), Some(BitRate::K250));
        search.measured(BitTime::of(BitRate::K500));
        assert_eq!(search.found(), None);
        search.receive();
        search.measured(BitTime::of(BitRate::K500));
        assert_eq!(search.found(), Some(BitRate::K500));
    }

    #[test]
    fn pulse_lengthened_by_tenth_of_bit_measures_same_bit_rate() {
        for rate in BitRate::ALL {
            let BitTime(time) = BitTime::of(rate);
            assert_eq!(BitTime(time + time / 10).nearest_rate(), rate);
            assert_eq!(BitTime(time - time / 10).nearest_rate(), rate);
        }
    }

    #[test]
    fn errors_at_measured_bit_rate_lead_to_its_neighbours() {
        use BitRate::*;
        for (measured, rates) in [
            // An ACK slot that is longer by 30 % at 1 Mbit/s, or shorter by 15 % at 50 kbit/s.
            (BitTime(16 + 5), &[K800, M1, K500, K800, M1][..]),
            (BitTime(320 - 48), &[K62_5, K100, K125, K250, K50]),
            // Frames without acknowledge whose shortest pulse has 2 bits at 1 Mbit/s, 3 at 125 kbit/s, or 4 at 10 kbit/s.
            (BitTime(2 * 16), &[K500, K800, M1, K250, K500]),
            (BitTime(3 * 128), &[K50, K62_5, K100, K125, K20, K50]),
            (BitTime(4 * 1600), &[K10]),
        ] {
            let mut search = Autobaud::START;
            for &expected in rates {
                search.error();
                assert!(search.measured(measured));
                assert_eq!(search.rate(), expected);
                // Without errors, the same measurement changes nothing.
                assert!(!search.measured(measured));
            }
        }
    }

    #[test]
    fn slower_measurement_is_confirmed_by_next_frame() {
        let [fast, slow] = [BitRate::M1, BitRate::K500];
        let mut search = Autobaud::START;
        search.measured(BitTime::of(fast));
        search.error();
        assert!(!search.measured(BitTime::of(slow)), "a missing short pulse");
        assert!(!search.measured(BitTime::of(fast)));
        assert_eq!(search.rate(), fast);
        // The bit rate of the bus has changed. It is found among the neighbours of the measured one.
        search.error();
        assert!(!search.measured(BitTime::of(slow)));
        for expected in [BitRate::K250, slow] {
            search.error();
            assert!(search.measured(BitTime::of(slow)));
            assert_eq!(search.rate(), expected);
        }
    }

    #[test]
    fn errors_at_fastest_bit_rate_lead_to_next_slower_one() {
        let mut search = Autobaud::START;
        for expected in [BitRate::M1, BitRate::K800, BitRate::M1] {
            search.error();
            search.measured(BitTime::of(BitRate::M1));
            assert_eq!(search.rate(), expected);
        }
    }

    #[test]
    fn errors_at_slowest_bit_rate_lead_back_to_it() {
        let mut search = Autobaud::START;
        let mut rates = vec![];
        for _ in 0..4 {
            search.error();
            search.measured(BitTime::of(BitRate::K10));
            rates.push(search.rate());
        }
        use BitRate::*;
        assert_eq!(rates, [K10, K20, K10, K20]);
    }

    #[test]
    fn error_before_measurement_of_present_bit_rate_changes_nothing() {
        let mut search = Autobaud::START;
        search.error();
        assert!(!search.measured(BitTime::of(BitRate::K250)));
        assert!(!search.measured(BitTime::of(BitRate::K250)));
        assert_eq!(search.rate(), BitRate::K250);
    }
}
