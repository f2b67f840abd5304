//! Sleep between interrupts without losing a wake-up.

use crate::clock;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::SCB;
use plumbline::time::Instant;

/// There was an event for the main loop since the last return from [`sleep`].
static EVENT: AtomicBool = AtomicBool::new(false);

/// Wakes the main loop. Called by an interrupt handler.
pub fn wake() {
    EVENT.store(true, Ordering::Relaxed);
}

/// Returns when a handler calls [`wake`], at once if a handler has called it since the last return, and at the latest with the
/// first tick of the clock at or after `until`.
pub fn sleep(until: Instant) {
    clock::set_alarm(until);
    while !EVENT.load(Ordering::Relaxed) {
        // With SCR = 0, WFI stops only the clock of the processor, and ends with an interrupt. A disturbance can have set a bit.
        // SAFETY: this is the only code that writes the register.
        unsafe { (*SCB::PTR).scr.write(0) };
        // With interrupts masked, a pending one still ends WFI, so no interrupt is lost between the check and WFI.
        critical_section::with(|_| {
            if !EVENT.load(Ordering::Relaxed) {
                cortex_m::asm::wfi();
                // With DBG_SLEEP, some STM32 execute wrong instructions that were fetched before the sleep. They are fetched again.
                cortex_m::asm::isb();
            }
        });
    }
    // The handler has run. The next iteration of the main loop handles its data.
    EVENT.store(false, Ordering::Relaxed);
}
