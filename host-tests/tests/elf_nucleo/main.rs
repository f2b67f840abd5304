//! The tests of `tests/elf` with the images that are flashed to the Nucleo. Those that take long and do not depend on the board are
//! left out.

#![allow(
    dead_code,
    unused_imports,
    reason = "only the tests that are left out use it"
)]

use stm32_sim::chip::Chip;

/// The microcontroller.
const CHIP: Chip = Chip::F446;

/// Tests that only the Blue Pill runs.
macro_rules! blue_pill_only {
    ($($item:item)*) => {};
}

#[path = "../elf/rig.rs"]
mod rig;

#[path = "../elf/accelerometer.rs"]
mod accelerometer;
#[path = "../elf/boot.rs"]
mod boot;
#[path = "../elf/can_faults.rs"]
mod can_faults;
#[path = "../elf/clock.rs"]
mod clock;
#[path = "../elf/detection.rs"]
mod detection;
#[path = "../elf/errors.rs"]
mod errors;
#[path = "../elf/faults.rs"]
mod faults;
#[path = "../elf/fusion.rs"]
mod fusion;
#[path = "../elf/halves.rs"]
mod halves;
#[path = "../elf/ims360.rs"]
mod ims360;
#[path = "../elf/ims360_faults.rs"]
mod ims360_faults;
#[path = "../elf/ims360_j1939.rs"]
mod ims360_j1939;
#[path = "../elf/ims360_j1939_address.rs"]
mod ims360_j1939_address;
#[path = "../elf/ims360_j1939_bus_off.rs"]
mod ims360_j1939_bus_off;
#[path = "../elf/jn2101.rs"]
mod jn2101;
#[path = "../elf/load.rs"]
mod load;
#[path = "../elf/memory.rs"]
mod memory;
#[path = "../elf/sensing.rs"]
mod sensing;
#[path = "../elf/supply.rs"]
mod supply;
#[path = "../elf/tiltix.rs"]
mod tiltix;
#[path = "../elf/tiltix_network.rs"]
mod tiltix_network;
#[path = "../elf/timing.rs"]
mod timing;
#[path = "../elf/traces.rs"]
mod traces;
#[path = "../elf/vibration.rs"]
mod vibration;
