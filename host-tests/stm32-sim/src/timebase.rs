//! Converts processor cycles to time and back. A cycle is an HCLK cycle, and HCLK changes when the firmware sets up the clocks.

pub use can_wire::protocol::Picoseconds;

/// A second in picoseconds.
pub const SECOND: Picoseconds = 1_000_000_000_000;

/// A microsecond in picoseconds.
pub const MICROSECOND: Picoseconds = 1_000_000;

/// The time of each cycle: a reference cycle with known time, and the frequency from there on.
///
/// One or two cycles at 8, 64 or 128 MHz take an integer number of picoseconds, which avoids a wide division: each access to a register
/// needs the time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Timebase {
    cycle: u64,
    time: Picoseconds,
    frequency: u32,
    /// An integer number of picoseconds, and the number of cycles that take this time; None if more than 8 cycles would be necessary.
    period: Option<(Picoseconds, u64)>,
}

impl Timebase {
    /// Cycle 0 is at time 0; `frequency` in Hz, not 0.
    pub fn new(frequency: u32) -> Self {
        Self {
            cycle: 0,
            time: 0,
            frequency,
            period: [1, 2, 4, 8]
                .into_iter()
                .find(|cycles| (SECOND * cycles).is_multiple_of(frequency.into()))
                .map(|cycles| (SECOND * cycles / u64::from(frequency), cycles)),
        }
    }

    /// The frequency of HCLK in Hz.
    pub fn frequency(&self) -> u32 {
        self.frequency
    }

    /// From `cycle` on, HCLK is `frequency` in Hz (not 0).
    pub fn set_frequency(&mut self, cycle: u64, frequency: u32) {
        *self = Self {
            cycle,
            time: self.time_at(cycle),
            ..Self::new(frequency)
        };
    }

    /// `cycle` begins at `time`: the clock was stopped until then.
    pub fn go_on(&mut self, cycle: u64, time: Picoseconds) {
        (self.cycle, self.time) = (cycle, time);
    }

    /// The time at which a cycle begins. Cycles before the last change of frequency return the time of that change.
    pub fn time_at(&self, cycle: u64) -> Picoseconds {
        let cycles = cycle.saturating_sub(self.cycle);
        self.time
            + match self.period {
                Some((period, 1)) => cycles * period,
                // The range is more than one day (10^17 ps).
                Some((period, count)) => cycles * period / count,
                None => {
                    let scaled = u128::from(cycles) * u128::from(SECOND);
                    (scaled / u128::from(self.frequency)) as u64
                }
            }
    }

    /// The first cycle that does not begin before `time`.
    pub fn cycle_at(&self, time: Picoseconds) -> u64 {
        self.cycle + self.cycles(time.saturating_sub(self.time))
    }

    /// The number of cycles in this time, rounded up.
    pub fn cycles(&self, length: Picoseconds) -> u64 {
        match self.period {
            Some((period, 1)) => length.div_ceil(period),
            Some((period, count)) => (length * count).div_ceil(period),
            None => {
                let scaled = u128::from(length) * u128::from(self.frequency);
                scaled.div_ceil(u128::from(SECOND)) as u64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_continuous_over_frequency_changes() {
        let mut base = Timebase::new(8_000_000);
        assert_eq!(base.time_at(8_000), 1_000 * MICROSECOND);
        base.set_frequency(8_000, 64_000_000);
        assert_eq!(base.time_at(8_000), 1_000 * MICROSECOND);
        assert_eq!(base.time_at(8_064), 1_001 * MICROSECOND);
        assert_eq!(base.cycle_at(1_001 * MICROSECOND), 8_064);
        assert_eq!(base.cycle_at(1_001 * MICROSECOND + 1), 8_065);
    }

    #[test]
    fn half_picoseconds_do_not_drift() {
        // 7812.5 ps
        let base = Timebase::new(128_000_000);
        assert_eq!((base.time_at(1), base.time_at(2)), (7_812, 15_625));
        assert_eq!((base.cycle_at(7_812), base.cycle_at(7_813)), (1, 2));
        assert_eq!(base.time_at(128_000_000 * 86_400), 86_400 * SECOND);
        for cycle in [1, 2, 3, 127, 128_000_001] {
            assert_eq!(base.cycle_at(base.time_at(cycle)), cycle);
        }
    }

    #[test]
    fn non_integer_cycle_length_does_not_drift() {
        let base = Timebase::new(72_000_000);
        assert_eq!(base.time_at(72_000_000 * 86_400), 86_400 * SECOND);
        for cycle in [1, 2, 3, 71, 72_000_001] {
            assert_eq!(base.cycle_at(base.time_at(cycle)), cycle);
        }
    }
}
