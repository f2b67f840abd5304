//! A simulated STM32F103 on a Blue Pill or a Nucleo, or STM32F446 on a Nucleo, that runs the same ELF that is flashed. The
//! [image](elf::Image::board) determines which one.
//!
//! - [`board`]: the boards: flash, pins, clock
//! - [`chip`]: the differences of the two microcontrollers: address map, clock gates, times
//! - [`cortex_m`]: the processor with its memories and interrupt controller; [`bxcan`]: the CAN controller
//! - [`elf`]: the image: segments, symbols, and the part of the project that each byte belongs to
//! - [`image`]: its size; [`firmware`]: builds the images
//! - [`rtt`]: the log of a program, as a probe reads it
//! - [`svd`]: the registers of a chip, as its maker describes them
//! - [`silicon`]: the differences between clones of a microcontroller
//! - [`timebase`] and [`violation`]: shared types
//! - [`io`]: the interface between the processor and the peripherals
//! - [`peripherals`]: all peripherals: address map, clocks, violations
//! - [`rcc`], [`pwr`], [`gpio`], [`afio`], [`flash`], [`spi`], [`adc`], [`timer`], [`capture_timer`], [`iwdg`], [`dbgmcu`],
//!   [`signature`]: one module for each peripheral
//! - [`ism330dhcx`], [`adxl355`]: the accelerometers, one of which is on the SPI
//! - [`microcontroller`]: all of these on the board
//!
//! Registers that differ are in `rcc/layout.rs`, `gpio/f446.rs`, `flash/f103.rs` and `flash/f446.rs`. These parts of the STM32F446 are not
//! modelled, because no image uses them: floating point, CAN2, SYSCFG, DMA, the effect of the voltage scale, over-drive, and flash units of
//! 64 bits. The detectors of the supply are modelled ([`pwr`]).
//!
//! With the cycles of the instructions, the simulator executes at least half as many instructions per second as with one cycle for
//! each instruction (measured: 0.9 for a complete sensor, 0.7 for the processor alone). The example `cycle_speed` measures this
//! ratio; its exit code is 1 below 0.5.
//!
//! RM0008 is the reference manual of the STM32F10x, PM0075 the programming manual of its flash, DS5319 the datasheet of the
//! STM32F103x8 and xB. RM0390 is the reference manual of the STM32F446, PM0214 the programming manual of its processor, DS10693 its
//! datasheet.

pub mod adc;
pub mod adxl355;
pub mod afio;
pub mod board;
pub mod bxcan;
pub mod capture_timer;
pub mod chip;
pub mod cortex_m;
pub mod crc;
pub mod dbgmcu;
pub mod elf;
pub mod firmware;
pub mod flash;
pub mod gpio;
pub mod image;
pub mod image_file;
pub mod io;
pub mod ism330dhcx;
pub mod iwdg;
pub mod microcontroller;
pub mod peripherals;
pub mod pwr;
pub mod rcc;
pub mod rtt;
pub mod signature;
pub mod silicon;
pub mod spi;
pub mod svd;
pub mod timebase;
pub mod timer;
pub mod violation;

pub use microcontroller::Microcontroller;
