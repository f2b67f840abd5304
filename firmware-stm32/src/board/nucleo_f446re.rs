//! Nucleo-F446RE: STM32F446RE, 512 KiB flash, 128 KiB RAM, 8 MHz from the ST-LINK.
//!
//! | pin  | connected to                                                 |
//! |------|--------------------------------------------------------------|
//! | PA11 | CAN transceiver RXD                                          |
//! | PB8  | CAN transceiver RXD too, for the bit rate detection (TIM4)   |
//! | PA12 | CAN transceiver TXD                                          |
//! | PB12 | ISM330DHCX CS                                                |
//! | PB13 | ISM330DHCX SCL (SPC)                                         |
//! | PB14 | ISM330DHCX SDO                                               |
//! | PB15 | ISM330DHCX SDA (SDI)                                         |
//! | PA5  | run LED: LD2 on the board, lit when high                     |
//! | PB10 | error LED with its resistor to ground, lit when high         |
//! | PC6  | green module LED with its resistor to ground, lit when high  |
//! | PC7  | red module LED with its resistor to ground, lit when high    |
//! | PB0  | heater switch (a logic-level MOSFET), on when high, PWM      |
//! | PB1  | switch of the 120 ohm terminating resistor, on when high     |
//! | PC0  | supply: divider of 100 k to the supply, 6.8 k to ground      |
//!
//! PB0 and PB1 are for products with a heater or a switched terminating resistor. Each has a resistor to ground, so that both are
//! off while the microcontroller is in reset. The divider is for products that measure their supply.
//!
//! SPI2 is used because the clock of SPI1 is on PA5, the LED. The transceiver runs at 3.3 V and must not have a dominant time-out
//! that is too short for 10 kbit/s; for example SN65HVD230. The core runs at 128 MHz, so that APB1 runs at a quarter of it, 32
//! MHz ([`bit_timing`](crate::bit_timing)).

mod adc;
mod configuration;
mod flash;

pub use adc::{start_adc, supply};
pub(super) use configuration::REGISTERS;
pub use flash::Flash;

use super::{
    Board, HEATER_PERIOD_US, SPI_CLOCK_HZ, Watchdog, log_silicon, note_reset, start_oscillator,
};
use crate::flash::ParameterFlash;
use crate::imu::mounting::Mounting;
use crate::imu::{SpiError, Wires};
use crate::silicon;
use cortex_m::peripheral::SYST;
use embedded_hal::spi::{MODE_0, SpiBus};
use plumbline::node::Leds;
use plumbline::update::layout::{self, Layout};
use stm32f4xx_hal::gpio::{Output, PA5, PB1, PB10, PB12, PC6, PC7, PinState, Speed};
pub(crate) use stm32f4xx_hal::pac;
pub use stm32f4xx_hal::pac::Interrupt;
use stm32f4xx_hal::pac::interrupt;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{self, Enable};
use stm32f4xx_hal::spi::Spi;
use stm32f4xx_hal::timer::PwmChannel;

/// Checks nothing: there is no known chip with less memory than its name says.
///
/// # Safety
/// Only for [`firmware`](crate::firmware): it runs after a reset, before the RAM is initialised.
// SAFETY: it changes no register.
#[unsafe(naked)]
pub unsafe extern "C" fn check_memories<N>() {
    core::arch::naked_asm!("bx lr")
}

/// The core clock in Hz.
pub const CORE_CLOCK: u32 = 128_000_000;

/// The clock after a reset in Hz: the internal oscillator.
pub(super) const INTERNAL_CLOCK: u32 = 16_000_000;

/// LSI in kHz, typical.
pub(super) const LSI_KHZ: u32 = 32;

/// The clock of APB1 in Hz.
pub const APB1_CLOCK: u32 = 32_000_000;

/// The registers of the CAN controller (CAN1).
pub type CanPeripheral = pac::CAN1;

/// The timer of the bit rate detection. Its channel 3 is on PB8.
pub type PulseTimer = pac::TIM4;

