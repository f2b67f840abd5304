//! The second slot: a download goes there, and is copied when it is complete.
//!
//! Its commit is the mark that it must be copied. When the copy is complete, the header of the download is made invalid. So a power cut in
//! the copy repeats it, and a program that a probe has flashed afterwards stays.

use super::header::{COMMIT, PAGE, PLACE};
use super::slot::{Program, Slot, SlotError};

/// Copies the program in `download`, if it is complete, into the slot `run`. `pause` is called between the operations of the flash, which can
/// take longer than the watchdog permits.
pub fn install<R: Slot>(
    run: &mut R,
    download: &mut impl Slot,
    mut pause: impl FnMut(),
) -> Result<(), SlotError> {
    let Program::Complete(header) = Program::of(download).complete(download)? else {
        return Ok(());
    };
    let body = download.bytes().get(..header.length()).ok_or(SlotError)?;
    // Without its first half-word, the header is never valid again, also if the power is cut during the erase.
    run.program(PLACE, &[0, 0])?;
    for (page, content) in body.chunks(R::PAGE).enumerate() {
        run.erase(page)?;
        pause();
        for (number, piece) in content.chunks(PAGE).enumerate() {
            let place = page * R::PAGE + number * PAGE;
            if place > 0 {
                run.program(place, piece)?;
                pause();
            }
        }
    }
    // The page with the header is the last one.
    let first = body.get(..PAGE).ok_or(SlotError)?;
    let (before, after) = first.split_at_checked(COMMIT).ok_or(SlotError)?;
    run.program(0, before)?;
    run.program(COMMIT + 2, after.get(2..).ok_or(SlotError)?)?;
    let Program::Uncommitted(_) = Program::of(run) else {
        return Err(SlotError);
    };
    run.program(COMMIT, &[0, 0])?;
    download.program(PLACE, &[0, 0])
}

#[cfg(test)]
mod tests;
