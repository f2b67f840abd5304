//! The contents of the nonvolatile memory, and the actions at the end of a running save.

use super::product::{ParametersOf, Product};

/// The signature "save" (1010h) as a little-endian number.
pub(super) const SAVE: u32 = u32::from_le_bytes(*b"save");
/// The signature "load" (1011h) as a little-endian number.
pub(super) const LOAD: u32 = u32::from_le_bytes(*b"load");

/// The changes in RAM at the end of a save.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum End {
    /// The parameters in RAM stay.
    Nothing,
    /// If the save has failed, restores the previous values of the parameters that are stored on write.
    AtOnce,
    /// Calls the own object at this place of the product.
    Own(u8),
}

/// The contents of the nonvolatile memory.
pub(super) struct Saved<P: Product> {
    pub parameters: ParametersOf<P>,
    /// The end of the running save, or of the last one.
    pub end: End,
    /// The parameters in RAM are those of a start: the following reset of the communication does not restore them again.
    begun: bool,
    /// The reset in progress acts as power-up.
    cold: bool,
}

impl<P: Product> Saved<P> {
    /// Whether the end of the running save overwrites parameters that were written during it.
    pub fn overwrites(&self) -> bool {
        matches!(self.end, End::Own(_))
    }

    /// The state before the memory is read.
    pub const INITIAL: Self = Self {
        parameters: ParametersOf::<P>::INITIAL,
        end: End::Nothing,
        begun: false,
        cold: false,
    };

    /// The next reset of the node acts as power-up.
    pub fn restart(&mut self) {
        self.cold = true;
    }

    /// Returns true once if the reset of the node acts as power-up.
    pub fn restarts(&mut self) -> bool {
        core::mem::take(&mut self.cold)
    }

    /// The parameters in RAM are those of a start.
    pub fn begin(&mut self) {
        self.begun = true;
    }

    /// Returns true once after a start.
    pub fn has_begun(&mut self) -> bool {
        core::mem::take(&mut self.begun)
    }
}
