//! A recursive filter and a moving average in series, on angles (POSITAL TILTIX manual 5.1).
//!
//! The manual defines both in program cycles of 0.7 ms, and a [`Reading`](super::Reading) comes every [`SAMPLE_PERIOD`]. Each reading
//! counts as the input of the [7 or 8 cycles](CYCLE_RATE) since the one before, and both filters are calculated for this number of
//! cycles at once. So the time constants are those of the manual, and the output is the one of the last of these cycles.
//!
//! - The recursive filter, with the weight w: a cycle calculates y = w y + (1 - w) x, so c cycles with the same input give
//!   y = x + w^c (y - x). The state has 32 fractional bits.
//! - The moving average is the mean of the outputs y of the last N cycles. An entry of its array is the mean of y over the cycles of a
//!   reading, with the number of these cycles. An entry that is partly older than N cycles counts with the rest of its cycles.
//!
//! All differences of angles wrap, so the step from 359.9 to 0.1 deg is a step of 0.2 deg. The sum of the moving average contains the
//! differences from the newest entry. Each number that is added to it is subtracted later, so at rest it is exactly 0.
//!
//! ```
//! use plumbline::angle::Angle;
//! use plumbline::measure::output_filter::OutputFilter;
//!
//! let mut filter = OutputFilter::<1>::INITIAL;
//! filter.tune(0, 100);
//! for _ in 0..15 {
//!     filter.step([Angle::from_centidegrees(359_90)]);
//! }
//! // 100 cycles are 70 ms or 14 readings.
//! let outputs = [0; 15].map(|_| filter.step([Angle::from_centidegrees(10)]));
//! assert_eq!(outputs[6][0].centidegrees(), 0);
//! assert_eq!(outputs[14][0].centidegrees(), 10);
//! ```

use super::SAMPLE_PERIOD;
use crate::angle::Angle;

/// The number of program cycles of the original sensor in a second. Its filter runs once in each of them.
pub const CYCLE_RATE: u32 = 1428;

/// The largest size of the moving average, in program cycles.
pub const SIZE_MAX: u8 = 250;

/// The weight that makes the recursive filter hold its output.
pub const WEIGHT_MAX: u16 = 1000;

/// The number of readings in a second.
const SAMPLE_RATE: u32 = (1_000_000 / SAMPLE_PERIOD.ticks()) as u32;

/// The whole number of cycles in [`SAMPLE_PERIOD`].
const CYCLES: u32 = CYCLE_RATE / SAMPLE_RATE;

/// The number of entries: the largest array, a partial entry at each end, and the next entry.
const ENTRIES: usize = (SIZE_MAX as u32 / CYCLES) as usize + 3;

/// The response of the recursive filter to a number of cycles, as fractions of 2^32. `u32::MAX` is all: only [`WEIGHT_MAX`] has it.
#[derive(Clone, Copy, Debug)]
struct Response {
    /// The part of the difference between state and input that remains after the cycles.
    last: u32,
    /// The mean of this part over the cycles.
    mean: u32,
}

/// An entry of the array of the moving average.
#[derive(Clone, Copy, Debug)]
struct Entry<const AXES: usize> {
    angles: [Angle; AXES],
    cycles: u32,
}

/// The state of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The output of the recursive filter; 360 deg is 2^64.
    state: u64,
    /// The angle of the newest entry.
    newest: Angle,
    /// The sum over the cycles of the array of the differences from the newest entry.
    sum: i64,
    /// The oldest entry minus the newest one.
    oldest: i64,
}

/// Both filters for a number of axes.
#[derive(Clone, Debug)]
pub struct OutputFilter<const AXES: usize> {
    axes: [Axis; AXES],
    entries: [Entry<AXES>; ENTRIES],
    /// The place of the oldest entry.
    first: usize,
    /// The number of entries in use.
    count: usize,
    /// The number of cycles of the oldest entry that count.
    rest: u32,
    /// The number of cycles in the array.
    filled: u32,
    /// The size of the moving average; 0: off.
    size: u32,
    /// The responses to [`CYCLES`] and one more cycle; None: the recursive filter is off.
    responses: Option<[Response; 2]>,
    /// The part of a cycle that is left from the last reading, in units of 1 / [`SAMPLE_RATE`].
    phase: u32,
    /// There was a reading, so the filters have a state.
    started: bool,
}

