//! Attempts that are all alike: an error passive transmitter repeats a frame that nobody acknowledges, and its counters do not
//! change. A simulation need not compute each of them.

use super::{Picoseconds, Protocol};

/// After this the state of a controller is the same again, except for the time and the number of error flags.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Period {
    /// The time after which the state is the same again.
    pub time: Picoseconds,
    error_flags: u64,
}

impl Protocol {
    /// The period that has passed since `earlier`, if the state is the same again. Without another participant on the wire it will
    /// come again after each further period.
    pub fn period_since(&self, earlier: &Self) -> Option<Period> {
        let period = Period {
            time: self.bit_start().checked_sub(earlier.bit_start())?,
            error_flags: self.error_flags.checked_sub(earlier.error_flags)?,
        };
        let mut again = earlier.clone();
        again.skip(period, 1);
        (again == *self).then_some(period)
    }

    /// Moves the state to the end of this many further periods.
    pub fn skip(&mut self, period: Period, count: u64) {
        self.clock.delay(count * period.time);
        self.frame_start += count * period.time;
        self.error_flags += count * period.error_flags;
    }
}
