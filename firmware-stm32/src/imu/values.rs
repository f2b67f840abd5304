//! Judges the values of an accelerometer: corrects a wrong bit, and detects an axis that does not change.
//!
//! The data of an element have neither parity nor checksum, and a FIFO gives each value only once. A wrong bit on the line moves one axis of
//! one value by a power of two, and the values before and behind it are right. A value that is far from the one before is held until two
//! more have come. Then it is compared with the curve through the two values before and the two behind it: a polynomial of third degree,
//! which meets vibration up to some 100 Hz. It is corrected if a power of two takes each axis back there that is beside the curve.
//!
//! A line whose contact is open for some bytes reads as FFh or 00h. If the tag was not among them, an axis with such bytes is put on the curve.
//!
//! What is beside the curve depends on the last 20 ms: at rest more than `FLOOR`, under vibration more than twice the largest distance. The
//! tolerance of the power of two is at most `FLOOR`. So a shock or a vibration is seldom corrected, and its mean stays right.
//!
//! With more than 16 corrections in a second, the values are not to be used ([`Values::are_wrong`]). A wrong bit in each second value looks like a
//! vibration at half the data rate. It is told by its constant height, a power of two. Wrong bits in each third to tenth value look like a
//! vibration, and are neither corrected nor told.
//!
//! The loops call functions that are not inlined, because the image of the IMS360 is nearly as large as the flash.

use super::repeats::Repeats;

/// A corrected value counts as this many right ones. With a sum of `LIMIT` the line is bad: with one in each 12 values after 0.3 s, in each 20
/// after 0.6 s. Ten shocks in a second can look like wrong bits.
const EACH: i32 = 52;
const LIMIT: i32 = 16 * EACH;

/// A swing of less than this many times the floor, 0.1 g, is a vibration.
const SMALL: i32 = 6;

/// The number of values in a row, above and below the others by the same power of two, that are wrong: 0.13 to 0.15 s.
const SWINGS: u8 = 128;

/// The values of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The last two released values, and those that are not released, the oldest first.
    window: [i32; 5],
    repeats: Repeats,
    /// What the first value that is held has too much.
    wrong: i32,
    /// Twice the distance of the last compared value from the middle between its neighbours, and the number of values in a row in which it
    /// was the same power of two in turn above and below.
    swing: i32,
    swings: u8,
}

impl Axis {
    const INITIAL: Self = Self {
        window: [0; 5],
        repeats: Repeats::INITIAL,
        wrong: 0,
        swing: 0,
        swings: 0,
    };

    /// Puts a value at this place of the window; into the whole window if there was no value before. True if the axis does not change.
    #[inline(never)]
    fn push(&mut self, place: usize, value: i32) -> bool {
        if self.repeats.is_initial() {
            self.window = [value; 5];
        }
        if let Some(place) = self.window.get_mut(place) {
            *place = value;
        }
        self.repeats.push(value)
    }

    /// True if the first value that is held is far from the one before.
    #[inline(never)]
    fn is_far(&self, floor: i32) -> bool {
        let [_, last, value, ..] = self.window;
        (value - last).abs() > floor
    }

    /// Compares the first value that is held, of `width` bits, with the curve, and returns its distance. `wrong` becomes the power of two that
    /// takes it back there, or the distance if the line was open; 0 if neither, or if the value is not beyond both neighbours.
    #[inline(never)]
    fn judge(&mut self, tolerance: i32, floor: i32, width: u32) -> i32 {
        let [earliest, earlier, value, later, latest] = self.window;
        let curve = (4 * (earlier + later) - earliest - latest) / 6;
        let distance = value - curve;
        let power = nearest_power(distance, tolerance);
        let swing = 2 * value - earlier - later;
        let is_steady = swing.abs() > 2 * SMALL * floor
            && (swing + self.swing).abs() <= floor
            && nearest_power(swing, floor) != 0;
        self.swings = if is_steady {
            self.swings.saturating_add(1)
        } else {
            0
        };
        self.swing = swing;
        let is_beyond = (value - earlier) ^ distance >= 0 && (value - later) ^ distance >= 0;
        // Not in a shock, which can have such values too.
        let is_calm = (curve - earliest).abs() <= floor && (curve - latest).abs() <= floor;
        self.wrong = if !is_beyond {
            0
        } else if power == 0 && is_calm && is_open(value, curve, width, tolerance) {
            distance
        } else {
            power * distance.signum()
        };
        distance
    }

    /// Releases the first value that is held, less what is wrong if `corrects`.
    #[inline(never)]
    fn release(&mut self, corrects: bool) -> i32 {
        let [_, last, value, later, latest] = self.window;
        let value = if corrects { value - self.wrong } else { value };
        self.window = [last, value, later, latest, latest];
        value
    }
}

