//! The pulses at the receive pin, for the bit rate detection ([`PulseMeter`]).
//!
//! Two channels of a timer capture the edges of RXD: channel 4 the start of a dominant pulse, channel 3 its end. The interrupt at
//! the end of a pulse reads both. This works at any bit rate of the CAN controller, and a silent bus causes no interrupt.

use crate::board::{self, PulseTimer};
use crate::sleep;
use core::cell::Cell;
use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
use plumbline::node::{BitTime, PulseMeter};
use plumbline::time::Instant;

/// The prescaler of the timer, whose clock runs at twice the frequency of APB1.
const PRESCALER: u32 = 2 * board::APB1_CLOCK / (BitTime::PER_US * 1_000_000);

/// The counter at the start. If the bus is dominant then, the start of this pulse is not captured and reads 0. With this count, the
/// pulse is too long to be measured.
const FIRST_COUNT: u32 = 0x2000;

/// CCMR2 as input capture: channels 3 and 4 on TI3 (CC3S = 01, CC4S = 10). The filter ignores pulses shorter than 8 clocks (IC3F =
/// IC4F = 0011).
const CHANNELS: u32 = 0x3231;

/// CCER: channel 3 captures rising edges, channel 4 falling edges (CC3E, CC4E, CC4P).
const EDGES: u32 = 1 << 8 | 1 << 12 | 1 << 13;

static METER: Mutex<Cell<PulseMeter>> = Mutex::new(Cell::new(PulseMeter::EMPTY));

/// Starts the measurement. Called once after a reset.
pub(super) fn start() {
    board::enable_pulse_timer();
    let timer = timer();
    // SAFETY: these are valid values of the registers (RM0008, RM0390: general-purpose timers).
    unsafe {
        timer.psc().write(|w| w.bits(PRESCALER - 1));
        // The sources do not agree on the reset value. At 0 the counter is blocked.
        timer.arr().write(|w| w.bits(0xFFFF));
        timer.egr().write(|w| w.bits(1));
        timer.cnt().write(|w| w.bits(FIRST_COUNT));
        timer.ccmr2_input().write(|w| w.bits(CHANNELS));
        timer.ccer().write(|w| w.bits(EDGES));
        timer.dier().write(|w| w.bits(1 << 3));
        timer.cr1().write(|w| w.bits(1));
        NVIC::unmask(board::PULSE_INTERRUPT);
    }
}

/// Stops the measurement.
pub(super) fn stop() {
    NVIC::mask(board::PULSE_INTERRUPT);
}

/// The bit time of the last frame, once.
pub(super) fn poll(now: Instant) -> Option<BitTime> {
    with_meter(|meter| meter.poll(now))
}

/// True while [`poll`] can have a result without another pulse.
pub(super) fn is_pending() -> bool {
    with_meter(|meter| meter.is_pending())
}

/// The interrupt at the end of a pulse.
pub fn on_pulse() {
    let timer = timer();
    // Reading the captured values clears the flags.
    let start = timer.ccr4().read().bits() as u16;
    let end = timer.ccr3().read().bits() as u16;
    with_meter(|meter| meter.pulse(start, end));
    sleep::wake();
}

fn with_meter<T>(f: impl FnOnce(&mut PulseMeter) -> T) -> T {
    critical_section::with(|cs| {
        let cell = METER.borrow(cs);
        let mut meter = cell.get();
        let result = f(&mut meter);
        cell.set(meter);
        result
    })
}

fn timer() -> PulseTimer {
    // SAFETY: only this module uses the timer.
    unsafe { PulseTimer::steal() }
}
