//! How many values are missing between those that came.
//!
//! A counter in the values tells it. If it is far ahead of the time, the sensor was off and the counter has begun again. Without one, the times tell it: the values have places on a grid with the period. A value can be late,
//! also several at once, because the computer or the adapter was late. So the earliest value of some periods tells how many are missing.
//! The grid follows the clock of the sensor.

use plumbline::time::{Duration, Instant};

/// The periods after which the grid is compared with the values.
const WINDOW: f64 = 24.0;

/// The fraction of a deviation by which the grid is corrected, and the fraction by which its period is corrected.
const FOLLOWS: [f64; 2] = [0.5, 0.0625];

/// How much the clock of a sensor can deviate.
const CLOCK: f64 = 1.0 / 64.0;

/// How far in us a counter can be ahead of the time. If a computer or an adapter is late, the counter only seems to be behind.
const AHEAD: i64 = 1_000_000;

/// How much the clock of a sensor can deviate, as the divisor of a time.
const CLOCK_DIVISOR: u64 = 64;

/// The last values; at the end they tell what is missing.
const LAST: usize = 4;

/// The values of a sensor that sends with a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count {
    /// The period; None: it is not known, so nothing is counted.
    every: Option<Duration>,
    /// The times of the first and of the last value, or of the start.
    first: Option<Instant>,
    last: Instant,
    /// The counter of the last value.
    counter: Option<u16>,
    /// The periods since the first value, by the counter.
    periods: u64,
    /// The lateness in us of the earliest value with a counter. It rises with the clock of a sensor that is slow.
    earliest: i64,
    /// The number of times the counter began again.
    restarts: u64,
    grid: Grid,
    /// The missing values until the last comparison; -1: there is one more than periods, because the first one was late.
    missing: i64,
}

/// The grid; times and periods in us.
#[derive(Clone, Copy, Debug)]
struct Grid {
    period: f64,
    /// The place of the last value.
    place: f64,
    /// The time of the last comparison.
    start: f64,
    /// The values since then, and the delay of the earliest value.
    values: f64,
    earliest: f64,
    /// The lateness of the last values, from the oldest on.
    last: [f64; LAST],
}

fn us(time: Instant) -> f64 {
    time.ticks() as f64
}

impl Grid {
    fn new(every: Option<Duration>, start: Instant) -> Self {
        Self {
            period: every.map_or(1.0, |every| every.ticks() as f64).max(1.0),
            place: us(start),
            start: us(start),
            values: 0.0,
            earliest: f64::INFINITY,
            last: [f64::INFINITY; LAST],
        }
    }

    /// The next value. Returns how many more values are missing.
    fn take(&mut self, at: f64, every: f64) -> f64 {
        self.place += self.period;
        self.values += 1.0;
        let late = at - self.place;
        self.earliest = self.earliest.min(late);
        self.last.rotate_left(1);
        self.last[LAST - 1] = late;
        let passed = at - self.start;
        if passed < WINDOW * every {
            return 0.0;
        }
        let missing = (self.earliest / self.period).round();
        let late = self.earliest - missing * self.period;
        let most = passed * CLOCK;
        let [grid, period] = FOLLOWS;
        let shift = missing * self.period + (late * grid).clamp(-most, most);
        self.place += shift;
        self.last = self.last.map(|late| late - shift);
        let periods = (self.values + missing).max(1.0);
        let range = (1.0 - CLOCK) * every..=(1.0 + CLOCK) * every;
        self.period += late / periods * period;
        self.period = self.period.clamp(*range.start(), *range.end());
        (self.start, self.values, self.earliest) = (at, 0.0, f64::INFINITY);
        missing
    }

    /// The values that are missing since the last comparison.
    fn missing(&self, now: f64) -> f64 {
        let earliest = self.last.iter().copied().fold(f64::INFINITY, f64::min);
        let missing = match earliest.is_finite() {
            true => (earliest / self.period).round(),
            false => 0.0,
        };
        let place = self.place + missing * self.period;
        let after = ((now - place) / self.period).round() - 1.0;
        missing + after.max(0.0)
    }
}

