//! Firmware update over CAN: the program of a sensor is replaced by a bootloader that stays in the flash.
//!
//! - [`about`]: what the ELF file of a program says of it;
//! - [`header`]: the image file, and what a program says of itself;
//! - [`layout`]: the boards with a bootloader;
//! - [`mod@slot`]: the flash of the program, and whether a program can be started;
//! - [`loader`]: takes an image file in pieces, and never starts a mixture;
//! - [`record`]: the identifiers and the bit rate with which the bootloader answers;
//! - [`objects`]: the objects of CiA 302-3;
//! - [`UpdateServer`]: its SDO server.
//!
//! # A download
//!
//! ```text
//!  client                                   bootloader
//!  1F51h:01 = 3 (clear)                     forgets a download that was not completed
//!  1F57h:01 -> 0                            ready
//!  1F50h:01 = file (block or segmented)     first page: is it for this sensor? otherwise abort, and the program stays
//!                                           then the flash is erased and programmed page by page, the first page last
//!  1F57h:01 -> 0, 1F56h:01 -> CRC           the program is complete and correct
//!  1F51h:01 = 1 (start)                     restart into the program
//! ```
//!
//! # A power cut
//!
//! A program is complete when the last half-word of its header is 0000h. It is programmed after all other bytes were compared. Each start
//! also compares the CRC of the whole program. Until then the bootloader remains, and takes the file again. The pages of the bootloader, of
//! the [record] and of the parameters are outside of the slot.

pub mod about;
pub mod header;
pub mod layout;
pub mod loader;
pub mod objects;
pub mod record;
mod server;
#[cfg(test)]
mod simulated;
pub mod slot;

pub use about::About;
pub use header::{Contents, Device, Header, Unfit};
pub use layout::Layout;
pub use loader::{Failure, Loader, Status};
pub use objects::Update;
pub use record::{Record, Sensor};
pub use server::UpdateServer;
pub use slot::{Program, Slot, SlotError};
