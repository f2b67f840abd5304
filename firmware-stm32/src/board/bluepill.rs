//! Blue Pill: STM32F103C8, 64 KiB flash, 20 KiB RAM, crystal of 8 MHz.
//!
//! | pin  | connected to                                                 |
//! |------|--------------------------------------------------------------|
//! | PB8  | CAN transceiver RXD; TIM4 measures its pulses                |
//! | PB9  | CAN transceiver TXD                                          |
//! | PA4  | ISM330DHCX CS                                                |
//! | PA5  | ISM330DHCX SCL (SPC)                                         |
//! | PA6  | ISM330DHCX SDO                                               |
//! | PA7  | ISM330DHCX SDA (SDI)                                         |
//! | PC13 | run LED: the one on the board, lit when low                  |
//! | PB12 | error LED with its resistor to ground, lit when high         |
//! | PB13 | green module LED with its resistor to ground, lit when high  |
//! | PB14 | red module LED with its resistor to ground, lit when high    |
//! | PB0  | heater switch (a logic-level MOSFET), on when high, PWM      |
//! | PB1  | switch of the 120 ohm terminating resistor, on when high     |
//! | PA0  | supply: divider of 100 k to the supply, 6.8 k to ground      |
//!
//! PB0 and PB1 are for products with a heater or a switched terminating resistor. Each has a resistor to ground, so that both are
//! off while the microcontroller is in reset. The divider is for products that measure their supply.
//!
//! CAN is remapped to PB8 and PB9, because PA12 has the pull-up of the USB socket. The transceiver runs at 3.3 V and must not
//! have a dominant time-out that is too short for 10 kbit/s; for example SN65HVD230.

use super::registers::Register;
use super::stm32f103::{CORE_CLOCK, Port, pac, set_outputs};
use crate::imu::mounting::Mounting;
use plumbline::node::Leds;
use plumbline::update::layout::{self, Layout};

/// The SPI of the accelerometer, its address, and the clock of its bus in Hz.
pub(super) type Spi = pac::SPI1;
pub(super) const SPI_ADDRESS: u32 = 0x4001_3000;
pub(super) const SPI_BUS_CLOCK: u32 = CORE_CLOCK;

/// The direction of the resistor at the output of the accelerometer.
pub(super) const SPI_PULL: Register = Register::new(0x4001_080C, 1 << 6, 1 << 6);

/// The bits of its clock in RCC_APB1ENR and RCC_APB2ENR, and SPI_CR1: SPE, SSI, SSM, MSTR, a division by 32.
pub(super) const APB1_PERIPHERALS: u32 = 0;
pub(super) const APB2_PERIPHERALS: u32 = 1 << 12;
pub(super) const SPI_CONTROL: u32 = 0x364;

/// The modes of the pins: GPIOA_CRL, GPIOB_CRH without TXD, GPIOC_CRL, GPIOC_CRH.
pub(super) const PORTS: [u32; 4] = [0x9891_4440, 0x4333_4408, 0x4444_4444, 0x4424_4444];

/// The parameter memory: the last two pages of the flash.
pub(super) const PARAMETERS: usize = 0x0800_F800;

/// The channel of the converter at the divider of the supply.
pub(super) const SUPPLY_CHANNEL: u32 = 0;

/// The memory with a bootloader.
pub const LAYOUT: Layout = layout::BLUEPILL;

/// The mounting of the accelerometer.
pub const MOUNTING: Mounting = Mounting::ALIGNED;

/// Enables the clock of the SPI.
pub(super) fn connect_spi(rcc: &pac::RCC) {
    rcc.apb2enr().modify(|_, w| w.spi1en().set_bit());
}

/// Selects the oscillator of the next attempt: always the crystal.
pub(super) fn change_oscillator(_: &pac::RCC) {}

/// Configures the pins that are not the same on all boards. The level of an output is set first.
pub(super) fn set_own_pins(a: &Port, b: &Port, c: &Port) {
    a.bsrr().write(|w| w.bs4().set_bit().bs6().set_bit());
    // The accelerometer can be at the end of loose wires. Edges of pins of 50 MHz would ring there. A missing accelerometer reads as FFh,
    // because its line has a pull-up.
    a.crl().write(|w| {
        w.mode4().output().cnf4().push_pull();
        w.mode5().output().cnf5().alt_push_pull();
        w.mode6().input().cnf6().alt_push_pull();
        w.mode7().output().cnf7().alt_push_pull()
    });
    b.crh().modify(|_, w| {
        w.mode12().output50().cnf12().push_pull();
        w.mode13().output50().cnf13().push_pull();
        w.mode14().output50().cnf14().push_pull()
    });
    c.bsrr().write(|w| w.bs13().set_bit());
    // PC13 permits 2 MHz at most (datasheet, output current of PC13 to PC15).
    c.crh().write(|w| w.mode13().output2().cnf13().push_pull());
}

/// Makes the pin of the divider of the supply analog.
pub(super) fn connect_supply() {
    // SAFETY: the main loop is the only code that uses this register.
    let port = unsafe { pac::GPIOA::steal() };
    // For an input, 00 is analog.
    port.crl()
        .modify(|_, w| w.mode0().input().cnf0().push_pull());
}

/// Selects the accelerometer on the SPI, or releases it (chip select PA4).
pub(super) fn select_imu(selected: bool) {
    // SAFETY: the write changes only PA4, which no other code uses.
    let port = unsafe { pac::GPIOA::steal() };
    set_outputs(&port, 1 << 4, u32::from(!selected) << 4);
}

/// The status LEDs at PC13 and port B.
pub struct StatusLeds;

impl StatusLeds {
    /// Switches each LED on or off.
    pub fn show(&mut self, leds: Leds) {
        let levels = u32::from(leds.error) << 12
            | u32::from(leds.module_green) << 13
            | u32::from(leds.module_red) << 14;
        // SAFETY: the writes change only the pins of the LEDs, which no other code uses.
        let (b, c) = unsafe { (pac::GPIOB::steal(), pac::GPIOC::steal()) };
        set_outputs(&b, 0b111 << 12, levels);
        // The LED on the board is lit when its pin is low.
        set_outputs(&c, 1 << 13, u32::from(!leds.run) << 13);
    }
}