impl<const AXES: usize> OutputFilter<AXES> {
    /// Both filters off, without readings.
    pub const INITIAL: Self = Self {
        axes: [Axis {
            state: 0,
            newest: Angle::ZERO,
            sum: 0,
            oldest: 0,
        }; AXES],
        entries: [Entry {
            angles: [Angle::ZERO; AXES],
            cycles: 0,
        }; ENTRIES],
        first: 0,
        count: 0,
        rest: 0,
        filled: 0,
        size: 0,
        responses: None,
        phase: 0,
        started: false,
    };

    /// Sets the weight of the recursive filter in 1/1000 and the size of the moving average in cycles; 0 switches a filter off.
    /// Limits the weight to [`WEIGHT_MAX`] and the size to [`SIZE_MAX`]. Keeps the state: a larger array fills with new entries.
    pub fn tune(&mut self, weight: u16, size: u8) {
        self.responses = Response::of(weight);
        self.size = size.min(SIZE_MAX).into();
    }

    /// Handles a gap before the next reading: the next reading is the state of both filters, as the first one. A recursive filter that
    /// holds its output holds it further.
    pub fn restart(&mut self) {
        let holds = |[usual, _]: [Response; 2]| usual.last == u32::MAX;
        self.started &= self.responses.is_some_and(holds);
        (self.count, self.filled) = (0, 0);
    }

    /// Processes the angles of a reading. The first reading is the state of both filters.
    pub fn step(&mut self, angles: [Angle; AXES]) -> [Angle; AXES] {
        let extra = self.advance();
        if !self.started {
            self.started = true;
            for (axis, angle) in self.axes.iter_mut().zip(angles) {
                axis.state = u64::from(angle.0) << 32;
            }
        }
        let response = self.responses.map(|[usual, longer]| match extra {
            0 => usual,
            _ => longer,
        });
        let (mut outputs, mut entry) = (angles, angles);
        if let Some(response) = response {
            for ((axis, output), mean) in self.axes.iter_mut().zip(&mut outputs).zip(&mut entry) {
                (*output, *mean) = axis.recurse(*output, response);
            }
        } else {
            for (axis, angle) in self.axes.iter_mut().zip(angles) {
                axis.state = u64::from(angle.0) << 32;
            }
        }
        if self.size == 0 {
            (self.count, self.filled) = (0, 0);
            return outputs;
        }
        self.push(entry, CYCLES.wrapping_add(extra));
        while self.filled > self.size && self.drop_oldest() {}
        // The reciprocal of the number of cycles, as a fraction of 2^32.
        let scale = u32::MAX.checked_div(self.filled).unwrap_or(0);
        for (axis, output) in self.axes.iter().zip(&mut outputs) {
            *output = axis.newest + scaled(axis.sum, scale);
        }
        outputs
    }

    /// Adds the time of a reading. Returns the number of its cycles minus [`CYCLES`]: 0 or 1.
    fn advance(&mut self) -> u32 {
        self.phase = self.phase.wrapping_add(CYCLE_RATE % SAMPLE_RATE);
        if self.phase < SAMPLE_RATE {
            return 0;
        }
        self.phase = self.phase.wrapping_sub(SAMPLE_RATE);
        1
    }

    /// Adds an entry for a number of cycles.
    fn push(&mut self, angles: [Angle; AXES], cycles: u32) {
        if self.count == 0 {
            self.rest = cycles;
            for (axis, angle) in self.axes.iter_mut().zip(angles) {
                (axis.newest, axis.sum, axis.oldest) = (angle, 0, 0);
            }
        }
        for (axis, angle) in self.axes.iter_mut().zip(angles) {
            let change = i64::from((angle - axis.newest).0 as i32);
            let all = change.wrapping_mul(self.filled.into());
            axis.sum = axis.sum.wrapping_sub(all);
            axis.oldest = axis.oldest.wrapping_sub(change);
            axis.newest = angle;
        }
        let place = after(self.first, self.count);
        if let Some(entry) = self.entries.get_mut(place) {
            *entry = Entry { angles, cycles };
        }
        self.count = self.count.wrapping_add(1);
        self.filled = self.filled.wrapping_add(cycles);
    }

