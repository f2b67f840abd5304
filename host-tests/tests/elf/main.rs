//! The images that are flashed to the Blue Pill, run on the simulated microcontroller: their behaviour on the bus as in the manual.
//! `tests/elf_nucleo` runs the same tests with the images for the Nucleo.

use stm32_sim::chip::Chip;

/// The microcontroller.
const CHIP: Chip = Chip::F103;

/// Tests that only the Blue Pill runs, because they take long and do not depend on the board.
macro_rules! blue_pill_only {
    ($($item:item)*) => { $($item)* };
}

mod rig;

mod accelerometer;
mod boot;
mod can_faults;
mod clock;
mod detection;
mod errors;
mod faults;
mod fusion;
mod halves;
mod ims360;
mod ims360_faults;
mod ims360_j1939;
mod ims360_j1939_address;
mod ims360_j1939_bus_off;
mod jn2101;
mod joining;
mod load;
mod memory;
mod sensing;
mod supply;
mod tiltix;
mod tiltix_network;
mod timing;
mod traces;
mod vibration;
