//! The heater that keeps the measuring cell at a constant temperature: a PID controller (ifm JN2101 manual 9.7), and the check
//! whether the temperature is steady (GEMAC manual 9.3 and 9.5, AccuracyWarning).
//!
//! ```text
//! duty = Kp (e + 1/Ti integral(e) - Td dT/dt),  e = set point - T,  limited to 0..=100 %
//! ```
//!
//! - Anti-windup: the heater cannot cool, and at low ambient temperatures its power can be too low. While the duty is at a limit,
//!   the integral does not move further in that direction. The integral itself stays within 0..=100 %.
//! - The derivative term uses the temperature and not the error, filtered by a low-pass over eight periods. Otherwise the
//!   resolution of the sensor, some 0.01 K, would make the duty noisy.
//! - The arithmetic uses integers. The integral is a sum of errors in 0.01 K and not of rounded duties, so that an error of 0.01
//!   K also has an effect.

use crate::time::{Deadline, Duration, Instant, millis};

/// The period of the controller. It is the period of the temperature measurement (ifm JN2101 manual 9.9).
pub const PERIOD: Duration = millis(200);

/// The duty at full power, in permille.
pub const FULL: u16 = 1000;

/// The number of [`PERIOD`]s in a second.
const RATE: u32 = 5;

/// The low-pass of the derivative term has a time constant of 2^SMOOTHING periods.
const SMOOTHING: u32 = 3;

/// Bit of the kept state: the temperature was steady. The integral is below it with each permitted integral time.
const WAS_STEADY: u32 = 1 << 31;

/// The settings for the heater and the measuring cell of a product.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// The temperature set point, in 0.01 degC.
    pub set_point: i16,
    /// Kp in permille per K. The proportional band is 1000 / Kp: 50 gives a band of 20 K.
    pub proportional: u16,
    /// Ti in s, 1..=4000; 0 acts as 1. Choose about the time constant of the measuring cell. With a shorter time, the temperature
    /// overshoots by more than 0.6 K. With a longer time, it approaches the set point slowly.
    pub integral_time: u16,
    /// Td in 0.1 s. Choose about the delay between heater and temperature sensor. 0 gives a PI controller.
    pub derivative_time: u16,
    /// The power of the heater at a duty of 100 %, in mW.
    pub full_power: u16,
    /// The permitted difference between a steady temperature and the set point, in 0.01 K.
    pub tolerance: u16,
    /// The time for which the difference must be within the tolerance, in s.
    pub steady_after: u16,
}

/// The controller, and the check of the temperature.
///
/// ```
/// use plumbline::heater::{Heater, Settings};
///
/// static SETTINGS: Settings = Settings {
///     set_point: 50_00,
///     proportional: 50,
///     integral_time: 100,
///     derivative_time: 30,
///     full_power: 1500,
///     tolerance: 50,
///     steady_after: 30,
/// };
/// let mut heater = Heater::new(&SETTINGS);
/// assert_eq!(heater.regulate(Some(20_00)), 1000);
/// assert_eq!(heater.power(), 1500);
/// assert_eq!(heater.regulate(Some(60_00)), 0);
/// assert!(!heater.is_steady());
/// ```
#[derive(Clone, Debug)]
pub struct Heater {
    /// None: there is no heater.
    settings: Option<&'static Settings>,
    enabled: bool,
    /// Kp times the sum of the errors, in 0.01 permille.
    integral: u32,
    /// The smoothed temperature times 2^SMOOTHING, in 0.01 degC; None before the first temperature.
    trail: Option<i32>,
    /// The number of consecutive periods within the tolerance.
    close_for: u32,
    /// The temperature was steady before a restart: it is steady again at the next temperature within the tolerance.
    was_steady: bool,
    /// The last output, in permille of the full power.
    duty: u16,
}

impl Heater {
    /// No heater: the duty is always 0.
    pub const NONE: Self = Self {
        settings: None,
        enabled: false,
        integral: 0,
        trail: None,
        close_for: 0,
        was_steady: false,
        duty: 0,
    };

    /// An enabled heater before its first period.
    pub const fn new(settings: &'static Settings) -> Self {
        Self {
            settings: Some(settings),
            enabled: true,
            ..Self::NONE
        }
    }

    /// The state to keep over a restart of the program; 0: there is nothing to keep.
    pub fn kept(&self) -> u32 {
        let steady = if self.is_steady() { WAS_STEADY } else { 0 };
        self.integral.min(WAS_STEADY - 1) | steady
    }

    /// Goes on with the state of [`kept`](Self::kept) of the heater before the restart: the duty has no step, and the steady
    /// temperature need not be judged again.
    pub fn resume(&mut self, kept: u32) {
        self.integral = kept & !WAS_STEADY;
        self.was_steady = kept & WAS_STEADY != 0;
    }

    /// Switches the control on or off. Off acts at once and resets the controller. On acts
    /// in the next period. Setting the same state again has no effect.
    pub fn enable(&mut self, on: bool) {
        if !on {
            self.rest();
        }
        self.enabled = on;
    }

    /// Call it once per [`PERIOD`] with the temperature of the measuring cell in 0.01 degC. Returns the duty for the next period,
    /// 0..=1000 permille. With None (temperature sensor missing or faulty), the heater is off and the controller is reset.
    pub fn regulate(&mut self, temperature: Option<i16>) -> u16 {
        let (Some(temperature), Some(settings), true) = (temperature, self.settings, self.enabled)
        else {
            self.rest();
            return 0;
        };
        let error = i32::from(settings.set_point) - i32::from(temperature);
        self.judge(settings, error);
        self.duty = self.duty_for(settings, error, self.slope(temperature));
        self.follow(temperature);
        self.duty
    }