/// The power of two within `tolerance` of the length of this distance; 0 if there is none.
#[inline(never)]
fn nearest_power(distance: i32, tolerance: i32) -> i32 {
    let length = distance.abs();
    let power = 1 << (length + tolerance).checked_ilog2().unwrap_or(0);
    if (length - power).abs() <= tolerance {
        power
    } else {
        0
    }
}

/// Whether `value` is `right` with one or more bytes in a row that are all FFh or all 00h. The bytes are those of a number of `width` bits.
#[inline(never)]
fn is_open(value: i32, right: i32, width: u32, tolerance: i32) -> bool {
    let mut end = width;
    while end >= 8 {
        let mut begin = end;
        while begin >= 8 {
            begin -= 8;
            let bytes = (1 << end) - (1 << begin);
            for level in [0, bytes] {
                let unused = 32 - width;
                let received = (right & !bytes | level) << unused >> unused;
                if value & bytes == level && (value - received).abs() <= tolerance {
                    return true;
                }
            }
        }
        end -= 8;
    }
    false
}

/// The values of three axes, signed numbers of `WIDTH` bits, at most 28. `FLOOR` is a step that the noise does not exceed.
#[derive(Clone, Debug)]
pub struct Values<const FLOOR: i32, const WIDTH: u32> {
    axes: [Axis; 3],
    /// The number of values that are not released.
    held: usize,
    /// The largest distance from the curve. It decreases by a sixteenth with each value.
    distance: i32,
    /// [`EACH`] for each corrected value, less 1 for each value since.
    wrong: i32,
}

impl<const FLOOR: i32, const WIDTH: u32> Values<FLOOR, WIDTH> {
    /// Before the first value.
    pub const INITIAL: Self = Self {
        axes: [Axis::INITIAL; 3],
        held: 0,
        distance: 0,
        wrong: 0,
    };

    /// Values were lost: those that are held are not used. The number of errors stays.
    pub fn restart(&mut self) {
        *self = Self {
            wrong: self.wrong,
            ..Self::INITIAL
        };
    }

    /// Takes the next value. Returns true if an axis does not change. Then call [`release`](Self::release): a value that is not released at
    /// once can be released after the next push.
    #[inline(never)]
    pub fn push(&mut self, value: [i32; 3]) -> bool {
        let place = self.held + 2;
        self.held += 1;
        let mut is_stuck = false;
        for (axis, value) in self.axes.iter_mut().zip(value) {
            is_stuck |= axis.push(place, value);
        }
        is_stuck
    }

    /// Whether the values have too many errors. If they are `doubted`, two of them within 50 values are too many.
    pub fn are_wrong(&self, doubted: bool) -> bool {
        let limit = if doubted { EACH } else { LIMIT };
        self.wrong > limit || self.axes.iter().any(|axis| axis.swings >= SWINGS)
    }

    /// The next value, without its wrong bit.
    #[inline(never)]
    pub fn release(&mut self) -> Option<[i32; 3]> {
        if self.held == 0 {
            return None;
        }
        let mut corrects = false;
        let is_far = self.axes.iter().any(|axis| axis.is_far(FLOOR));
        if is_far {
            if self.held < 3 {
                return None;
            }
            corrects = self.judge();
        }
        self.held -= 1;
        self.distance -= self.distance >> 4;
        self.wrong -= self.wrong.min(1);
        let mut released = [0; 3];
        for (axis, value) in self.axes.iter_mut().zip(&mut released) {
            if !is_far {
                axis.swings = 0;
            }
            *value = axis.release(corrects);
        }
        Some(released)
    }

    /// True if the first value that is held is to be corrected: each axis that is beside the curve can be taken back.
    fn judge(&mut self) -> bool {
        let limit = FLOOR.max(self.distance * 2);
        let tolerance = self.distance.clamp(FLOOR / 2, FLOOR);
        let (mut corrects, mut is_signal) = (false, false);
        for axis in &mut self.axes {
            let distance = axis.judge(tolerance, FLOOR, WIDTH);
            self.distance = self.distance.max(distance.abs());
            if distance.abs() <= limit {
                axis.wrong = 0;
            }
            corrects |= axis.wrong != 0;
            is_signal |= distance.abs() > limit && axis.wrong == 0;
        }
        // Beside a wrong value, the curve is wrong too: the distance may only double with each value.
        self.distance = self.distance.min(limit);
        let corrects = corrects && !is_signal;
        if corrects {
            self.wrong += EACH;
        }
        corrects
    }
}

#[cfg(test)]
mod tests;
