//! A simulated STM32F103C8 that runs the very ELF that is flashed.

pub mod cortex_m3;
pub mod io;