/// The timer has captured the end of a pulse.
pub const PULSE_INTERRUPT: pac::Interrupt = pac::Interrupt::TIM4;

/// The filter banks of CAN1: the first 14 of the 28 that it shares with CAN2 (reset value of FMR.CAN2SB).
pub const FILTER_BANKS: u8 = 14;

/// CAN_FMR with [`FILTER_BANKS`] for CAN1, from its present value: CAN2SB is the first bank of CAN2.
pub const fn own_filters(master: u32) -> u32 {
    master & !(0x3F << 8) | (FILTER_BANKS as u32) << 8
}

/// Receive FIFO 0 contains a frame.
pub const CAN_RECEIVE_INTERRUPT: pac::Interrupt = pac::Interrupt::CAN1_RX0;

/// A transmit mailbox has become free.
pub const CAN_TRANSMIT_INTERRUPT: pac::Interrupt = pac::Interrupt::CAN1_TX;

/// CPUID of a microcontroller of ST.
pub(super) const GENUINE_CPUID: u32 = silicon::STM32F446;

/// The memory with a bootloader.
pub const LAYOUT: Layout = layout::NUCLEO_F446RE;

/// The mounting of the accelerometer.
pub const MOUNTING: Mounting = Mounting::ALIGNED;

/// The SPI and the chip select of the accelerometer.
pub struct ImuWires {
    spi: Spi<pac::SPI2>,
    select: PB12<Output>,
}

impl Wires for ImuWires {
    fn select(&mut self, selected: bool) {
        self.select.set_state((!selected).into());
    }

    fn exchange(&mut self, bytes: &mut [u8]) -> Result<(), SpiError> {
        let sent = SpiBus::transfer_in_place(&mut self.spi, bytes);
        // The last byte is read half a period before the end of its clock, and `flush` of the HAL does not wait for it.
        while self.spi.is_busy() {}
        sent.map_err(|_| SpiError)
    }
}

