//! The time since power-up in microseconds, from SysTick: it interrupts every millisecond, and its counter gives the rest.
//!
//! The same interrupt is the alarm clock: it wakes the main loop at the time that this has named, and otherwise leaves it asleep.
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

/// The time of the last interrupt, in microseconds.
static TICKED: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// When to wake the main loop, in microseconds.
static ALARM: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

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
        let mut ticked = TICKED.borrow(cs).get();
        let mut counter = SYST::get_current();
        if SCB::is_pendst_pending() {
            // The counter has turned over and the interrupt waits for the end of this section. Whether it did so before or
            // after the counter was read is unknown: read it again.
            counter = SYST::get_current();
            ticked += 1000;
        }
        // The interrupt comes with 0, at which the millisecond begins; the counter goes on from the reload value downwards.
        let ticks = if counter == 0 {
            0
        } else {
            TICKS_PER_MS - counter
        };
        Instant::from_ticks(ticked + u64::from(ticks / TICKS_PER_US))
    })
}

/// Wakes the main loop with the first interrupt that is not before `time`; at once if it has been already.
pub fn set_alarm(time: Instant) {
    let past = critical_section::with(|cs| {
        ALARM.borrow(cs).set(time.ticks());
        TICKED.borrow(cs).get() >= time.ticks()
    });
    if past {
        sleep::wake();
    }
}

#[cortex_m_rt::exception]
fn SysTick() {
    let due = critical_section::with(|cs| {
        let ticked = TICKED.borrow(cs);
        ticked.set(ticked.get() + 1000);
        ticked.get() >= ALARM.borrow(cs).get()
    });
    if due {
        sleep::wake();
    }
}

#[cfg(feature = "defmt")]
defmt::timestamp!("{=u64:us}", now().ticks());
