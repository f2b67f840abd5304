//! Firmware update over CAN: the program of a sensor is replaced by a bootloader that stays in the flash.
//!
//! - [`about`]: what the ELF file of a program says of it;
//! - [`element`]: the measuring element of a program;
//! - [`failure`]: the reasons why a download ends;
//! - [`header`]: the image file, and what a program says of itself;
//! - [`mod@install`]: copies a download from the second slot;
//! - [`installed`]: what a program tells of itself over the bus;
//! - [`layout`]: the boards with a bootloader;
//! - [`lms`]: the signature of an image file;
//! - [`mod@slot`]: the flash of the program, and whether a program can be started;
//! - [`loader`]: takes an image file in pieces, and never starts a mixture;
//! - [`record`]: the identifiers and the bit rate with which the bootloader answers;
//! - [`objects`]: the objects of CiA 302-3;
//! - [`UpdateServer`]: its SDO server.
//!
//! # How a program enters the bootloader
//!
//! A program behind a bootloader ([`Boot::program`](crate::node::Boot::program)) has a request in its protocol that the original does not
//! have. It restarts into the bootloader, which answers SDO requests on two identifiers at the bit rate in force. Without a bootloader, the
//! request gets the error of an unknown one. Parameters, identifiers and bit rate stay as they are.
//!
//! | | protocol | request | its reply | without a bootloader | the CRC-32 of the program, element and board | requests to the bootloader, its replies |
//! |---|---|---|---|---|---|---|
//! | U1 | CANopen | 1F51h:01 = 0 (CiA 302-3) | confirmation | abort 0602 0000h | 1F56h:01, 1F56h:02 | 600h and 580h + node-ID |
//! | U2 | function select codes | code 60h, "FLASH" | 60h, status | 60h, status with CmdParamError | reply to 60h without data: 60h, the error bits of the status, CRC-32 (4 bytes), element and board (2 bytes) | Set-Parameter-ID and Reply-Parameter-ID |
//! | U3 | J1939 | 1F51h:01 = 0 through PGN 61184 | as in CANopen | as in CANopen | as in CANopen | PGN 61184 with priority 6, between the client that has sent the request and the sensor |
//! | U4 | DeviceNet | service 32h of the identity object (1, 1), "BOOT" | B2h | error 08h | response to service 32h without data: CRC-32 (4 bytes), element and board (2 bytes) | messages 4 and 3 of group 2 of the MAC ID |
//!
//! The first message of the bootloader is the boot-up message of the node (U1), or 60h "BOOT" on the identifier of its replies.
//! Element and board are the number of the [`Hardware`], so that a client refuses a file for another one before the program stops. CiA 302-3 has
//! bits of the manufacturer in 1F57h:01, but clients wait until all of its bits are 0. A program that
//! does not tell its hardware is accepted: the bootloader checks the file too.
//! None of the requests is in an EDS file or a table of a product.
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
//! # A signature
//!
//! A bootloader with a [key](Slot::key) takes only files with its [signature](lms) of the header. The header has the SHA-256 of the body, which
//! is compared before the commit, also by the start after a power cut. A key in the boot record could be lost in the erase of its page, so
//! its place is the [write-protected flash of the bootloader](Layout::key). Who has a probe can always replace it.
//!
//! An older program with a signature is taken with the permission of the client: there is no lowest permitted version. It would need a place that a
//! power cut cannot erase, and the bootloader with signatures has no room for it.
//!
//! # A power cut
//!
//! A program is complete when the last half-word of its header is 0000h. It is programmed after all other bytes were compared. Each start
//! also compares the CRC of the whole program. Until then the bootloader remains, and takes the file again. The pages of the bootloader, of
//! the [record] and of the parameters are outside of the slot.
//!
//! A board with [two slots](Layout::download) takes the file into the second one, and the present program stays. The restart of the client, or
//! the next start, [copies](mod@install) it. A power cut before the commit leaves the old program, a later one the new program.

pub mod about;
pub mod element;
pub mod failure;
pub mod header;
pub mod install;
pub mod installed;
pub mod layout;
pub mod lms;
pub mod loader;
pub mod objects;
pub mod record;
mod server;
#[cfg(test)]
mod simulated;
pub mod slot;

pub use about::About;
pub use element::Element;
pub use failure::{Failure, Status};
pub use header::{Contents, Device, Header};
pub use install::install;
pub use installed::{Hardware, Installed};
pub use layout::Layout;
pub use lms::PublicKey;
pub use loader::Loader;
pub use objects::Update;
pub use record::{Contact, Record};
pub use server::UpdateServer;
pub use slot::{Program, Slot, SlotError};
