//! A simulated STM32F103C8 that runs the same ELF that is flashed.
//!
//! - [`cortex_m3`]: the processor with its memories and interrupt controller; [`bxcan`]: the CAN controller
//! - [`elf`]: the image: segments, symbols, and the part of the project that each byte belongs to
//! - [`image`]: its size; [`firmware`]: builds the images
//! - [`io`]: the interface between the processor and the peripherals
//! - [`peripherals`]: all peripherals: address map, clocks, violations
//! - [`rcc`], [`gpio`], [`afio`], [`flash`], [`spi`], [`timer`], [`capture_timer`], [`iwdg`], [`dbgmcu`], [`signature`]: one peripheral each
//! - [`ism330dhcx`]: the accelerometer on the SPI
//! - [`microcontroller`]: all of these on the board; [`profile`]: instructions of functions
//! - [`timebase`] and [`violation`]: shared types
//!
//! RM0008 is the reference manual of the STM32F10x, PM0075 the programming manual of its flash, DS5319 the datasheet of the
//! STM32F103x8.

pub mod afio;
mod board;
pub mod bxcan;
pub mod capture_timer;
pub mod chip;
pub mod cortex_m3;
pub mod dbgmcu;
pub mod elf;
pub mod firmware;
pub mod flash;
pub mod gpio;
pub mod image;
pub mod io;
pub mod ism330dhcx;
pub mod iwdg;
pub mod microcontroller;
pub mod peripherals;
pub mod profile;
pub mod rcc;
pub mod signature;
pub mod spi;
pub mod timebase;
pub mod timer;
pub mod violation;

pub use microcontroller::Microcontroller;
