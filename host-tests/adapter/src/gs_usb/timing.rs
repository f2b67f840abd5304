//! The bit timing: a bit consists of a quantum for synchronisation, segment 1 and segment 2; the sample point is between the two.
//! Segment 1 is the propagation segment and phase segment 1 together.

use super::wire::Constants;
use plumbline::can::BitRate;
use std::cmp::Reverse;

/// The wanted sample point (CiA 301), in 1/1000 of a bit.
const SAMPLE_POINT: u64 = 875;

/// A bit timing, in quanta of `prescaler` clocks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BitTiming {
    /// The clocks of a quantum.
    pub prescaler: u32,
    /// Propagation segment and phase segment 1.
    pub segment_1: u32,
    /// Phase segment 2, in time quanta.
    pub segment_2: u32,
    /// The synchronization jump width, in time quanta.
    pub jump: u32,
}

impl BitTiming {
    /// The exact bit timing whose sample point is nearest to 87.5 %, and of these the one with the most quanta. None: the rate is no
    /// fraction of the clock within the limits.
    pub fn find(rate: BitRate, limits: &Constants) -> Option<Self> {
        let rate = rate.bits_per_second();
        if !limits.clock.is_multiple_of(rate) {
            return None;
        }
        let clocks = limits.clock / rate;
        let (least, most, step) = limits.prescaler;
        // A bit has three quanta or more.
        let prescalers = (least.max(1)..=most.min(clocks / 3)).step_by(step.max(1) as usize);
        prescalers
            .filter(|prescaler| clocks.is_multiple_of(*prescaler))
            .filter_map(|prescaler| Self::divide(prescaler, clocks / prescaler, limits))
            .min_by_key(Self::distance)
    }

    /// The best division of a bit with this number of quanta.
    fn divide(prescaler: u32, quanta: u32, limits: &Constants) -> Option<Self> {
        let (least, most) = limits.segment_2;
        (least.max(1)..=most.min(quanta - 2))
            .map(|segment_2| Self {
                prescaler,
                segment_1: quanta - 1 - segment_2,
                segment_2,
                jump: (segment_2 / 2).min(limits.jump).max(1),
            })
            .filter(|timing| {
                (limits.segment_1.0.max(1)..=limits.segment_1.1).contains(&timing.segment_1)
            })
            .min_by_key(Self::distance)
    }

    /// The distance to the wanted sample point in 1/1,000,000 of a bit, then the fewest quanta.
    fn distance(&self) -> (u64, Reverse<u32>) {
        let quanta = 1 + self.segment_1 + self.segment_2;
        let sample_point = u64::from(1 + self.segment_1) * 1_000_000 / u64::from(quanta);
        let distance = sample_point.abs_diff(SAMPLE_POINT * 1000);
        (distance, Reverse(quanta))
    }

    /// The words of the request. The adapter adds the propagation segment and phase segment 1.
    pub fn words(&self) -> [u32; 5] {
        let propagation = self.segment_1 / 2;
        let phase_1 = self.segment_1 - propagation;
        [
            propagation,
            phase_1,
            self.segment_2,
            self.jump,
            self.prescaler,
        ]
    }
}

#[cfg(test)]
mod tests;
