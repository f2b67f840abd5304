//! Faults of the part, and of the line on which it answers.

use super::{Ism330dhcx, Sibling};
use crate::timebase::{MICROSECOND, Picoseconds};
use bench::motion::Motion;
use plumbline::time::Instant;

/// A fault of the part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// Nothing.
    None,
    /// It does not answer: every byte reads as this value, FFh or 00h. The line can be stuck without a part too.
    Silent(u8),
    /// Its data-ready flags are set, but its values do not change after the first one.
    Frozen,
    /// The acceleration of one axis (0: X, 2: Z) has always this count.
    Stuck(usize, i16),
    /// The angular rate about one axis has always this count.
    StuckRate(usize, i16),
    /// All angular rates are 0.
    ZeroRates,
    /// Its temperature has always the same count.
    StuckTemperature,
    /// Its oscillator has stopped: it answers, but there are no samples.
    Stopped,
    /// Its gyroscope has stopped; the accelerometer and the thermometer work.
    WithoutRate,
}

impl Fault {
    /// The fault at this time: `own`, or that of the motion.
    pub(super) fn at(now: Picoseconds, own: Self, motion: &dyn Motion) -> Self {
        if own != Self::None {
            return own;
        }
        match motion.fault(Instant::from_ticks(now / MICROSECOND)) {
            Some(bench::fault::Fault::Silent) => Self::Silent(super::NOTHING),
            Some(bench::fault::Fault::Frozen) => Self::Frozen,
            Some(bench::fault::Fault::Stopped) => Self::Stopped,
            Some(bench::fault::Fault::Axis(axis)) => Self::Stuck(axis as usize, 0),
            // The readings of the motion have it.
            Some(bench::fault::Fault::Zero | bench::fault::Fault::Clipping) | None => Self::None,
        }
    }
}

impl Ism330dhcx {
    /// Sets its fault from `now` on.
    pub fn set_fault(&mut self, now: Picoseconds, fault: Fault) {
        self.settle(now);
        self.fault = fault;
    }

    /// Inverts a bit in each `period`-th byte that it sends, each time the next bit; 0: no more.
    pub fn set_bit_errors(&mut self, period: u32) {
        self.line.set_errors(period);
    }

    /// Inverts each bit that it sends with this probability, the same bits for the same seed.
    pub fn set_bit_error_rate(&mut self, rate: f64, seed: u64) {
        self.line.set_rate(rate, seed);
    }

    /// Inverts the bits `mask` of this register the next `times` times that the register is read: a disturbance on the line.
    pub fn spoil(&mut self, register: u8, mask: u8, times: u32) {
        self.line.spoil(register, mask, times);
    }

    /// Replaces the next `count` bytes that it sends after `skipped` more ones by this value: the contact of the line is open for a moment.
    pub fn open_line(&mut self, skipped: u32, count: u32, value: u8) {
        self.line.open(skipped, count, value);
    }

    /// Inverts this bit of each `period`-th acceleration along Y in the FIFO: a disturbance on the line; 0: no more.
    pub fn invert_each(&mut self, now: Picoseconds, period: u64, bit: u32) {
        self.settle(now);
        self.sampling.inverts = (period, 1 << bit);
    }

    /// Inverts this bit of the next angular rate in the FIFO, about this axis: a disturbance on the line.
    pub fn invert_rate(&mut self, now: Picoseconds, axis: usize, bit: u32) {
        self.settle(now);
        self.sampling.inverted[axis] ^= 1 << bit;
    }

    /// Inverts the bits `mask` of a control register: a disturbance in the part.
    pub fn upset(&mut self, now: Picoseconds, register: u8, mask: u8) {
        self.settle(now);
        let value = self.registers.get(register) ^ mask;
        self.write(now, register, value);
        // Not an access of the firmware.
        self.unmodelled.clear();
    }

    /// The value of a control register.
    pub fn register(&self, register: u8) -> u8 {
        self.registers.get(register)
    }

    /// Removes the oldest words from its FIFO.
    pub fn lose_words(&mut self, now: Picoseconds, words: usize) {
        self.settle(now);
        self.sampling.fifo.lose(words);
    }

    /// Replaces the part by this one, with the same motion.
    pub fn set_sibling(&mut self, sibling: Sibling) {
        self.sampling.sibling = sibling;
    }
}

/// Bits that change on the line from the part (MISO).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    /// The probability of an inverted bit, and the state of its generator.
    rate: f64,
    random: u64,
    /// In each `period`-th byte a bit is inverted; 0: in none.
    period: u32,
    /// The number of bytes since the last error, and the number of errors.
    bytes: u32,
    errors: u32,
    /// The register of the next bytes with inverted bits, the bits, and their number.
    register: u8,
    mask: u8,
    times: u32,
    /// The number of bytes until the line is open, the number of bytes while it is open, and their value.
    open: (u32, u32, u8),
}

impl Line {
    pub(crate) fn set_rate(&mut self, rate: f64, seed: u64) {
        self.rate = rate;
        // The state of the generator must not be 0.
        self.random = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    }

    /// The next `count` bytes after `skipped` more ones arrive as `value`.
    pub(crate) fn open(&mut self, skipped: u32, count: u32, value: u8) {
        self.open = (skipped, count, value);
    }

    /// True for an inverted bit.
    fn inverts(&mut self) -> bool {
        // xorshift64
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        ((self.random >> 11) as f64) < self.rate * (1_u64 << 53) as f64
    }

    pub(crate) fn set_errors(&mut self, period: u32) {
        self.period = period;
        self.bytes = 0;
    }

    pub(super) fn spoil(&mut self, register: u8, mask: u8, times: u32) {
        self.register = register;
        self.mask = mask;
        self.times = times;
    }

    /// What arrives of a byte from this register.
    pub(crate) fn carry(&mut self, register: u8, byte: u8) -> u8 {
        let (skipped, count, value) = &mut self.open;
        let is_open = *skipped == 0 && *count > 0;
        *count -= u32::from(is_open);
        *skipped = skipped.saturating_sub(1);
        let mut arrived = if is_open { *value } else { byte };
        if self.rate > 0.0 {
            let bits = (0..8).filter(|_| self.inverts());
            arrived ^= bits.map(|bit| 1 << bit).sum::<u8>();
        }
        if self.period > 0 {
            self.bytes += 1;
            if self.bytes == self.period {
                arrived ^= 1 << (self.errors % 8);
                self.errors += 1;
                self.bytes = 0;
            }
        }
        if self.times > 0 && register == self.register {
            self.times -= 1;
            arrived ^= self.mask;
        }
        arrived
    }
}
