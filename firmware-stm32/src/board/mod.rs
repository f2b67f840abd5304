//! The boards: clocks, pins and constants. One of them is compiled in; the rest of the firmware knows only these names.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embedded_hal::delay::DelayNs;

#[cfg(feature = "bluepill")]
mod bluepill;
#[cfg(feature = "bluepill")]
pub use bluepill::*;

#[cfg(feature = "nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "nucleo-f446re")]
pub use nucleo_f446re::*;

/// Resets the board unless it is fed within this time. Nominal 2 s; the oscillators behind the watchdogs are so loose (30 to
/// 60 kHz on the F103, 17 to 47 kHz on the F446) that it is at least 1.3 s, which leaves room for the longest stall, an erase of
/// up to 0.5 s on the F446.
const WATCHDOG_PERIOD_MS: u32 = 2000;

/// The clock of the accelerometer's SPI; the part takes up to 10 MHz.
const SPI_CLOCK_HZ: u32 = 8_000_000;

/// The period of the heater's PWM: 1 kHz, in ticks of 1 us the duty's permille.
const HEATER_PERIOD_US: u32 = 1000;

/// The serial number: CRC-32 of the 96-bit unique device identifier, so that parts of one wafer get different ones.
fn serial(unique_id: [u32; 3]) -> u32 {
    let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for word in unique_id {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

/// Waits by counting instructions, at least as long as asked.
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // In whole microseconds, to spare a division of 64 bits.
        cortex_m::asm::delay(ns.div_ceil(1000).saturating_mul(CORE_CLOCK / 1_000_000));
    }
}
