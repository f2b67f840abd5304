//! A simulated STM32F103C8 that runs the very ELF that is flashed.

pub mod bxcan;
pub mod io;
