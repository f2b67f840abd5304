//! Checks the tags of the FIFO. A tag is the only part of a word that can be checked: the data have neither parity nor checksum.
//!
//! ```text
//!  bit  7 6 5 4 3   2 1       0
//!      +----------+---------+--------+
//!      | sensor   | counter | parity |    the parity of the whole byte is even (ST: fifo_utility.c)
//!      +----------+---------+--------+
//! ```
//!
//! The words of one time have the same counter, and the next ones the next counter, modulo 4.

/// The sensors: gyroscope, accelerometer, thermometer.
const SENSORS: core::ops::RangeInclusive<u8> = 1..=3;

/// The tags so far.
#[derive(Clone, Copy, Debug)]
pub struct Tags {
    /// The counter of the last word, if it is known.
    counter: Option<u8>,
}

impl Tags {
    /// Before the first word.
    pub const INITIAL: Self = Self { counter: None };

    /// The next word can have any counter: words were lost.
    pub fn restart(&mut self) {
        self.counter = None;
    }

    /// Whether the tag of the next word is right. A wrong one is an error of the line, and the counter of the word behind it is not
    /// checked.
    pub fn accept(&mut self, tag: u8) -> bool {
        let counter = tag >> 1 & 0b11;
        let follows = match self.counter {
            Some(last) => counter.wrapping_sub(last) & 0b11 <= 1,
            None => true,
        };
        let is_even = tag.count_ones().is_multiple_of(2);
        let accepted = is_even && follows && SENSORS.contains(&(tag >> 3));
        self.counter = accepted.then_some(counter);
        accepted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tag of an empty FIFO.
    const EMPTY: u8 = 0;

    /// The tag of a sensor with this counter.
    fn tag(sensor: u8, counter: u8) -> u8 {
        let bits = sensor << 3 | (counter & 0b11) << 1;
        bits | (bits.count_ones() & 1) as u8
    }

    #[test]
    fn words_of_one_time_and_of_the_next_are_accepted() {
        let mut tags = Tags::INITIAL;
        for counter in 2..20 {
            for sensor in [2, 1, 3] {
                assert!(tags.accept(tag(sensor, counter)), "{sensor} {counter}");
            }
        }
    }

    #[test]
    fn each_inverted_bit_is_refused() {
        for bit in 0..8 {
            let mut tags = Tags::INITIAL;
            assert!(tags.accept(tag(2, 0)));
            assert!(!tags.accept(tag(2, 1) ^ 1 << bit), "bit {bit}");
            // The counter of the word behind it is not checked.
            assert!(tags.accept(tag(2, 2)), "bit {bit}");
        }
    }

    #[test]
    fn skipped_counter_is_refused_unless_words_were_lost() {
        for (skip, accepted) in [(0, true), (1, true), (2, false), (3, false)] {
            let mut tags = Tags::INITIAL;
            assert!(tags.accept(tag(2, 3)));
            assert_eq!(tags.accept(tag(2, 3 + skip)), accepted, "{skip}");
            let mut tags = Tags::INITIAL;
            assert!(tags.accept(tag(2, 3)));
            tags.restart();
            assert!(tags.accept(tag(2, 3 + skip)), "{skip}");
        }
    }

    #[test]
    fn other_sensors_and_the_empty_fifo_are_refused() {
        for sensor in (0..32).filter(|sensor| !(1..=3).contains(sensor)) {
            let mut tags = Tags::INITIAL;
            assert!(!tags.accept(tag(sensor, 0)), "{sensor:02X}h");
        }
        let mut tags = Tags::INITIAL;
        assert!(!tags.accept(EMPTY));
        let mut tags = Tags::INITIAL;
        assert!(!tags.accept(0xFF));
    }
}
