//! The independent watchdog. Its registers are the same in all chips.

use super::{INTERNAL_CLOCK, LSI_KHZ, WATCHDOG_PERIOD_MS, pac};

// Keys of IWDG_KR.
const ACCESS: u16 = 0x5555;
const RELOAD: u16 = 0xAAAA;
const START: u16 = 0xCCCC;

/// IWDG_PR: a division by 32.
pub(super) const PRESCALER: u16 = 0b011;

/// IWDG_RLR: a period has one count more.
pub(super) const COUNTS: u32 = WATCHDOG_PERIOD_MS * LSI_KHZ / 32 - 1;
const _: () = assert!(COUNTS < 1 << 12);

/// Reads of IWDG_SR until the wait for the update ends, at one cycle each: 10 ms. The update takes five cycles of LSI.
const POLLS: u32 = INTERNAL_CLOCK / 100;

/// The watchdog, whose time the main loop restarts.
pub struct Watchdog(pac::IWDG);

impl Watchdog {
    /// Starts it.
    ///
    /// The order is that of ST's driver. The counter starts at FFFh, and LSI, which the update of the other registers needs, starts with it.
    /// So the first period has its length only if the counter is reloaded after the update.
    pub(super) fn start(registers: pac::IWDG) -> Self {
        let mut watchdog = Self(registers);
        watchdog.write_key(START);
        watchdog.set_period(COUNTS);
        watchdog
    }

    /// Sets the period in counts of 32 cycles of LSI, less one, and restarts the time.
    pub(super) fn set_period(&mut self, counts: u32) {
        self.write_key(ACCESS);
        // SAFETY: valid values of these registers.
        unsafe {
            self.0.pr().write(|w| w.bits(PRESCALER));
            self.0.rlr().write(|w| w.bits(counts as u16));
        }
        for _ in 0..POLLS {
            if self.0.sr().read().bits() == 0 {
                break;
            }
        }
        self.feed();
    }

    /// Restarts the time after which it resets the chip.
    pub fn feed(&mut self) {
        self.write_key(RELOAD);
    }

    fn write_key(&mut self, key: u16) {
        // SAFETY: the callers write the keys of the manual.
        unsafe { self.0.kr().write(|w| w.bits(key)) };
    }
}

/// Permits a write of IWDG_PR and IWDG_RLR.
pub(super) fn permit() {
    // SAFETY: the key has no other effect.
    unsafe { pac::IWDG::steal().kr().write(|w| w.bits(ACCESS)) };
}
