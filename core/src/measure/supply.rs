//! The supply voltage of the sensor: a low-pass, and the check of its limits.

/// The base-2 logarithm of the number of measurements in the time constant of the low-pass: 80 ms.
const SMOOTHING: u32 = 4;

/// The limits of a supply, in mV.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Limits {
    /// A lower supply is a fault.
    pub lowest: u16,
    /// A higher supply is a fault.
    pub highest: u16,
    /// The fault ends when the supply is within the limits by this.
    pub hysteresis: u16,
}

impl Limits {
    /// The limits of the sensors for vehicles with 12 or 24 V. Their manuals have no numbers.
    pub const VEHICLE: Self = Self {
        lowest: 8_000,
        highest: 36_000,
        hysteresis: 500,
    };
}

/// The monitor of a supply.
///
/// ```
/// use plumbline::measure::supply::{Limits, Monitor};
///
/// let mut monitor = Monitor::NONE;
/// let changed = monitor.step(7_990, &Limits::VEHICLE);
/// assert!(changed && monitor.is_faulty());
/// assert_eq!(monitor.millivolts(), 7_990);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Monitor {
    /// The filtered voltage in mV, multiplied by 2^SMOOTHING; 0 before the first measurement.
    smoothed: u32,
    faulty: bool,
}

impl Monitor {
    /// The state before the first measurement: no fault.
    pub const NONE: Self = Self {
        smoothed: 0,
        faulty: false,
    };

    /// Processes a measurement in mV, one every [`SAMPLE_PERIOD`](super::SAMPLE_PERIOD). Returns true if the fault has begun or ended.
    /// The first measurement counts at once.
    pub fn step(&mut self, millivolts: u16, limits: &Limits) -> bool {
        let input = u32::from(millivolts);
        self.smoothed = if self.smoothed == 0 {
            input << SMOOTHING
        } else {
            // At most 65535 * 16.
            self.smoothed
                .wrapping_sub(self.smoothed >> SMOOTHING)
                .wrapping_add(input)
        };
        let before = self.faulty;
        let margin = if before { limits.hysteresis } else { 0 };
        let voltage = self.millivolts();
        self.faulty = voltage < limits.lowest.saturating_add(margin)
            || voltage > limits.highest.saturating_sub(margin);
        self.faulty != before
    }

    /// The filtered voltage in mV; 0 before the first measurement.
    pub const fn millivolts(&self) -> u16 {
        (self.smoothed >> SMOOTHING) as u16
    }

    /// Whether the supply is outside its limits.
    pub const fn is_faulty(&self) -> bool {
        self.faulty
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits::VEHICLE;

    /// The monitor after two seconds at each of these voltages: the fault, and how often it has changed.
    fn after(voltages: &[u16]) -> (bool, usize) {
        let mut monitor = Monitor::NONE;
        let steps = voltages.iter().flat_map(|voltage| [*voltage; 400]);
        let changes = steps.filter(|voltage| monitor.step(*voltage, &LIMITS));
        let changes = changes.count();
        (monitor.is_faulty(), changes)
    }

    #[test]
    fn fault_begins_outside_limits_and_ends_with_hysteresis() {
        for voltages in [[8_000; 2], [36_000; 2], [24_000; 2]] {
            assert_eq!(after(&voltages), (false, 0));
        }
        for outside in [7_999, 36_001, 1, u16::MAX] {
            assert_eq!(after(&[outside]), (true, 1), "{outside}");
            assert_eq!(after(&[24_000, outside]), (true, 1), "{outside}");
        }
        assert_eq!(after(&[7_900, 8_499]), (true, 1));
        assert_eq!(after(&[7_900, 8_500]), (false, 2));
        assert_eq!(after(&[36_100, 35_502]), (true, 1));
        assert_eq!(after(&[36_100, 35_500]), (false, 2));
    }

    #[test]
    fn voltage_settles_exactly() {
        for voltage in [1, 7_999, 8_500, 24_000, u16::MAX] {
            let mut monitor = Monitor::NONE;
            assert_eq!(monitor.millivolts(), 0);
            monitor.step(12_000, &LIMITS);
            assert_eq!(monitor.millivolts(), 12_000);
            for _ in 0..400 {
                monitor.step(voltage, &LIMITS);
            }
            assert_eq!(monitor.millivolts(), voltage);
        }
    }

    #[test]
    fn dip_of_a_sample_is_no_fault() {
        let mut monitor = Monitor::NONE;
        monitor.step(24_000, &LIMITS);
        assert!(!monitor.step(0, &LIMITS) && !monitor.is_faulty());
    }
}
