//! A word that the program keeps over its restart: the state of the heater, so that a warm sensor stays warm.
//!
//! A reset does not clear the RAM, and the startup code does not initialise the section `.uninit`. The second word is a check: after
//! power-up it is wrong. It is wrong also after a reset by the watchdog or a fault, because [`take`] destroys it.

use core::mem::MaybeUninit;

#[unsafe(link_section = ".uninit.KEPT")]
static mut KEPT: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();

const fn check(word: u32) -> u32 {
    word.rotate_left(7) ^ 0x5AC3_69E1
}

fn place() -> *mut [u32; 2] {
    (&raw mut KEPT).cast()
}

/// Keeps a word. Call it just before the reset.
pub fn put(word: u32) {
    // SAFETY: only the main loop calls this module, and each value is valid for a `u32`. Volatile, because the next program reads it.
    unsafe { place().write_volatile([word, check(word)]) };
}

/// The kept word, once; 0 if there is none.
pub fn take() -> u32 {
    // SAFETY: as in `put`. The RAM has some value after power-up, and a volatile read takes it as it is.
    let [word, checked] = unsafe { place().read_volatile() };
    // SAFETY: as in `put`.
    unsafe { place().write_volatile([0, !check(0)]) };
    if checked == check(word) { word } else { 0 }
}
