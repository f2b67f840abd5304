//! Sleep between interrupts without losing a wake-up.

use core::sync::atomic::{AtomicBool, Ordering};

/// An interrupt came since the main loop last returned from [`sleep`].
static EVENT: AtomicBool = AtomicBool::new(false);

/// Every interrupt handler calls this.
pub fn wake() {
    EVENT.store(true, Ordering::Relaxed);
}

/// Returns after the next interrupt, or at once if one came since the last call returned.
pub fn sleep() {
    // With interrupts masked a pending one still ends WFI, so none can slip in between the look and the sleep.
    critical_section::with(|_| {
        if !EVENT.load(Ordering::Relaxed) {
            cortex_m::asm::wfi();
        }
    });
    // The handler has run by now; what it left is seen by the caller's next turn.
    EVENT.store(false, Ordering::Relaxed);
}
