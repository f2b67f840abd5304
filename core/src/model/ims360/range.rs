//! The faults "value out of range" (5010h, 5020h), alike in CANopen and J1939.

use crate::time::{Deadline, Duration, Instant, millis};

/// The shortest time between two changes of a fault, so that a machine that digs floods neither the bus nor the histories.
const LEAST: Duration = millis(1000);

/// The least angle that changes the side of a sensor on its back, so that noise about 0 deg does not.
const LEAST_ANGLE: i32 = 1_00;

/// How an angle is out of its range.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Beyond {
    /// The angle is within its range.
    No,
    /// Above the range, or on its back with a positive angle.
    Above,
    /// Below the range, or on its back with a negative angle.
    Below,
    /// An axis of the accelerometer clips.
    Clips,
}

/// The fault of an angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct RangeFault {
    state: Beyond,
    /// The earliest time of the next change; unset: at once.
    next: Deadline,
}

impl RangeFault {
    pub const NONE: Self = Self {
        state: Beyond::No,
        next: Deadline::NEVER,
    };

    /// Takes the present judgement, unless the last change was less than a second ago.
    pub fn step(&mut self, now: Instant, beyond: Beyond) {
        let may_change = !self.next.is_set() || self.next.is_reached(now);
        if beyond != self.state && may_change {
            self.state = beyond;
            self.next = Deadline::after(now, LEAST);
        }
    }

    /// The side of a sensor that lies on its back with this angle.
    pub fn side(self, angle: i32) -> Beyond {
        match self.state {
            Beyond::Above if angle > -LEAST_ANGLE => Beyond::Above,
            Beyond::Below if angle < LEAST_ANGLE => Beyond::Below,
            _ if angle < 0 => Beyond::Below,
            _ => Beyond::Above,
        }
    }

    /// How the angle is out of its range now.
    pub fn state(self) -> Beyond {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_changes_at_most_once_a_second() {
        let mut fault = RangeFault::NONE;
        for (ms, judged, expected) in [
            (0, Beyond::No, Beyond::No),
            (100, Beyond::Above, Beyond::Above),
            (105, Beyond::No, Beyond::Above),
            (110, Beyond::Below, Beyond::Above),
            (1_099, Beyond::Clips, Beyond::Above),
            (1_100, Beyond::Clips, Beyond::Clips),
            (1_105, Beyond::No, Beyond::Clips),
            (2_095, Beyond::Clips, Beyond::Clips),
            (5_000, Beyond::No, Beyond::No),
            (5_999, Beyond::Above, Beyond::No),
            (6_000, Beyond::Above, Beyond::Above),
        ] {
            fault.step(Instant::from_ticks(ms * 1000), judged);
            assert_eq!(fault.state(), expected, "{ms} ms");
        }
    }

    #[test]
    fn side_on_the_back_changes_from_1_deg_on() {
        assert_eq!(RangeFault::NONE.side(0), Beyond::Above);
        let mut fault = RangeFault::NONE;
        for (second, angle, expected) in [
            (1, -1, Beyond::Below),
            (2, 99, Beyond::Below),
            (3, 100, Beyond::Above),
            (4, 0, Beyond::Above),
            (5, -99, Beyond::Above),
            (6, -100, Beyond::Below),
        ] {
            fault.step(Instant::from_ticks(second * 1_000_000), fault.side(angle));
            assert_eq!(fault.state(), expected, "{angle}");
        }
    }
}
