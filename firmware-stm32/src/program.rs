//! What a program behind a bootloader knows of it.

use crate::board::LAYOUT;
use crate::imu;
use crate::mailbox;
use plumbline::store::ImageId;
use plumbline::update::header::{Header, PLACE, SIZE, crc};
use plumbline::update::{Contact, Installed, Record};

/// What this program tells of itself; None: a probe has flashed it without its header.
pub fn installed() -> Option<Installed> {
    let header = (LAYOUT.start as usize + PLACE) as *const [u8; SIZE];
    // SAFETY: flash, which is always readable and does not change while this program runs.
    let header = unsafe { header.read_volatile() };
    Header::parse(&header).map(|header| header.installed())
}

/// Asks the bootloader for an update after the reset that follows.
pub fn ask_for_update(product: ImageId, contact: &Contact) {
    mailbox::put(&Record::new(product, imu::NAME, contact, crc));
}