impl Count {
    pub(super) fn new(every: Option<Duration>, start: Instant) -> Self {
        Self {
            every,
            first: None,
            last: start,
            counter: None,
            periods: 0,
            earliest: 0,
            restarts: 0,
            grid: Grid::new(every, start),
            missing: 0,
        }
    }

    /// A value came. Returns the time since the first value.
    pub(super) fn take(&mut self, at: Instant, counter: Option<u16>) -> Duration {
        let before_at = std::mem::replace(&mut self.last, at);
        let Some(first) = self.first else {
            (self.first, self.counter) = (Some(at), counter);
            self.grid = Grid::new(self.every, at);
            return Duration::from_ticks(0);
        };
        let Some(every) = self.every else {
            return Duration::from_ticks(at.ticks().saturating_sub(first.ticks()));
        };
        if let (Some(counter), Some(before)) = (counter, self.counter) {
            let passed = self.passed(at, before_at, counter.wrapping_sub(before), every);
            self.missing += passed as i64 - 1;
            self.periods += passed;
            self.counter = Some(counter);
            self.grid = Grid::new(self.every, at);
            return Duration::from_ticks(self.periods * every.ticks());
        }
        let missing = self.grid.take(us(at), every.ticks() as f64);
        self.missing = (self.missing + missing as i64).max(-1);
        Duration::from_ticks(at.ticks().saturating_sub(first.ticks()))
    }

    /// The periods since the value before, by the counter, or by the time if the counter began again.
    fn passed(&mut self, at: Instant, before: Instant, counted: u16, every: Duration) -> u64 {
        let every = every.ticks().max(1);
        let first = self.first.unwrap_or(at);
        let elapsed = at.ticks().saturating_sub(before.ticks());
        let time = at.ticks().saturating_sub(first.ticks()) as i64;
        let late = |periods: u64| time - (periods * every) as i64;
        let earliest = self.earliest + (elapsed / CLOCK_DIVISOR) as i64;
        let mut passed = u64::from(counted.max(1));
        self.earliest = earliest.min(late(self.periods + passed));
        if passed > 1 && self.earliest < earliest - AHEAD {
            passed = ((elapsed + every / 2) / every).max(1);
            self.earliest = earliest.min(late(self.periods + passed));
            self.restarts += 1;
        }
        passed
    }

    /// The number of times the counter of the sensor began again.
    pub(super) fn restarts(&self) -> u64 {
        self.restarts
    }

    /// The values that are missing until now, which is the end.
    pub(super) fn missing(&self, now: Instant) -> u64 {
        match self.every {
            Some(_) => {
                let missing = self.missing + self.grid.missing(us(now)) as i64;
                missing.max(0) as u64
            }
            None => 0,
        }
    }

    /// The time since the last value.
    pub(super) fn silence(&self, now: Instant) -> Duration {
        Duration::from_ticks(now.ticks().saturating_sub(self.last.ticks()))
    }
}

/// The gaps that a period needs.
const GAPS: usize = 5;

/// The permitted deviation of a gap from the periods in it: the first number is the divisor of the period. The second number is the least
/// deviation in us, because adapters have steps of 1 ms. The third number is the divisor of the period for the largest deviation.
const DEVIATION: (u64, u64, u64) = (10, 1000, 4);

/// The period of values that came at these times; None: they are too few, or not regular.
pub(super) fn period(times: &[Instant]) -> Option<Duration> {
    let gaps = times
        .windows(2)
        .map(|pair| pair[1].ticks().saturating_sub(pair[0].ticks()));
    let mut gaps: Vec<u64> = gaps.collect();
    let whole: u64 = gaps.iter().sum();
    gaps.sort_unstable();
    let middle = *gaps.get(gaps.len() / 2).filter(|gap| **gap > 0)?;
    // A missing value makes a gap of two periods.
    let periods: u64 = gaps.iter().map(|gap| (gap + middle / 2) / middle).sum();
    let period = whole / periods.max(1);
    let (part, time, most) = DEVIATION;
    let permitted = (period / part).max(time).min(period / most);
    let is_regular = gaps.iter().all(|gap| {
        let periods = ((gap + period / 2) / period.max(1)).max(1);
        gap.abs_diff(periods * period) <= permitted
    });
    (gaps.len() >= GAPS && is_regular).then_some(Duration::from_ticks(period))
}

#[cfg(test)]
mod tests;
