//! Judges the values of an accelerometer: corrects a wrong bit, and detects an axis that does not change.
//!
//! The data of an element have neither parity nor checksum, and a FIFO gives each value only once. A wrong bit on the line moves one axis of
//! one value by a power of two, and the values before and behind it are right. A value that is far from the one before is held until two
//! more have come. Then it is compared with the curve through the two values before and the two behind it: a polynomial of third degree,
//! which meets vibration up to some 100 Hz. It is corrected if exactly one axis is beside the curve and a power of two takes it back there.
//!
//! What is beside the curve depends on the last 20 ms: at rest more than `FLOOR`, under vibration more than twice the largest distance. The
//! tolerance of the power of two is at most `FLOOR`. So a shock or a vibration is seldom corrected, and its mean stays right.
//!
//! The loops call functions that are not inlined, because the image of the IMS360 is nearly as large as the flash.

use super::repeats::Repeats;

/// The values of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The last two released values, and those that are not released, the oldest first.
    window: [i32; 5],
    repeats: Repeats,
    /// What the first value that is held has too much.
    wrong: i32,
}

impl Axis {
    const INITIAL: Self = Self {
        window: [0; 5],
        repeats: Repeats::INITIAL,
        wrong: 0,
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

    /// Compares the first value that is held with the curve, and returns its distance. `wrong` becomes the power of two that takes it back
    /// there; 0 if there is none, or if the value is not beyond both neighbours.
    #[inline(never)]
    fn judge(&mut self, tolerance: i32) -> i32 {
        let [earliest, earlier, value, later, latest] = self.window;
        let distance = value - (4 * (earlier + later) - earliest - latest) / 6;
        let length = distance.abs();
        let power = 1 << (length + tolerance).checked_ilog2().unwrap_or(0);
        let is_power = (length - power).abs() <= tolerance;
        let is_beyond = (value - earlier) ^ distance >= 0 && (value - later) ^ distance >= 0;
        self.wrong = if is_power && is_beyond {
            power * distance.signum()
        } else {
            0
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

/// The values of three axes, within +-2^28. `FLOOR` is a step that the noise does not exceed.
#[derive(Clone, Debug)]
pub struct Values<const FLOOR: i32> {
    axes: [Axis; 3],
    /// The number of values that are not released.
    held: usize,
    /// The largest distance from the curve. It decreases by a sixteenth with each value.
    distance: i32,
}

impl<const FLOOR: i32> Values<FLOOR> {
    /// Before the first value.
    pub const INITIAL: Self = Self {
        axes: [Axis::INITIAL; 3],
        held: 0,
        distance: 0,
    };

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

    /// The next value, without its wrong bit.
    #[inline(never)]
    pub fn release(&mut self) -> Option<[i32; 3]> {
        if self.held == 0 {
            return None;
        }
        let mut corrects = false;
        if self.axes.iter().any(|axis| axis.is_far(FLOOR)) {
            if self.held < 3 {
                return None;
            }
            corrects = self.judge();
        }
        self.held -= 1;
        self.distance -= self.distance >> 4;
        let mut released = [0; 3];
        for (axis, value) in self.axes.iter_mut().zip(&mut released) {
            *value = axis.release(corrects);
        }
        Some(released)
    }

    /// True if exactly one axis of the first value that is held is beside the curve: its wrong bit is to be corrected.
    fn judge(&mut self) -> bool {
        let limit = FLOOR.max(self.distance * 2);
        let tolerance = self.distance.clamp(FLOOR / 2, FLOOR);
        let mut far = 0;
        for axis in &mut self.axes {
            let distance = axis.judge(tolerance).abs();
            self.distance = self.distance.max(distance);
            if distance > limit {
                far += 1;
            } else {
                axis.wrong = 0;
            }
        }
        // Beside a wrong value, the curve is wrong too: the distance may only double with each value.
        self.distance = self.distance.min(limit);
        far == 1
    }
}

#[cfg(test)]
mod tests;