impl Board {
    /// Initialises watchdog, clocks and pins.
    ///
    /// # Safety
    /// Call it only once: it takes all peripherals.
    pub unsafe fn take() -> Self {
        // SAFETY: the caller owns all peripherals.
        let (mut core, device) =
            unsafe { (cortex_m::Peripherals::steal(), pac::Peripherals::steal()) };

        set_up_debugging();
        note_reset(&device.RCC);
        log_silicon(core.CPUID.base.read(), device.DBGMCU.idcode().read().bits());
        let mut watchdog = Watchdog::start(device.IWDG);

        let mut rcc = device.RCC.constrain();
        pac::PWR::enable(&mut rcc);
        // The DMA controller is not used. But its clock keeps the clock of the bus and the RAM on in sleep mode, for a debugger.
        rcc.ahb1enr().modify(|_, w| w.dma1en().set_bit());
        start_supply_monitor(&device.PWR);
        let gpioa = device.GPIOA.split(&mut rcc);
        let gpiob = device.GPIOB.split(&mut rcc);
        let gpioc = device.GPIOC.split(&mut rcc);

        // The divider of the supply.
        gpioc.pc0.into_analog();
        let mut leds = StatusLeds {
            run: gpioa.pa5.into_push_pull_output_in_state(PinState::Low),
            error: gpiob.pb10.into_push_pull_output_in_state(PinState::Low),
            module_green: gpioc.pc6.into_push_pull_output_in_state(PinState::Low),
            module_red: gpioc.pc7.into_push_pull_output_in_state(PinState::Low),
        };

        // A Nucleo without its ST-LINK has no clock. The HAL would wait for it without end.
        start_oscillator(&rcc, &mut core.SYST, &mut watchdog, &mut leds);
        let clocks = rcc::Config::hse(8.MHz())
            .sysclk(128.MHz())
            .pclk1(32.MHz())
            .pclk2(64.MHz());
        let clocks = if rcc.cr().read().hsebyp().bit_is_set() {
            clocks.bypass_hse_oscillator()
        } else {
            clocks
        };
        let mut rcc = rcc.freeze(clocks);
        // From now on, a clock that stops causes an NMI.
        rcc.cr().modify(|_, w| w.csson().set_bit());

        CanPeripheral::enable(&mut rcc);
        gpioa
            .pa11
            .into_alternate::<9>()
            .set_internal_resistor(stm32f4xx_hal::gpio::Pull::Up);
        // TXD is recessive until `connect_transmitter`. An edge at low speed takes up to 100 ns, a tenth of a bit at 1 Mbit/s.
        gpioa
            .pa12
            .into_push_pull_output_in_state(PinState::High)
            .set_speed(Speed::Medium);
        // SAFETY: the register selects the alternate functions; PA11 has its own already, and 9 is that of CAN1 at PA12.
        unsafe { pac::GPIOA::steal() }
            .afrh()
            .modify(|_, w| w.afrh12().af9());
        gpiob
            .pb8
            .into_alternate::<2>()
            .set_internal_resistor(stm32f4xx_hal::gpio::Pull::Up);

        let (_, (_, _, heater, _)) = device.TIM3.pwm_us(HEATER_PERIOD_US.micros(), &mut rcc);
        let mut heater = heater.with(gpiob.pb0);
        heater.enable();
        let switches = Switches {
            heater,
            termination: gpiob.pb1.into_push_pull_output_in_state(PinState::Low),
        };

        let select = gpiob.pb12.into_push_pull_output_in_state(PinState::High);
        // At low speed the last bit of a transfer can be wrong. The pins get their speed before the bus starts.
        let sck = gpiob.pb13.into_alternate().speed(Speed::VeryHigh);
        // A missing accelerometer reads as FFh.
        let miso = gpiob.pb14.into_alternate().internal_pull_up(true);
        let mosi = gpiob.pb15.into_alternate().speed(Speed::VeryHigh);
        let pins = (Some(sck), Some(miso), Some(mosi));
        let spi = device.SPI2.spi(pins, MODE_0, SPI_CLOCK_HZ.Hz(), &mut rcc);

        Self {
            systick: core.SYST,
            watchdog,
            leds,
            switches,
            can: device.CAN1,
            imu: ImuWires { spi, select },
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
    /// Initialises watchdog, clocks and pins. The watchdog has its longest period: 4 s, at least 2.7 s. An erase of 128 KiB takes up to 2 s.
    ///
    /// # Safety
    /// Call it only once: it takes all peripherals.
    pub unsafe fn take() -> Self {
        // SAFETY: as the caller promises.
        let mut board = unsafe { Board::take() };
        board.watchdog.set_period(0xFFF);
        Self {
            systick: board.systick,
            watchdog: board.watchdog,
            leds: board.leds,
            can: board.can,
        }
    }
}

/// The clocks of the debug port run in sleep and stop mode. While a debugger halts the core, the watchdog and the timer of the heater stop.
///
/// Call it also while the program runs: on an STM32F103 a write can have no effect without a debugger, and one can connect later.
pub fn set_up_debugging() {
    // SAFETY: this is the only code that writes these registers.
    let debug = unsafe { pac::DBGMCU::steal() };
    debug.cr().write(|w| {
        w.dbg_sleep().set_bit().dbg_stop().set_bit();
        w.dbg_standby().set_bit()
    });
    debug
        .apb1_fz()
        .write(|w| w.dbg_iwdg_stop().set_bit().dbg_tim3_stop().set_bit());
}

/// Selects the oscillator of the next attempt: first the clock from the ST-LINK (HSEBYP), then the crystal X3, alternately. HSE is off.
pub(super) fn change_oscillator(rcc: &pac::RCC) {
    rcc.cr()
        .modify(|rcc, w| w.hsebyp().bit(rcc.hsebyp().bit_is_clear()));
}

/// Starts the voltage detector at level 6: 2.85 to 2.99 V while the supply falls, at most 3.1 V while it rises (datasheet). The flash
/// needs 2.7 V for words.
fn start_supply_monitor(pwr: &pac::PWR) {
    // SAFETY: all values of the field are levels.
    pwr.cr()
        .modify(|_, w| unsafe { w.pls().bits(0b110).pvde().set_bit() });
}

/// Resets the CAN controller and the timer of the heater, and keeps them in reset: TXD is recessive, the heater is off.
pub fn make_safe() {
    // SAFETY: the program ends.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1rstr()
        .write(|w| w.tim3rst().set_bit().can1rst().set_bit());
}

/// The status LEDs on the board and at its connectors.
pub struct StatusLeds {
    run: PA5<Output>,
    error: PB10<Output>,
    module_green: PC6<Output>,
    module_red: PC7<Output>,
}

impl StatusLeds {
    /// Switches each LED on or off.
    pub fn show(&mut self, leds: Leds) {
        self.run.set_state(leds.run.into());
        self.error.set_state(leds.error.into());
        self.module_green.set_state(leds.module_green.into());
        self.module_red.set_state(leds.module_red.into());
    }
}

/// The switches of the heater and of the terminating resistor.
pub struct Switches {
    heater: PwmChannel<pac::TIM3, 2>,
    termination: PB1<Output>,
}

impl Switches {
    /// Connects or disconnects the terminating resistor.
    pub fn terminate(&mut self, on: bool) {
        self.termination.set_state(on.into());
    }

    /// Sets the power of the heater, 0 to 1000 permille.
    pub fn heat(&mut self, permille: u16) {
        // A period is 1000 ticks.
        self.heater.set_duty(permille);
    }
}

/// The 96-bit unique device identifier (RM0390, device electronic signature).
fn unique_id() -> [u32; 3] {
    const ADDRESS: *const [u32; 3] = 0x1FFF_7A10 as *const _;
    // SAFETY: system memory of all F446 devices, always readable, never written.
    unsafe { ADDRESS.read_volatile() }
}

/// Connects TXD to the CAN controller; otherwise the pin is a recessive output.
pub fn connect_transmitter(connected: bool) {
    // SAFETY: after the boot, this is the only code that changes this register.
    let port_a = unsafe { pac::GPIOA::steal() };
    port_a.moder().modify(|_, w| {
        if connected {
            w.moder12().alternate()
        } else {
            w.moder12().output()
        }
    });
}

/// Whether the level of RXD is dominant.
pub fn receives_dominant() -> bool {
    // SAFETY: reads the levels of the pins.
    let port_a = unsafe { pac::GPIOA::steal() };
    port_a.idr().read().idr11().bit_is_clear()
}

/// Resets the CAN controller, with its error counters.
pub fn reset_can() {
    // SAFETY: after the boot, this is the only code that uses this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1rstr().write(|w| w.can1rst().set_bit());
    rcc.apb1rstr().write(|w| w.can1rst().clear_bit());
}

/// Switches the clock of the CRC unit on or off. It runs after a barrier.
pub fn clock_crc_unit(on: bool) {
    // SAFETY: the bootloader is the only code that uses this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.ahb1enr().modify(|_, w| w.crcen().bit(on));
}

/// Enables the clock of [`PulseTimer`].
pub fn enable_pulse_timer() {
    // SAFETY: the main loop is the only code that changes this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1enr().modify(|_, w| w.tim4en().set_bit());
    // The clock runs after this write.
    cortex_m::asm::dsb();
}

/// The end of an interrupt handler. Arm erratum 838869: if a store is not complete at the return, and another interrupt comes, the
/// Cortex-M4 can start the wrong handler.
#[inline(always)]
pub fn end_handler() {
    cortex_m::asm::dsb();
}

unsafe extern "C" {
    /// The handlers that [`firmware`](crate::firmware) defines.
    fn CAN_RECEIVE();
    fn CAN_TRANSMIT();
}

#[interrupt]
fn CAN1_RX0() {
    // SAFETY: this is the interrupt for which it is written.
    unsafe { CAN_RECEIVE() };
    end_handler();
}

#[interrupt]
fn CAN1_TX() {
    // SAFETY: this is the interrupt for which it is written.
    unsafe { CAN_TRANSMIT() };
    end_handler();
}
