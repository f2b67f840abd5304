//! Detects an axis that does not change.
//!
//! The noise of each element is wider than a digit, so equal values in a row are a sign of a defect: with a noise of one digit, a quarter of
//! the typical one of the ISM330DHCX, 32 of them have a probability of 10^-17.

/// The number of equal values in a row that a working axis does not have: 32 to 38 ms.
const EQUAL: u32 = 32;

/// The newest value of an axis as it was received, and the number of values in a row that are equal to it.
#[derive(Clone, Copy, Debug)]
pub struct Repeats {
    newest: i32,
    equal: u32,
}

impl Repeats {
    /// Before the first value.
    pub const INITIAL: Self = Self {
        newest: 0,
        equal: 0,
    };

    /// Whether there was no value yet.
    pub fn is_initial(&self) -> bool {
        self.equal == 0
    }

    /// Takes the next value. True if the axis does not change.
    pub fn push(&mut self, value: i32) -> bool {
        self.equal = if value == self.newest { self.equal } else { 0 } + 1;
        self.newest = value;
        self.equal >= EQUAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of the value at which the axis does not change.
    fn stuck(value: fn(i32) -> i32) -> Option<i32> {
        let mut repeats = Repeats::INITIAL;
        (1..100).find(|number| repeats.push(value(*number)))
    }

    #[test]
    fn axis_with_32_equal_values_does_not_change() {
        for value in [|_| 5, |_| 0, |_| i32::from(i16::MIN)] {
            assert_eq!(stuck(value), Some(32));
        }
        assert_eq!(stuck(|number| number / 31), None);
    }
}
