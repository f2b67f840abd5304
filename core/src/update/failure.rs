//! The reasons why a download ends.

use super::slot::SlotError;
use crate::canopen::Abort;

/// The state of the program, with its number in object 1F57h (CiA 302-3).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Status {
    /// No error.
    Good = 0,
    /// There is no valid program.
    NoProgram = 1 << 1,
    /// The format of the file is unknown, or it is for another device.
    Format = 2 << 1,
    /// The data are damaged.
    Data = 3 << 1,
    /// The program must be cleared before a download.
    NotCleared = 4 << 1,
    /// The flash could not be erased or programmed.
    Write = 5 << 1,
    /// The version is lower than that of the present program, or the signature is wrong.
    Secured = 7 << 1,
}

/// The reason why a download ends. Up to [`Unsigned`](Self::Unsigned), the flash is as it was before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Failure {
    /// The file does not begin with a header of this format.
    Format,
    /// The first page has another CRC.
    Damaged,
    /// The image is for another product.
    Product,
    /// The image is for another board, or for another layout of its memory.
    Board,
    /// The body does not fit into the slot, ends in the first page, or is not a whole number of words.
    Size,
    /// The version is lower than that of the present program.
    Older,
    /// The image has no signature of the key of the sensor.
    Unsigned,
    /// A download was not begun with a clear command.
    NotCleared,
    /// The file is longer or shorter than its header says.
    Length,
    /// The program has another CRC or another SHA-256 than its header says.
    Data,
    /// The flash failed.
    Slot,
}

impl From<SlotError> for Failure {
    fn from(SlotError: SlotError) -> Self {
        Self::Slot
    }
}

impl Failure {
    /// The status after it.
    pub const fn status(self) -> Status {
        match self {
            Self::Format | Self::Product | Self::Board | Self::Size => Status::Format,
            Self::Older | Self::Unsigned => Status::Secured,
            Self::Damaged | Self::Data | Self::Length => Status::Data,
            Self::NotCleared => Status::NotCleared,
            Self::Slot => Status::Write,
        }
    }
}

impl From<Failure> for Abort {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Format | Failure::Product | Failure::Board | Failure::Size => Self::Value,
            Failure::Older | Failure::NotCleared => Self::DeviceState,
            Failure::Unsigned => Self::LocalControl,
            Failure::Damaged | Failure::Data => Self::Signature,
            Failure::Length => Self::Length,
            Failure::Slot => Self::Hardware,
        }
    }
}
