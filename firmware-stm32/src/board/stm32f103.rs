//! STM32F103, a medium-density device: what its boards share. A board has the pins that are its own in its file, and uses these:
//!
//! | pin | connected to                                            |
//! |-----|---------------------------------------------------------|
//! | PB8 | CAN transceiver RXD; TIM4 measures its pulses           |
//! | PB9 | CAN transceiver TXD                                     |
//! | PB0 | heater switch (a logic-level MOSFET), on when high, PWM |
//! | PB1 | switch of the 120 ohm terminating resistor, on when high |
//!
//! The core runs at 64 MHz instead of 72 so that APB1 runs at 32 MHz ([`bit_timing`](crate::bit_timing)).
//!
//! The registers are set directly, because the code of the HAL for the same pins and clocks is three times as large. All of them
//! must have their reset values at the start: start the program by a reset, not from a bootloader.

mod adc;
mod configuration;
mod flash;
mod memory;
mod vectors;

pub use adc::{start_adc, supply};
pub(super) use configuration::REGISTERS;
pub use flash::Flash;
pub use memory::check_memories;

use super::{
    Board, HEATER_PERIOD_US, SPI_BUS_CLOCK, SPI_CLOCK_HZ, Spi, StatusLeds, Watchdog, connect_spi,
    connect_supply, log_silicon, note_reset, select_imu, set_own_pins, start_oscillator,
};
use crate::flash::ParameterFlash;
use crate::imu::{SpiError, Wires};
use crate::silicon;
use cortex_m::peripheral::SYST;
pub(crate) use stm32f1::stm32f103 as pac;
pub use stm32f1::stm32f103::Interrupt;

/// The registers of a port.
pub(super) type Port = pac::gpioa::RegisterBlock;

/// The core clock in Hz.
pub const CORE_CLOCK: u32 = 64_000_000;

/// The clock after a reset in Hz: the internal oscillator.
pub(super) const INTERNAL_CLOCK: u32 = 8_000_000;

/// LSI in kHz, typical.
pub(super) const LSI_KHZ: u32 = 40;

/// The clock of APB1 in Hz.
pub const APB1_CLOCK: u32 = 32_000_000;

/// The registers of the CAN controller.
pub type CanPeripheral = pac::CAN;

/// The timer of the bit rate detection. Its channel 3 is on PB8.
pub type PulseTimer = pac::TIM4;

/// The timer has captured the end of a pulse.
pub const PULSE_INTERRUPT: pac::Interrupt = pac::Interrupt::TIM4;

/// The filter banks of the CAN controller (medium-density devices; the PAC defines 28 for all devices).
pub const FILTER_BANKS: u8 = 14;

/// CAN_FMR with all filter banks for the CAN controller, from its present value: here all bits besides FINIT are reserved.
pub const fn own_filters(master: u32) -> u32 {
    master
}

/// Receive FIFO 0 contains a frame.
pub const CAN_RECEIVE_INTERRUPT: pac::Interrupt = pac::Interrupt::USB_LP_CAN_RX0;

/// A transmit mailbox has become free.
pub const CAN_TRANSMIT_INTERRUPT: pac::Interrupt = pac::Interrupt::USB_HP_CAN_TX;

/// CPUID of a microcontroller of ST.
pub(super) const GENUINE_CPUID: u32 = silicon::STM32F103;

impl Board {
    /// Initialises watchdog, clocks and pins.
    ///
    /// # Safety
    /// Call it only once: it takes all peripherals.
    pub unsafe fn take() -> Self {
        // SAFETY: the caller owns all peripherals.
        let (core, device) = unsafe { (cortex_m::Peripherals::steal(), pac::Peripherals::steal()) };
        set_up_debugging();
        note_reset(&device.RCC);
        log_silicon(core.CPUID.base.read(), device.DBGMCU.idcode().read().bits());
        // SAFETY: as above.
        let basis = unsafe { Basis::take() };
        start_heater(&device.TIM3, &device.GPIOB);
        // SAFETY: the caller owns all peripherals.
        let spi = unsafe { Spi::steal() };
        start_spi(&spi);
        Self {
            systick: basis.systick,
            watchdog: basis.watchdog,
            leds: basis.leds,
            switches: Switches { timer: device.TIM3 },
            can: basis.can,
            imu: ImuWires(spi),
            flash: ParameterFlash(Flash::new(device.FLASH)),
            serial: super::serial(unique_id()),
        }
    }
}

/// What the bootloader needs of a board.
pub struct Basis {
    /// The timer of the core.
    pub systick: SYST,
    /// The watchdog, which runs.
    pub watchdog: Watchdog,
    /// The LEDs.
    pub leds: StatusLeds,
    /// The registers of the CAN controller.
    pub can: CanPeripheral,
}

