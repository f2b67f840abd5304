//! The steps of reading a FIFO: a comparison of registers, the number of words, and each word in two transfers. Between two steps the main
//! loop handles frames.

use super::{SpiError, Wires};

/// The next step.
#[derive(Clone, Copy)]
enum Step {
    /// The FIFO is not read.
    None,
    Compare,
    Level,
    /// Exchange the first half of a word: 16 us.
    FirstHalf,
    /// Exchange the second half.
    SecondHalf,
    Evaluate,
}

/// What the driver has to do.
pub enum Task<const LENGTH: usize> {
    /// Nothing.
    None,
    /// Compare registers with their values.
    Compare,
    /// Read the number of words, and pass it to [`Words::expect`].
    Level,
    /// Evaluate a word, which begins with the byte of the address.
    Evaluate([u8; LENGTH]),
}

/// The state of reading a FIFO with words of `LENGTH` bytes, with the byte of the address.
pub struct Words<const LENGTH: usize> {
    step: Step,
    /// The number of words to read, with the present one.
    left: u16,
    /// The byte that reads a word.
    address: u8,
    /// The present word: the bytes to send, replaced by the received ones.
    bytes: [u8; LENGTH],
}

impl<const LENGTH: usize> Words<LENGTH> {
    pub const fn new(address: u8) -> Self {
        Self {
            step: Step::None,
            left: 0,
            address,
            bytes: [0; LENGTH],
        }
    }

    /// Begins to read the FIFO.
    pub fn begin(&mut self) {
        self.step = Step::Compare;
    }

    /// Ends the reading. No transfer is running.
    pub fn stop(&mut self) {
        self.step = Step::None;
    }

    /// True until all words are read.
    pub fn is_busy(&self) -> bool {
        !matches!(self.step, Step::None)
    }

    /// The FIFO has this many words.
    pub fn expect(&mut self, words: u16) {
        self.left = words;
        self.prepare();
    }

    /// Performs a step. After a failure of the SPI, the reading ends.
    pub fn step(&mut self, wires: &mut impl Wires) -> Task<LENGTH> {
        let (first, second) = self.bytes.split_at_mut(LENGTH / 2);
        match self.step {
            Step::None => Task::None,
            Step::Compare => {
                self.step = Step::Level;
                Task::Compare
            }
            Step::Level => {
                self.step = Step::None;
                Task::Level
            }
            Step::FirstHalf => {
                wires.select(true);
                let sent = wires.exchange(first);
                self.step = Step::SecondHalf;
                self.check(wires, sent)
            }
            Step::SecondHalf => {
                let sent = wires.exchange(second);
                wires.select(false);
                self.step = Step::Evaluate;
                self.check(wires, sent)
            }
            Step::Evaluate => {
                let bytes = self.bytes;
                self.left = self.left.saturating_sub(1);
                self.prepare();
                Task::Evaluate(bytes)
            }
        }
    }

    fn check(&mut self, wires: &mut impl Wires, sent: Result<(), SpiError>) -> Task<LENGTH> {
        if sent.is_err() {
            wires.select(false);
            self.step = Step::None;
        }
        Task::None
    }

    /// Prepares the transfer of the next word, if there is one.
    fn prepare(&mut self) {
        self.bytes = [0; LENGTH];
        if let Some(first) = self.bytes.first_mut() {
            *first = self.address;
        }
        self.step = match self.left {
            0 => Step::None,
            _ => Step::FirstHalf,
        };
    }
}
