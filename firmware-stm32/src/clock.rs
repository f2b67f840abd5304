//! The time since power-up in microseconds, from SysTick: it interrupts every millisecond, and its counter gives the rest.
//!
//! The clock loses time only while the flash is erased, which stalls the processor: at boot, and in the rare save that has no
//! erased place left. It never runs backwards.

use crate::{board, sleep};
use core::cell::Cell;
use cortex_m::peripheral::{SCB, SYST, syst::SystClkSource};
use critical_section::Mutex;
use plumbline::time::Instant;

const TICKS_PER_US: u32 = board::CORE_CLOCK / 1_000_000;
const TICKS_PER_MS: u32 = 1000 * TICKS_PER_US;

/// Whole milliseconds: interrupts counted.
static MILLIS: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Starts the clock; the core must already run at its full speed.
pub fn start(mut systick: SYST) {
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(TICKS_PER_MS - 1);
    systick.clear_current();
    systick.enable_interrupt();
    systick.enable_counter();
}

/// The time now.
pub fn now() -> Instant {
    critical_section::with(|cs| {
        let mut millis = MILLIS.borrow(cs).get();
        let mut counter = SYST::get_current();
        if SCB::is_pendst_pending() {
            // The counter has turned over and the interrupt waits for the end of this section. Whether it did so before or
            // after the counter was read is unknown: read it again.
            counter = SYST::get_current();
            millis += 1;
        }
        // The interrupt comes with 0, at which the millisecond begins; the counter goes on from the reload value downwards.
        let ticks = if counter == 0 {
            0
        } else {
            TICKS_PER_MS - counter
        };
        Instant::from_ticks(millis * 1000 + u64::from(ticks / TICKS_PER_US))
    })
}

#[cortex_m_rt::exception]
fn SysTick() {
    critical_section::with(|cs| {
        let millis = MILLIS.borrow(cs);
        millis.set(millis.get() + 1);
    });
    sleep::wake();
}

#[cfg(feature = "defmt")]
defmt::timestamp!("{=u64:us}", now().ticks());
