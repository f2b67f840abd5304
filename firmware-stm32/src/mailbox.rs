//! The mailbox between the program and its bootloader: 64 bytes at the end of the RAM, which a reset does not clear.
//!
//! ```text
//!  byte 0                8                          40
//!       +----------------+--------------------------+
//!       | PLUMBOOT       | the boot record (32)     |
//!       +----------------+--------------------------+
//! ```

use plumbline::update::Record;
use plumbline::update::record::{Crc, SIZE};

const MARK: [u8; 8] = *b"PLUMBOOT";

#[repr(C)]
struct Mailbox {
    mark: [u8; MARK.len()],
    record: [u8; SIZE],
}

unsafe extern "C" {
    /// The address, from regions.x. Another program has written it, so the compiler knows nothing of its contents.
    #[link_name = "_mailbox"]
    static mut MAILBOX: Mailbox;
}

/// Leaves the record with which the program asks for an update. Call it just before the reset.
#[cfg(feature = "behind-bootloader")]
pub fn put(record: &Record) {
    // SAFETY: the linker script leaves these bytes to this module, and only the main loop calls this function. Volatile, because another
    // program reads it.
    unsafe {
        (&raw mut MAILBOX).write_volatile(Mailbox {
            mark: MARK,
            record: *record.bytes(),
        });
    }
}

/// The record with which the program asks for an update, once. `crc` checks it.
pub fn take(crc: Crc) -> Option<Record> {
    // SAFETY: the linker script leaves these bytes to this module, all values are valid, and there is no interrupt.
    let (mark, record) = unsafe {
        let mark = MAILBOX.mark;
        MAILBOX.mark = [0; _];
        (mark, MAILBOX.record)
    };
    if mark != MARK {
        return None;
    }
    Record::parse(&record, crc)
}
