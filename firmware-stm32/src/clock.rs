//! The time since power-up in microseconds, from SysTick: the milliseconds from its interrupt, the remainder from its counter.
//!
//! The same interrupt wakes the main loop at the time of the alarm.
//!
//! The clock loses time only while an erase of the flash stalls the processor: at boot, and in a save without erased memory. The
//! time never decreases.

use crate::{board, sleep};
use core::cell::Cell;
use cortex_m::peripheral::{SCB, SYST};
use critical_section::Mutex;
use plumbline::time::{Duration, Instant, after, reached};

const TICKS_PER_US: u32 = board::CORE_CLOCK / 1_000_000;
const TICKS_PER_MS: u32 = 1000 * TICKS_PER_US;

/// The time of the last interrupt, in microseconds.
static TICKED: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// The time to wake the main loop, in microseconds.
static ALARM: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// SYST_CSR: the core clock, the interrupt and the counter are enabled.
const ENABLED: u32 = 0b111;

/// Starts the clock. The core must already run at [`CORE_CLOCK`](board::CORE_CLOCK).
pub fn start(systick: SYST) {
    // SAFETY: all values of these registers are valid, and the handler is ready.
    unsafe {
        systick.rvr.write(TICKS_PER_MS - 1);
        systick.cvr.write(0);
        systick.csr.write(ENABLED);
    }
}

/// Starts the clock again if a disturbance has changed it.
pub fn restore() {
    // SAFETY: the main loop owns the timer after the boot.
    let systick = unsafe { cortex_m::Peripherals::steal() }.SYST;
    if systick.csr.read() & ENABLED != ENABLED || systick.rvr.read() != TICKS_PER_MS - 1 {
        // The counter restarts at 0: without this, the time would decrease.
        add_millisecond();
        start(systick);
    }
}

/// Counts a millisecond. Returns true if the time of the alarm has come.
fn add_millisecond() -> bool {
    critical_section::with(|cs| {
        let ticked = TICKED.borrow(cs);
        ticked.set(ticked.get() + 1000);
        ticked.get() >= ALARM.borrow(cs).get()
    })
}

/// The time since the start, in us.
pub fn now() -> Instant {
    critical_section::with(|cs| {
        let mut ticked = TICKED.borrow(cs).get();
        let mut counter = SYST::get_current();
        if SCB::is_pendst_pending() {
            // The counter has been reloaded, and the interrupt waits for the end of this section. The reload was before or after
            // the read of the counter, so it must be read again.
            counter = SYST::get_current();
            ticked += 1000;
        }
        // The interrupt comes when the counter is 0, at the start of the millisecond. Then the counter counts down from the
        // reload value. A disturbance can have made this value larger: then the time stands until the counter is in its range.
        let ticks = if counter.wrapping_sub(1) < TICKS_PER_MS {
            TICKS_PER_MS - counter
        } else {
            0
        };
        Instant::from_ticks(ticked + u64::from(ticks / TICKS_PER_US))
    })
}

/// Whether the time of something that is done once in `period` has come. A time after the next period is that of a disturbed variable: then
/// it is due now.
pub fn is_due(now: Instant, due: Instant, period: Duration) -> bool {
    reached(now, due) || !reached(after(now, period), due)
}

/// The time of the next interrupt. What is due then is done then; what is due between two interrupts is done up to 1 ms later, or earlier if
/// a received frame wakes the main loop.
pub fn next_tick() -> Instant {
    let ticked = critical_section::with(|cs| TICKED.borrow(cs).get());
    Instant::from_ticks(ticked + 1000)
}

/// Wakes the main loop with the first interrupt at or after `time`; at once if it has already come.
pub fn set_alarm(time: Instant) {
    let past = critical_section::with(|cs| {
        ALARM.borrow(cs).set(time.ticks());
        TICKED.borrow(cs).get() >= time.ticks()
    });
    if past {
        sleep::wake();
    }
}

/// The interrupt of SysTick, which [`firmware`](crate::firmware) defines: the bootloader has none.
pub fn on_tick() {
    if add_millisecond() {
        sleep::wake();
    }
    board::end_handler();
}

#[cfg(feature = "defmt")]
defmt::timestamp!("{=u64:us}", now().ticks());