impl Basis {
    /// Initialises watchdog, clocks and pins.
    ///
    /// # Safety
    /// Call it only once: it takes these peripherals.
    pub unsafe fn take() -> Self {
        // SAFETY: the caller owns all peripherals.
        let (mut core, device) =
            unsafe { (cortex_m::Peripherals::steal(), pac::Peripherals::steal()) };
        let mut watchdog = Watchdog::start(device.IWDG);
        switch_on(&device.RCC);
        start_supply_monitor(&device.PWR);
        set_pins(&device.AFIO, &device.GPIOA, &device.GPIOB, &device.GPIOC);
        let mut leds = StatusLeds;
        start_oscillator(&device.RCC, &mut core.SYST, &mut watchdog, &mut leds);
        start_pll(&device.RCC, &device.FLASH);
        Self {
            systick: core.SYST,
            watchdog,
            leds,
            can: device.CAN,
        }
    }
}

/// The clocks of the debug port run in sleep and stop mode. While a debugger halts the core, the watchdog and the timer of the heater stop.
/// The timer also disables its output (RM0008, DBGMCU_CR).
///
/// The register is written whole. A program reads it as 0 (errata sheet ES096), so a change of single bits would clear those that a
/// debugger has set.
///
/// Call it also while the program runs: on an STM32F103 a write can have no effect without a debugger, and one can connect later.
pub fn set_up_debugging() {
    // SAFETY: this is the only code that writes these registers.
    let debug = unsafe { pac::DBGMCU::steal() };
    debug.cr().write(|w| {
        w.dbg_sleep().set_bit().dbg_stop().set_bit();
        w.dbg_standby().set_bit();
        w.dbg_iwdg_stop().set_bit().dbg_tim3_stop().set_bit()
    });
}

/// Switches the clocks of the peripherals on.
///
/// The DMA controller is not used. But its clock keeps the clock of the bus and the RAM on while the core sleeps. Without this clock a
/// debugger cannot read the RAM, which contains the log.
fn switch_on(rcc: &pac::RCC) {
    // The clocks of RAM and flash in sleep mode stay on: they are the reset value.
    rcc.ahbenr().write(|w| w.dma1en().set_bit());
    rcc.apb2enr().write(|w| {
        w.afioen().set_bit();
        w.iopaen().set_bit().iopben().set_bit().iopcen().set_bit()
    });
    rcc.apb1enr()
        .write(|w| w.tim3en().set_bit().canen().set_bit().pwren().set_bit());
    connect_spi(rcc);
    // The clocks run after this write.
    cortex_m::asm::dsb();
}

/// Starts the voltage detector with its highest level: 2.66 to 2.9 V while the supply falls, at most 3.0 V while it rises (DS5319).
/// A running flash operation can end, because the flash works down to 2.0 V.
fn start_supply_monitor(pwr: &pac::PWR) {
    // SAFETY: all values of the field are levels.
    pwr.cr()
        .write(|w| unsafe { w.pls().bits(0b111).pvde().set_bit() });
}

/// Starts the PLL from HSE: 64 MHz for core, APB2 and timers, 32 MHz for APB1. From now on, HSE that stops causes
/// an NMI.
fn start_pll(rcc: &pac::RCC, flash: &pac::FLASH) {
    flash.acr().write(|w| w.prftbe().set_bit().latency().ws2());
    rcc.cfgr().write(|w| {
        w.pllsrc().hse_div_prediv().pllmul().mul8();
        w.ppre1().div2().adcpre().div6()
    });
    rcc.cr()
        .modify(|_, w| w.pllon().set_bit().csson().set_bit());
    while rcc.cr().read().pllrdy().bit_is_clear() {}
    rcc.cfgr().modify(|_, w| w.sw().pll());
}

/// Resets the CAN controller and the timer of the heater, and keeps them in reset: TXD is recessive, the heater is off.
pub fn make_safe() {
    // SAFETY: the program ends.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1rstr()
        .write(|w| w.tim3rst().set_bit().canrst().set_bit());
}

/// Configures the pins. The level of an output is set first.
fn set_pins(afio: &pac::AFIO, a: &Port, b: &Port, c: &Port) {
    // TXD is recessive until `connect_transmitter`. For the input, the level is the direction of its resistor.
    // SAFETY: 2 is the mapping to PB8 and PB9 (RM0008, AFIO_MAPR).
    afio.mapr().write(|w| unsafe { w.can_remap().bits(2) });
    b.bsrr().write(|w| w.bs8().set_bit().bs9().set_bit());
    b.crl().write(|w| {
        // Low until the timer of the heater runs.
        w.mode0().output50().cnf0().push_pull();
        w.mode1().output50().cnf1().push_pull()
    });
    b.crh().write(|w| {
        w.mode8().input().cnf8().alt_push_pull();
        w.mode9().output50().cnf9().push_pull()
    });
    set_own_pins(a, b, c);
    connect_supply();
}