    /// The present duty, 0..=1000 permille.
    pub const fn duty(&self) -> u16 {
        self.duty
    }

    /// The present heating power, in mW.
    pub fn power(&self) -> u16 {
        let full = self.settings.map_or(0, |settings| settings.full_power);
        (u32::from(full) * u32::from(self.duty) / u32::from(FULL)) as u16
    }

    /// True if the temperature is steady: within [`Settings::tolerance`] of the set point for at least
    /// [`Settings::steady_after`]. If false, measurements can be less accurate. False while the heater is disabled
    /// or the temperature sensor is faulty.
    pub fn is_steady(&self) -> bool {
        self.settings
            .is_some_and(|settings| self.close_for >= periods(settings))
    }

    fn judge(&mut self, settings: &Settings, error: i32) {
        let close = error.unsigned_abs() <= u32::from(settings.tolerance);
        if !close {
            self.close_for = 0;
        } else if core::mem::take(&mut self.was_steady) {
            self.close_for = periods(settings);
        } else {
            self.close_for = self.close_for.saturating_add(1);
        }
    }

    /// The difference between the temperature and its smoothed value, in 0.01 K / 2^SMOOTHING. The smoothed value has a delay of
    /// 2^SMOOTHING periods, so this is 2^(2 SMOOTHING) times the rise of the temperature in one period, in 0.01 K.
    fn slope(&self, temperature: i16) -> i32 {
        let scaled = i32::from(temperature) << SMOOTHING;
        scaled - self.trail.unwrap_or(scaled)
    }

    fn follow(&mut self, temperature: i16) {
        let scaled = i32::from(temperature) << SMOOTHING;
        let trail = self.trail.unwrap_or(scaled);
        self.trail = Some(trail + ((scaled - trail) >> SMOOTHING));
    }

    /// The PID controller: `error` in 0.01 K, `slope` in 0.01 K / 2^SMOOTHING. Sums are in 0.01 permille.
    fn duty_for(&mut self, settings: &Settings, error: i32, slope: i32) -> u16 {
        const END: i32 = FULL as i32 * 100;
        let proportional = i32::from(settings.proportional).saturating_mul(error);
        let quick = proportional.saturating_sub(derivative(settings, slope));

        let time = (u32::from(settings.integral_time) * RATE).max(1);
        let before = quick.saturating_add((self.integral / time) as i32);
        let driven_further = (before >= END && error > 0) || (before <= 0 && error < 0);
        if !driven_further {
            let most = (END as u32).saturating_mul(time);
            self.integral = self.integral.saturating_add_signed(proportional).min(most);
        }
        let sum = quick.saturating_add((self.integral / time) as i32);
        (sum.clamp(0, END) / 100) as u16
    }

    /// Switches the heater off and resets the controller.
    fn rest(&mut self) {
        *self = Self {
            settings: self.settings,
            enabled: self.enabled,
            ..Self::NONE
        };
    }
}

/// The number of periods within the tolerance after which the temperature is steady. At least one, so that it is not steady before
/// the first measurement.
fn periods(settings: &Settings) -> u32 {
    (u32::from(settings.steady_after) * RATE).max(1)
}

/// Kp Td times the slope, in 0.01 permille.
fn derivative(settings: &Settings, slope: i32) -> i32 {
    // 0.1 s is half a period.
    let gain = i32::from(settings.proportional).saturating_mul(i32::from(settings.derivative_time));
    gain.saturating_mul(slope) >> (2 * SMOOTHING + 1)
}

/// A measuring cell with its heater. The controller runs with the first temperature and then once per [`PERIOD`].
#[derive(Clone, Debug)]
pub struct HeatedCell {
    heater: Heater,
    /// The time of the next controller period; unset: at the next temperature.
    due: Deadline,
    /// The state of the heater before it was stopped.
    kept: u32,
}

impl HeatedCell {
    /// A cell without a heater.
    pub const UNHEATED: Self = Self {
        heater: Heater::NONE,
        due: Deadline::NEVER,
        kept: 0,
    };

    /// A heated cell before its first period.
    pub const fn new(settings: &'static Settings) -> Self {
        Self {
            heater: Heater::new(settings),
            ..Self::UNHEATED
        }
    }

    /// Runs the controller with the temperature of the cell in 0.01 degC, if a period is due. Returns true if it was.
    pub fn take(&mut self, now: Instant, temperature: i16) -> bool {
        let due = !self.due.is_set() || self.due.is_reached(now);
        if due {
            self.due = Deadline::after(now, PERIOD);
            self.heater.regulate(Some(temperature));
        }
        due
    }

    /// Goes on with the state of the cell before a restart of the program.
    pub fn resume(&mut self, kept: u32) {
        self.heater.resume(kept);
    }

    /// The state before it was [stopped](Self::stop), to keep over a restart of the program.
    pub const fn kept(&self) -> u32 {
        self.kept
    }

    /// Switches the heater off and resets the controller. The next temperature starts it again.
    pub fn stop(&mut self) {
        self.due = Deadline::NEVER;
        self.kept = self.heater.kept();
        self.heater.regulate(None);
    }

    /// Switches the control on or off, see [`Heater::enable`].
    pub fn enable(&mut self, on: bool) {
        self.heater.enable(on);
    }

    /// The controller, for its state and its duty.
    pub const fn heater(&self) -> &Heater {
        &self.heater
    }
}

#[cfg(test)]
mod tests;
