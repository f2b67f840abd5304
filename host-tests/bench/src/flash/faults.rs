//! The fuse that cuts the power, the content after an incomplete operation, and the faults of the memory.

use super::{Flash, FlashError};

/// When the power is cut.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Fuse {
    /// While a byte is programmed, after this many others.
    Byte(u64),
    /// While a page is erased, after this many others.
    Erase(u64),
    /// While a unit is programmed or a page is erased, after this many of both.
    Operation(u64),
}

impl Flash {
    /// Sets the fuse: the power is cut while a byte is programmed, after `others` more bytes. Some bits of that byte are
    /// programmed, no later byte is, and every operation fails until [`power_on`](Self::power_on).
    pub fn cut_in_byte_after(&mut self, others: u64) {
        self.fuse = Some(Fuse::Byte(others));
    }

    /// Sets the fuse: the power is cut while a page is erased, after `others` more pages. The page is left in one of the states
    /// of an incomplete erase, selected by `seed`.
    pub fn cut_in_erase_after(&mut self, others: u64, seed: u64) {
        self.fuse = Some(Fuse::Erase(others));
        self.stir(seed);
    }

    /// Sets the fuse: the power is cut while a unit is programmed or a page is erased, after `others` more of both. `seed`
    /// selects the content that remains.
    pub fn cut_in_operation_after(&mut self, others: u64, seed: u64) {
        self.fuse = Some(Fuse::Operation(others));
        self.stir(seed);
    }

    /// True when the fuse has blown and the power is off.
    pub fn is_cut(&self) -> bool {
        self.cut
    }

    /// Switches the power on again and removes the fuse.
    pub fn power_on(&mut self) {
        self.cut = false;
        self.fuse = None;
    }

    /// Makes every attempt to program fail without a change.
    pub fn fail_writes(&mut self, fail: bool) {
        self.fail_writes = fail;
    }

    /// Makes every attempt to erase fail without a change.
    pub fn fail_erases(&mut self, fail: bool) {
        self.fail_erases = fail;
    }

    /// Wears out a bit: it can no longer be programmed to 0, and the memory reports no error.
    pub fn wear_out(&mut self, bit: usize) {
        self.worn.push(bit);
    }

    /// Flips one bit.
    ///
    /// # Errors
    /// The file of the memory cannot be written.
    pub fn flip_bit(&mut self, bit: usize) -> Result<(), FlashError> {
        let at = bit / 8;
        self.put(at, &[self.bytes[at] ^ 1 << (bit % 8)])
    }

    /// Flips a bit in the unit that was programmed last, that is, in the newest record. False when nothing has been
    /// programmed yet.
    pub fn corrupt_newest(&mut self) -> bool {
        self.last.is_some_and(|at| self.flip_bit(8 * at).is_ok())
    }

    /// The content of a page after an incomplete erase: its first part erased, or some bytes, or single bits; or the complete
    /// page, or nothing yet.
    pub(super) fn half_erased(&mut self, at: usize) -> Vec<u8> {
        let size = self.geometry.page_size;
        let mut page = self.bytes[at..at + size].to_vec();
        match self.random() % 5 {
            0 => {}
            1 => page.fill(0xFF),
            2 => {
                let length = self.random() as usize % size;
                page[..length].fill(0xFF);
            }
            3 => {
                for byte in &mut page {
                    *byte |= if self.random().is_multiple_of(2) {
                        0xFF
                    } else {
                        0
                    };
                }
            }
            _ => {
                for byte in &mut page {
                    *byte |= self.random() as u8;
                }
            }
        }
        page
    }

    /// Counts an operation; true when the fuse blows in it.
    pub(super) fn operation_blows(&mut self) -> bool {
        self.operations += 1;
        match &mut self.fuse {
            Some(Fuse::Operation(0)) => self.cut = true,
            Some(Fuse::Operation(others)) => *others -= 1,
            _ => {}
        }
        self.cut
    }

    /// Mixes `seed` into the state of the random numbers.
    fn stir(&mut self, seed: u64) {
        self.random ^= seed.wrapping_mul(0xD134_2543_DE82_EF95);
    }

    /// The next number of a xorshift generator: the upper half, whose bits are of better quality.
    pub(super) fn random(&mut self) -> u32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 32) as u32
    }
}
