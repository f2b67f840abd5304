//! The heater that keeps the measuring cell at a constant temperature: a PID regulator (ifm JN2101 manual 9.7), and the judgement
//! whether the temperature stands (GEMAC manual 9.3 and 9.5, AccuracyWarning).
//!
//! ```text
//! duty = Kp (e + 1/Ti integral(e) - Td dT/dt),  e = set point - T,  held within 0..=100 %
//! ```
//!
//! - The heater cannot cool, and at the coldest it may not be strong enough. As long as the duty is held at an end, the integral
//!   does not move further to that side, and it never leaves 0..=100 % itself. So there is nothing to unwind when the temperature
//!   comes near.
//! - The derivative is that of the temperature and not of the error, through a low-pass of eight periods: the sensor's steps of
//!   some 0.01 K would shake the duty otherwise.
//! - All of it is integers. The integral is a sum of errors in 0.01 K, not of their rounded share of the duty, so that the last
//!   0.01 K counts too.

use crate::time::{Duration, Instant, after, millis, reached};

/// The period of the regulator: as often as the manual has the temperature determined (ifm JN2101 manual 9.9).
pub const PERIOD: Duration = millis(200);

/// The duty of a heater that is fully on, in permille.
pub const FULL: u16 = 1000;

/// Periods per second.
const RATE: u32 = 5;

/// The derivative's low-pass takes 2^this periods.
const SMOOTHING: u32 = 3;

/// What a model says of its heater and of the body that it heats.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// The temperature to hold, in 0.01 degC.
    pub set_point: i16,
    /// Kp in permille per K. Its inverse is the band in which the duty comes down from 100 %: 50 is a band of 20 K.
    pub proportional: u16,
    /// Ti in s, 1..=4000; 0 counts as 1. About the body's time constant: shorter, and the temperature
    /// overshoots by more than 0.6 K; longer, and it creeps to the set point.
    pub integral_time: u16,
    /// Td in 0.1 s: about the time by which the sensor lags behind the heater. 0 for a PI regulator.
    pub derivative_time: u16,
    /// What the heater takes when fully on, in mW.
    pub full_power: u16,
    /// How far from the set point the temperature may be when it is said to stand, in 0.01 K.
    pub tolerance: u16,
    /// How long it must have been that close, in s.
    pub steady_after: u16,
}

/// The regulator, and its judgement of the temperature.
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
    /// How many periods the temperature has been close to the set point.
    close_for: u32,
    /// In permille.
    duty: u16,
}

impl Heater {
    /// No heater: it never heats.
    pub const NONE: Self = Self {
        settings: None,
        enabled: false,
        integral: 0,
        trail: None,
        close_for: 0,
        duty: 0,
    };

    /// A heater that is enabled and has not heated yet.
    pub const fn new(settings: &'static Settings) -> Self {
        Self {
            settings: Some(settings),
            enabled: true,
            ..Self::NONE
        }
    }

    /// Switches the regulation on or off (ifm JN2101 manual 9.7, object 2041h). Off takes effect at once, and forgets everything;
    /// on takes effect with the next period. To set again what is set changes nothing.
    pub fn enable(&mut self, on: bool) {
        if !on {
            self.rest();
        }
        self.enabled = on;
    }

    /// True when the regulation is on.
    pub const fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Takes in the temperature of the measuring cell in 0.01 degC, once per [`PERIOD`], and returns the duty until the next one,
    /// 0..=1000 permille. Without a temperature (None: the sensor is missing or faulty) the heater is off and starts afresh later.
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

    /// The duty in force, 0..=1000 permille.
    pub const fn duty(&self) -> u16 {
        self.duty
    }

    /// The heating power in force, in mW (ifm JN2101 manual, object 4081h).
    pub fn power(&self) -> u16 {
        let full = self.settings.map_or(0, |settings| settings.full_power);
        (u32::from(full) * u32::from(self.duty) / u32::from(FULL)) as u16
    }

    /// True when the temperature stands: it has been as close to the set point as the settings ask for, for as long as they ask
    /// for. Its opposite is the AccuracyWarning (GEMAC manual 9.5), also while the heater is disabled or the sensor is faulty.
    pub fn is_steady(&self) -> bool {
        // At least one period, so that it is not steady before it has been measured.
        let periods = |settings: &Settings| (u32::from(settings.steady_after) * RATE).max(1);
        self.settings
            .is_some_and(|settings| self.close_for >= periods(settings))
    }

    fn judge(&mut self, settings: &Settings, error: i32) {
        let close = error.unsigned_abs() <= u32::from(settings.tolerance);
        self.close_for = if close {
            self.close_for.saturating_add(1)
        } else {
            0
        };
    }

    /// By how much the temperature is ahead of its smoothed value, in 0.01 K / 2^SMOOTHING. The smoothed value lags by 2^SMOOTHING
    /// periods, so this is 2^(2 SMOOTHING) times what the temperature rises in a period, in 0.01 K.
    fn slope(&self, temperature: i16) -> i32 {
        let scaled = i32::from(temperature) << SMOOTHING;
        scaled - self.trail.unwrap_or(scaled)
    }

    fn follow(&mut self, temperature: i16) {
        let scaled = i32::from(temperature) << SMOOTHING;
        let trail = self.trail.unwrap_or(scaled);
        self.trail = Some(trail + ((scaled - trail) >> SMOOTHING));
    }

    /// The regulator: `error` in 0.01 K, `slope` in 0.01 K / 2^SMOOTHING. Sums are in 0.01 permille.
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

    /// Off, with nothing remembered.
    fn rest(&mut self) {
        *self = Self {
            settings: self.settings,
            enabled: self.enabled,
            ..Self::NONE
        };
    }
}

/// Kp Td times the slope, in 0.01 permille.
fn derivative(settings: &Settings, slope: i32) -> i32 {
    // A tenth of a second is half a period.
    let gain = i32::from(settings.proportional).saturating_mul(i32::from(settings.derivative_time));
    gain.saturating_mul(slope) >> (2 * SMOOTHING + 1)
}

/// A measuring cell with its heater, which regulates with the first temperature and then once per [`PERIOD`].
#[derive(Clone, Debug)]
pub struct HeatedCell {
    heater: Heater,
    /// When the next temperature is taken in; None: with the next one.
    due: Option<Instant>,
}

impl HeatedCell {
    /// A cell without a heater.
    pub const UNHEATED: Self = Self {
        heater: Heater::NONE,
        due: None,
    };

    /// A cell that has not been heated yet.
    pub const fn new(settings: &'static Settings) -> Self {
        Self {
            heater: Heater::new(settings),
            due: None,
        }
    }

    /// Takes the temperature of the cell in 0.01 degC in, when it is time to; true when it was.
    pub fn take(&mut self, now: Instant, temperature: i16) -> bool {
        let due = self.due.is_none_or(|due| reached(now, due));
        if due {
            self.due = Some(after(now, PERIOD));
            self.heater.regulate(Some(temperature));
        }
        due
    }

    /// Off at once; the next temperature starts the regulator afresh.
    pub fn stop(&mut self) {
        self.due = None;
        self.heater.regulate(None);
    }

    /// Switches the regulation on or off, as [`Heater::enable`] does.
    pub fn enable(&mut self, on: bool) {
        self.heater.enable(on);
    }

    /// The heater.
    pub const fn heater(&self) -> &Heater {
        &self.heater
    }
}

#[cfg(test)]
mod tests;
