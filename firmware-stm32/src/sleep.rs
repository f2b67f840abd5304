//! Sleep between interrupts without losing a wake-up.

use crate::clock;
use core::sync::atomic::{AtomicBool, Ordering};
use plumbline::time::Instant;

/// Something came for the main loop since it last returned from [`sleep`].
static EVENT: AtomicBool = AtomicBool::new(false);

/// An interrupt handler calls this when the main loop has something to do.
pub fn wake() {
    EVENT.store(true, Ordering::Relaxed);
}

/// Returns when a handler has called [`wake`], or at once if one has since the last call returned; with the first tick of the clock
/// that is not before `until` at the latest.
pub fn sleep(until: Instant) {
    clock::set_alarm(until);
    while !EVENT.load(Ordering::Relaxed) {
        // With interrupts masked a pending one still ends WFI, so none can slip in between the look and the sleep.
        critical_section::with(|_| {
            if !EVENT.load(Ordering::Relaxed) {
                cortex_m::asm::wfi();
            }
        });
    }
    // The handler has run by now; what it left is seen by the caller's next turn.
    EVENT.store(false, Ordering::Relaxed);
}
