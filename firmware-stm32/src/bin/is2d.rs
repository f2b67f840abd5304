//! IS2D on the board.
#![no_std]
#![no_main]

use firmware_stm32::{app, dummy};

#[cortex_m_rt::entry]
fn main() -> ! {
    app::run(dummy::IMAGE, dummy::PAYLOAD, dummy::Dummy::new)
}
