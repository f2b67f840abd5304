//! Errors of the line between measuring element and microcontroller.
//!
//! A single error costs a value. A second one soon after it is a sign of a bad line: only a part of the bits is known here, and most errors
//! are in the data.

/// What is known of the line. `MEMORY` is the number of good words after which an error is a single one again.
#[derive(Clone, Copy, Debug)]
pub struct Line<const MEMORY: u16> {
    /// The number of words until the last error does not count any more.
    suspicion: u16,
}

impl<const MEMORY: u16> Line<MEMORY> {
    /// Before the first word.
    pub const INITIAL: Self = Self { suspicion: 0 };

    /// A word was good.
    pub fn good(&mut self) {
        self.suspicion = self.suspicion.saturating_sub(1);
    }

    /// Counts an error. Returns true if it is not the first one within the last `MEMORY` words.
    pub fn repeats(&mut self) -> bool {
        core::mem::replace(&mut self.suspicion, MEMORY) > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_error_within_the_memory_repeats() {
        for (words, repeats) in [(0, true), (832, true), (833, false)] {
            let mut line = Line::<833>::INITIAL;
            assert!(!line.repeats());
            for _ in 0..words {
                line.good();
            }
            assert_eq!(line.repeats(), repeats, "{words}");
        }
    }
}
