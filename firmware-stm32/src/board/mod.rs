//! The boards: clocks, pins and constants. One of them is compiled. The rest of the firmware uses only the names of this module.

use crate::flash::ParameterFlash;
use crate::silicon;
use core::sync::atomic::{AtomicU8, Ordering};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use plumbline::diagnosis::ResetCauses;
use plumbline::node::Leds;
use plumbline::store::crc32;

mod registers;
mod watchdog;

pub use registers::restore;
pub use watchdog::Watchdog;

#[cfg(feature = "stm32f103")]
mod stm32f103;
#[cfg(feature = "stm32f103")]
pub use stm32f103::*;

#[cfg(feature = "bluepill")]
mod bluepill;
#[cfg(feature = "bluepill")]
pub use bluepill::*;

#[cfg(feature = "nucleo-f103rb")]
mod nucleo_f103rb;
#[cfg(feature = "nucleo-f103rb")]
pub use nucleo_f103rb::*;

#[cfg(feature = "nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "nucleo-f446re")]
pub use nucleo_f446re::*;

/// The parts of the board that the firmware uses, initialised.
pub struct Board {
    /// The timer of the time base.
    pub systick: SYST,
    /// The independent watchdog, which runs already.
    pub watchdog: Watchdog,
    /// The status LEDs, all of them off.
    pub leds: StatusLeds,
    /// Heater and terminating resistor, off.
    pub switches: Switches,
    /// The CAN controller, with its clock and pins, still in reset state.
    pub can: CanPeripheral,
    /// The SPI and the chip select of the accelerometer.
    pub imu: ImuWires,
    /// The part of the flash with the records of the node.
    pub flash: ParameterFlash<Flash>,
    /// The serial number of the sensor, from the unique identifier of the chip.
    pub serial: u32,
}

/// The watchdog resets the board unless it is fed within this time. Nominal 2 s. Because of the tolerance of the watchdog
/// oscillators (30 to 60 kHz on the F103, 17 to 47 kHz on the F446), it is at least 1.3 s. The longest stall is an erase of up to
/// 0.5 s on the F446.
const WATCHDOG_PERIOD_MS: u32 = 2000;

/// The SPI clock of the accelerometer. It permits 10 MHz, but not at the end of loose wires. Its values need 107 kbit/s.
const SPI_CLOCK_HZ: u32 = 2_000_000;

/// The period of the heater PWM: 1 kHz. With ticks of 1 us, the duty in permille is the number of ticks.
const HEATER_PERIOD_US: u32 = 1000;

/// The serial number: the CRC-32 of the 96-bit unique device identifier, so that chips of one wafer get different numbers.
fn serial(unique_id: [u32; 3]) -> u32 {
    let mut crc = 0;
    for word in unique_id {
        crc = crc32(crc, &word.to_le_bytes());
    }
    crc
}

/// Resets the chip, with CAN_TX recessive and the heater off before.
pub fn restart() -> ! {
    make_safe();
    SCB::sys_reset()
}

/// Waits by counting instructions, at least this number of microseconds.
pub fn delay(us: u32) {
    cortex_m::asm::delay(us.saturating_mul(CORE_CLOCK / 1_000_000));
}

/// The causes of the last reset: bits 24 to 31 of RCC_CSR. A debugger can read them. Bit 1: brown-out (F446), 2: reset pin, 3:
/// power-on, 4: software, 5: watchdog, 7: low power.
/// An internal reset also sets the bit of the reset pin.
#[used]
static RESET_CAUSES: AtomicU8 = AtomicU8::new(0);

/// Keeps the causes of the last reset and clears them in the hardware, which otherwise collects them until power-off.
fn note_reset(rcc: &pac::RCC) {
    let causes = (rcc.csr().read().bits() >> 24) as u8;
    rcc.csr().write(|w| w.rmvf().set_bit());
    RESET_CAUSES.store(causes, Ordering::Relaxed);
    info!(
        "reset: power-on {=bool}, software {=bool}, watchdog {=bool}, RCC_CSR {=u8:#x}",
        causes >> 3 & 1 != 0,
        causes >> 4 & 1 != 0,
        causes >> 5 & 1 != 0,
        causes
    );
}

/// The causes of the last reset for the node.
pub fn reset_causes() -> ResetCauses {
    let bits = RESET_CAUSES.load(Ordering::Relaxed);
    let has = |bit: u8, cause: ResetCauses| if bits >> bit & 1 != 0 { cause.0 } else { 0 };
    let own = has(3, ResetCauses::POWER_ON)
        | has(4, ResetCauses::SOFTWARE)
        | has(5, ResetCauses::WATCHDOG)
        | has(6, ResetCauses::OTHER)
        | has(7, ResetCauses::OTHER);
    // Power-on also sets the bit of the brown-out, and each reset that of the pin.
    ResetCauses(match (own, has(1, ResetCauses::LOW_SUPPLY)) {
        (0, 0) => has(2, ResetCauses::PIN),
        (0, low) => low,
        (own, _) => own,
    })
}

/// Logs the identifiers of the microcontroller, and a warning if it is not one of ST.
fn log_silicon(cpuid: u32, idcode: u32) {
    info!(
        "CPUID {=u32:#x}, DEV_ID {=u32:#x}, DBGMCU_IDCODE {=u32:#x}",
        cpuid,
        idcode & 0xFFF,
        idcode
    );
    if let Some(_name) = silicon::substitute(GENUINE_CPUID, cpuid, idcode) {
        warn!("the microcontroller is not one of ST, but {=str}", _name);
    }
}

/// The supply of the sensor in mV, from a count of the converter: 3300 mV * (100 k + 6.8 k) / 6.8 k / 4096 = 12.7 mV per count. The
/// reference is the 3.3 V of the board, and its error is that of the result.
const fn supply_millivolts(count: u16) -> u16 {
    // At most 51816 for 12 bits.
    ((count as u32 * 51_829) >> 12) as u16
}

/// True while the supply of the microcontroller is too low to begin an operation of the flash.
fn supply_is_low() -> bool {
    // SAFETY: reads a status bit.
    let pwr = unsafe { pac::PWR::steal() };
    pwr.csr().read().pvdo().bit_is_set()
}

/// The time of an attempt to start the oscillator, in cycles of the internal clock: half a second. A crystal takes some milliseconds.
const ATTEMPT: u32 = INTERNAL_CLOCK / 2;

/// Starts HSE and waits for it, and for the supply. After the first attempt without success the error LED is on. Until an attempt succeeds
/// the board stays off the bus: the internal oscillator is too inaccurate for CAN, and at a low supply the transceiver works outside of its
/// limits and the flash cannot be erased in advance. The watchdog is fed, because a reset would not help. Each attempt switches the
/// oscillator on again: a crystal can start by this, and an external clock can appear later. On a Nucleo, attempts with the external
/// clock and with the crystal alternate.
fn start_oscillator(
    rcc: &pac::RCC,
    systick: &mut SYST,
    watchdog: &mut Watchdog,
    leds: &mut StatusLeds,
) {
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(ATTEMPT - 1);
    loop {
        change_oscillator(rcc);
        rcc.cr().modify(|_, w| w.hseon().set_bit());
        systick.clear_current();
        systick.enable_counter();
        while !systick.has_wrapped() {
            if rcc.cr().read().hserdy().bit_is_set() && !supply_is_low() {
                systick.disable_counter();
                return;
            }
        }
        rcc.cr().modify(|_, w| w.hseon().clear_bit());
        watchdog.feed();
        leds.show(Leds {
            error: true,
            ..Leds::default()
        });
        error!("not on the bus: HSE does not start, or the supply is low");
    }
}
