//! The pulses at the receive pin, for the bit rate detection ([`PulseMeter`]).
//!
//! Two channels of a timer capture the edges of RXD: channel 4 the start of a dominant pulse, channel 3 its end. The interrupt at the end
//! of a pulse stores both for the main loop, which calculates the bit time ([`Pulses`]). This works at any bit rate of the CAN controller,
//! and a silent bus causes no interrupt.

use crate::board::{self, PulseTimer};
use crate::sleep;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use cortex_m::peripheral::NVIC;
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

/// The maximum number of pulses that wait for the main loop: those of at least 128 us at 1 Mbit/s, with a pulse each 2 us.
const RING: usize = 64;

/// The captured counter at the start (lower 16 bits) and at the end (upper 16 bits) of the last pulses.
static PULSES: [AtomicU32; RING] = [const { AtomicU32::new(0) }; RING];

/// The number of pulses since the start of the program.
static COUNT: AtomicUsize = AtomicUsize::new(0);

/// The measurement of the bit time.
pub(super) struct Pulses {
    meter: PulseMeter,
    /// The number of pulses that the meter has received.
    taken: usize,
    /// The timer counts, and captures edges.
    runs: bool,
}

impl Pulses {
    pub(super) const NONE: Self = Self {
        meter: PulseMeter::EMPTY,
        taken: 0,
        runs: false,
    };

    pub(super) fn start(&mut self) {
        self.runs = true;
        board::enable_pulse_timer();
        let timer = timer();
        // SAFETY: these are valid values of the registers (RM0008, RM0390: general-purpose timers).
        unsafe {
            timer.cr2().reset();
            timer.smcr().reset();
            timer.psc().write(|w| w.bits(PRESCALER - 1));
            // The SVD has the reset value 0, some revisions of the manual have FFFFh. With 0 the timer does not count.
            timer.arr().write(|w| w.bits(0xFFFF));
            timer.egr().write(|w| w.bits(1));
            timer.cnt().write(|w| w.bits(FIRST_COUNT));
            timer.ccmr2_input().write(|w| w.bits(CHANNELS));
            timer.ccer().write(|w| w.bits(EDGES));
            timer.dier().write(|w| w.bits(1 << 3));
            timer.cr1().write(|w| w.bits(1));
        }
        unmask();
    }

    /// Starts the measurement again if a disturbance has changed the timer.
    pub(super) fn restore(&mut self) {
        if !self.runs {
            return;
        }
        if is_set(&timer()) {
            unmask();
        } else {
            self.stop();
            self.start();
        }
    }

    /// Stops the measurement. Channel 4 is off while the CAN controller drives its pin.
    pub(super) fn stop(&mut self) {
        if !core::mem::take(&mut self.runs) {
            return;
        }
        NVIC::mask(board::PULSE_INTERRUPT);
        let timer = timer();
        timer.cr1().reset();
        timer.dier().reset();
        timer.ccer().reset();
        // A read clears the flag of a pulse that is not stored.
        timer.ccr3().read();
        timer.ccr4().read();
    }

    /// The bit time of the last frame, once.
    pub(super) fn poll(&mut self, now: Instant) -> Option<BitTime> {
        let count = COUNT.load(Ordering::Relaxed);
        while self.taken != count {
            let pulse = PULSES.get(self.taken % RING)?.load(Ordering::Relaxed);
            if COUNT.load(Ordering::Relaxed).wrapping_sub(self.taken) > RING {
                // The interrupt has overwritten this pulse.
                self.taken = self.taken.wrapping_add(1);
                self.meter.skip();
                continue;
            }
            self.taken = self.taken.wrapping_add(1);
            self.meter.pulse(pulse as u16, (pulse >> 16) as u16);
        }
        self.meter.poll(now)
    }

    /// True while [`poll`](Self::poll) can have a result without another pulse.
    pub(super) fn is_pending(&self) -> bool {
        self.meter.is_pending() || self.taken != COUNT.load(Ordering::Relaxed)
    }
}

/// True if the timer has its configuration.
fn is_set(timer: &PulseTimer) -> bool {
    let control = timer.cr1().read().bits() == 1 && timer.dier().read().bits() == 1 << 3;
    let internal = timer.cr2().read().bits() == 0 && timer.smcr().read().bits() == 0;
    let input = timer.ccmr2_input().read().bits() == CHANNELS;
    let edges = timer.ccer().read().bits() == EDGES;
    let clock = timer.psc().read().bits() == PRESCALER - 1 && timer.arr().read().bits() == 0xFFFF;
    control && internal && input && edges && clock
}

fn unmask() {
    // SAFETY: the handler works in any state of the program.
    unsafe { NVIC::unmask(board::PULSE_INTERRUPT) };
}

/// The interrupt at the end of a pulse. At 1 Mbit/s, the next interrupt can follow after 2 us, so the handler only stores the captured
/// counters. Its priority is higher than that of the other interrupts.
pub fn on_pulse() {
    let timer = timer();
    // Reading the captured values clears the flags.
    let start = timer.ccr4().read().bits() & 0xFFFF;
    let end = timer.ccr3().read().bits() << 16;
    let count = COUNT.load(Ordering::Relaxed);
    if let Some(place) = PULSES.get(count % RING) {
        place.store(start | end, Ordering::Relaxed);
    }
    COUNT.store(count.wrapping_add(1), Ordering::Relaxed);
    sleep::wake();
    board::end_handler();
}

fn timer() -> PulseTimer {
    // SAFETY: only this module uses the timer.
    unsafe { PulseTimer::steal() }
}