/// Starts the PWM of the heater with duty 0, then connects its pin.
fn start_heater(timer: &pac::TIM3, port: &pac::GPIOB) {
    // SAFETY: all values of these registers are valid.
    unsafe {
        // Ticks of 1 us.
        timer.psc().write(|w| w.bits(CORE_CLOCK / 1_000_000 - 1));
        timer.arr().write(|w| w.bits(HEATER_PERIOD_US - 1));
    }
    timer
        .ccmr2_output()
        .write(|w| w.oc3m().pwm_mode1().oc3pe().set_bit());
    timer.ccer().write(|w| w.cc3e().set_bit());
    // The prescaler takes effect with an update.
    timer.egr().write(|w| w.ug().set_bit());
    timer.cr1().write(|w| w.arpe().set_bit().cen().set_bit());
    port.crl().modify(|_, w| w.cnf0().alt_push_pull());
}

/// Starts the SPI as master in mode 0, with 8 bits.
fn start_spi(spi: &Spi) {
    // BR: 0 is a division by 2, 7 by 256.
    const DIVISION: u32 = SPI_BUS_CLOCK / SPI_CLOCK_HZ;
    const { assert!(DIVISION.is_power_of_two() && DIVISION * SPI_CLOCK_HZ == SPI_BUS_CLOCK) };
    spi.cr1().write(|w| {
        w.mstr().set_bit().br().set(DIVISION.ilog2() as u8 - 1);
        w.ssm().set_bit().ssi().set_bit();
        w.spe().set_bit()
    });
}

/// Sets the outputs `pins` of a port to `levels`. Other pins do not change.
pub(super) fn set_outputs(port: &Port, pins: u32, levels: u32) {
    let low = pins & !levels;
    // SAFETY: all values of this register are valid, and the caller owns the pins.
    port.bsrr().write(|w| unsafe { w.bits(levels | low << 16) });
}

/// The switches of the heater and of the terminating resistor.
pub struct Switches {
    timer: pac::TIM3,
}

impl Switches {
    /// Connects or disconnects the terminating resistor.
    pub fn terminate(&mut self, on: bool) {
        // SAFETY: only this code uses PB1.
        let port = unsafe { pac::GPIOB::steal() };
        set_outputs(&port, 1 << 1, u32::from(on) << 1);
    }

    /// Sets the power of the heater, 0 to 1000 permille.
    pub fn heat(&mut self, permille: u16) {
        // A period is 1000 ticks.
        // SAFETY: all values of the register are valid.
        self.timer
            .ccr3()
            .write(|w| unsafe { w.bits(permille.into()) });
    }
}

/// The SPI and the chip select of the accelerometer.
pub struct ImuWires(Spi);

impl Wires for ImuWires {
    fn select(&mut self, selected: bool) {
        select_imu(selected);
    }

    fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
        // A disturbance can have let the SPI receive without end. Its last byte would delay all others. These reads discard it, and clear the
        // overrun flag.
        self.0.dr().read();
        self.0.sr().read();
        for byte in bytes {
            // There is no overrun: each byte is read before the next one is sent.
            self.0.dr().write(|w| w.dr().set((*byte).into()));
            while self.0.sr().read().rxne().bit_is_clear() {}
            *byte = self.0.dr().read().dr().bits() as u8;
        }
        while self.0.sr().read().bsy().bit_is_set() {}
        Ok(())
    }
}

/// The 96-bit unique device identifier (RM0008, device electronic signature).
fn unique_id() -> [u32; 3] {
    const ADDRESS: *const [u32; 3] = 0x1FFF_F7E8 as *const _;
    // SAFETY: system memory of all F103 devices, always readable, never written.
    unsafe { ADDRESS.read_volatile() }
}

/// The end of an interrupt handler. The Cortex-M3 needs no action here; see the board with a Cortex-M4.
#[inline(always)]
pub fn end_handler() {}

/// Connects TXD to the CAN controller; otherwise the pin is a recessive output.
pub fn connect_transmitter(connected: bool) {
    // SAFETY: after the boot, this is the only code that changes this register.
    let port_b = unsafe { pac::GPIOB::steal() };
    port_b.crh().modify(|_, w| {
        w.mode9().output50();
        if connected {
            w.cnf9().alt_push_pull()
        } else {
            w.cnf9().push_pull()
        }
    });
}

/// Whether the level of RXD is dominant.
pub fn receives_dominant() -> bool {
    // SAFETY: reads the levels of the pins.
    let port_b = unsafe { pac::GPIOB::steal() };
    port_b.idr().read().idr8().bit_is_clear()
}

/// Resets the CAN controller, with its error counters.
pub fn reset_can() {
    // SAFETY: this is the only code that uses this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1rstr().write(|w| w.canrst().set_bit());
    rcc.apb1rstr().write(|w| w.canrst().clear_bit());
}

/// Switches the clock of the CRC unit on or off. It runs after a barrier.
pub fn clock_crc_unit(on: bool) {
    // SAFETY: the bootloader is the only code that uses this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.ahbenr().modify(|_, w| w.crcen().bit(on));
}

/// Enables the clock of [`PulseTimer`].
pub fn enable_pulse_timer() {
    // SAFETY: the main loop is the only code that changes this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1enr().modify(|_, w| w.tim4en().set_bit());
    // The clock runs after this write.
    cortex_m::asm::dsb();
}