    /// Removes cycles of the oldest entry, at most so many that the array has its size. Returns false if there is no entry.
    fn drop_oldest(&mut self) -> bool {
        let excess = self.filled.saturating_sub(self.size).min(self.rest);
        for axis in &mut self.axes {
            let all = axis.oldest.wrapping_mul(excess.into());
            axis.sum = axis.sum.wrapping_sub(all);
        }
        self.filled = self.filled.wrapping_sub(excess);
        self.rest = self.rest.wrapping_sub(excess);
        if self.rest > 0 {
            return true;
        }
        let next = after(self.first, 1);
        let (Some(old), Some(new)) = (self.entries.get(self.first), self.entries.get(next)) else {
            return false;
        };
        for ((axis, old), new) in self.axes.iter_mut().zip(old.angles).zip(new.angles) {
            let change = i64::from((new - old).0 as i32);
            axis.oldest = axis.oldest.wrapping_add(change);
        }
        self.rest = new.cycles;
        self.first = next;
        self.count = self.count.saturating_sub(1);
        self.count > 0
    }
}

impl<const AXES: usize> Default for OutputFilter<AXES> {
    fn default() -> Self {
        Self::INITIAL
    }
}

impl Axis {
    /// The cycles of a reading of the recursive filter. Returns the last output and the mean of the outputs.
    fn recurse(&mut self, input: Angle, response: Response) -> (Angle, Angle) {
        let input = u64::from(input.0) << 32;
        let difference = self.state.wrapping_sub(input) as i64;
        let remaining = |part: u32| {
            let (high, low) = (difference >> 32, difference as u32);
            let high = high.wrapping_mul(part.into());
            let low = (u64::from(low) * u64::from(part)) >> 32;
            input.wrapping_add(high as u64).wrapping_add(low)
        };
        self.state = match response.last {
            u32::MAX => self.state,
            part => remaining(part),
        };
        let mean = match response.mean {
            u32::MAX => self.state,
            part => remaining(part),
        };
        (rounded(self.state), rounded(mean))
    }
}

impl Response {
    /// The responses to a weight in 1/1000; None: off.
    fn of(weight: u16) -> Option<[Self; 2]> {
        if weight == 0 {
            return None;
        }
        if weight >= WEIGHT_MAX {
            let hold = Self {
                last: u32::MAX,
                mean: u32::MAX,
            };
            return Some([hold; 2]);
        }
        // 2^32 / 1000 is 4294967 + 37 / 125.
        let weight = u32::from(weight);
        let weight = weight
            .wrapping_mul(4_294_967)
            .wrapping_add(weight * 37 / 125);
        let [mut usual, mut longer] = [Self { last: 0, mean: 0 }; 2];
        let (mut power, mut sum) = (u32::MAX, 0_u64);
        for cycles in 1..=CYCLES + 1 {
            // The state before the first cycle has the exact weight 1.
            power = match cycles {
                1 => weight,
                _ => ((u64::from(power) * u64::from(weight)) >> 32) as u32,
            };
            sum = sum.wrapping_add(power.into());
            (usual, longer) = (
                longer,
                Self {
                    last: power,
                    mean: mean(sum, cycles),
                },
            );
        }
        Some([usual, longer])
    }
}

/// `sum` / `count`, without a division of 64 bits: at most 8 terms below 2^32.
fn mean(sum: u64, count: u32) -> u32 {
    let (sum, count) = ((sum >> 4) as u32, count.max(1));
    (sum / count)
        .wrapping_mul(16)
        .wrapping_add(sum % count * 16 / count)
}

/// `sum` multiplied by a fraction of 2^32, as an angle.
fn scaled(sum: i64, scale: u32) -> Angle {
    let high = (sum >> 32) as u32;
    let low = (u64::from(sum as u32) * u64::from(scale)) >> 32;
    Angle(high.wrapping_mul(scale).wrapping_add(low as u32))
}

/// The state of the recursive filter, rounded to the nearest angle.
fn rounded(state: u64) -> Angle {
    Angle((state.wrapping_add(1 << 31) >> 32) as u32)
}

/// The place of an entry after another one.
fn after(place: usize, distance: usize) -> usize {
    let place = place.wrapping_add(distance);
    if place < ENTRIES {
        place
    } else {
        place.wrapping_sub(ENTRIES)
    }
}

#[cfg(test)]
mod tests;
