//! Nucleo-F103RB: STM32F103RB, 128 KiB flash, 20 KiB RAM, 8 MHz from the ST-LINK. The pins are those of the Nucleo-F446RE except RXD and TXD.
//!
//! | pin  | connected to                                                 |
//! |------|--------------------------------------------------------------|
//! | PB8  | CAN transceiver RXD; TIM4 measures its pulses                |
//! | PB9  | CAN transceiver TXD                                          |
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
//! that is too short for 10 kbit/s; for example SN65HVD230.

use super::registers::Register;
use super::stm32f103::{APB1_CLOCK, Port, pac, set_outputs};
use crate::imu::mounting::Mounting;
use plumbline::node::Leds;
use plumbline::update::layout::{self, Layout};

/// The SPI of the accelerometer, its address, and the clock of its bus in Hz.
pub(super) type Spi = pac::SPI2;
pub(super) const SPI_ADDRESS: u32 = 0x4000_3800;
pub(super) const SPI_BUS_CLOCK: u32 = APB1_CLOCK;

/// The direction of the resistor at the output of the accelerometer.
pub(super) const SPI_PULL: Register = Register::new(0x4001_0C0C, 1 << 14, 1 << 14);

/// The bits of its clock in RCC_APB1ENR and RCC_APB2ENR, and SPI_CR1: SPE, SSI, SSM, MSTR, a division by 16.
pub(super) const APB1_PERIPHERALS: u32 = 1 << 14;
pub(super) const APB2_PERIPHERALS: u32 = 0;
pub(super) const SPI_CONTROL: u32 = 0x35C;

/// The modes of the pins: GPIOA_CRL, GPIOB_CRH without TXD, GPIOC_CRL, GPIOC_CRH.
pub(super) const PORTS: [u32; 4] = [0x4424_4444, 0x9891_4208, 0x2244_4440, 0x4444_4444];

/// The parameter memory: the last two pages of the flash.
pub(super) const PARAMETERS: usize = 0x0801_F800;

/// The channel of the converter at the divider of the supply.
pub(super) const SUPPLY_CHANNEL: u32 = 10;

/// The memory with a bootloader.
pub const LAYOUT: Layout = layout::NUCLEO_F103RB;

/// The mounting of the accelerometer.
pub const MOUNTING: Mounting = Mounting::ALIGNED;

/// Enables the clock of the SPI.
pub(super) fn connect_spi(rcc: &pac::RCC) {
    rcc.apb1enr().modify(|_, w| w.spi2en().set_bit());
}

/// Selects the oscillator of the next attempt: first the clock from the ST-LINK (HSEBYP), then the crystal X3, alternately. HSE is off.
pub(super) fn change_oscillator(rcc: &pac::RCC) {
    rcc.cr()
        .modify(|rcc, w| w.hsebyp().bit(rcc.hsebyp().bit_is_clear()));
}

/// Configures the pins that are not the same on all boards. The level of an output is set first.
pub(super) fn set_own_pins(a: &Port, b: &Port, c: &Port) {
    a.crl().write(|w| w.mode5().output2().cnf5().push_pull());
    b.bsrr().write(|w| w.bs12().set_bit().bs14().set_bit());
    // The pins of the accelerometer as on the Blue Pill: slow edges, and a pull-up at its output.
    b.crh().modify(|_, w| {
        w.mode10().output2().cnf10().push_pull();
        w.mode12().output().cnf12().push_pull();
        w.mode13().output().cnf13().alt_push_pull();
        w.mode14().input().cnf14().alt_push_pull();
        w.mode15().output().cnf15().alt_push_pull()
    });
    c.crl().write(|w| {
        w.mode6().output2().cnf6().push_pull();
        w.mode7().output2().cnf7().push_pull()
    });
}

/// Makes the pin of the divider of the supply analog.
pub(super) fn connect_supply() {
    // SAFETY: the main loop is the only code that uses this register.
    let port = unsafe { pac::GPIOC::steal() };
    // For an input, 00 is analog.
    port.crl()
        .modify(|_, w| w.mode0().input().cnf0().push_pull());
}

/// Selects the accelerometer.
pub(super) fn select_imu(selected: bool) {
    // SAFETY: the write changes only PB12, which no other code uses.
    let port = unsafe { pac::GPIOB::steal() };
    set_outputs(&port, 1 << 12, u32::from(!selected) << 12);
}

/// The status LEDs on the board and at its connectors.
pub struct StatusLeds;

impl StatusLeds {
    /// Switches each LED on or off.
    pub fn show(&mut self, leds: Leds) {
        // SAFETY: the writes change only the pins of the LEDs, which no other code uses.
        let (a, b, c) = unsafe {
            (
                pac::GPIOA::steal(),
                pac::GPIOB::steal(),
                pac::GPIOC::steal(),
            )
        };
        set_outputs(&a, 1 << 5, u32::from(leds.run) << 5);
        set_outputs(&b, 1 << 10, u32::from(leds.error) << 10);
        let module = u32::from(leds.module_green) << 6 | u32::from(leds.module_red) << 7;
        set_outputs(&c, 0b11 << 6, module);
    }
}
