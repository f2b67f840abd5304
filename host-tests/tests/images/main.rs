//! The images that are flashed, run on the simulated microcontroller: the behaviour that depends on the chip, and the recorded traces. The
//! tests run with the images for the Blue Pill, on the worst silicon with the name of its microcontroller. `nucleo.rs` lists those that
//! also run with the images for the Nucleo-F446RE, `nucleo_f103.rs` those for the Nucleo-F103RB, `genuine.rs` those that also run on a
//! microcontroller of ST.

mod rig;

/// Tests that also run on another board or silicon.
macro_rules! also {
    ($on:path; $($module:ident: $($test:ident),+;)+) => {
        $(mod $module {
            $(#[test]
            #[ignore = "another board or other silicon: `.ci/long ignored`"]
            fn $test() {
                $on(crate::$module::$test);
            })+
        })+
    };
}

mod genuine;
mod nucleo;
mod nucleo_f103;

mod accelerometer;
mod accelerometer_faults;
mod accelerometer_line;
mod adxl355;
mod boot;
mod bootloader;
mod can_faults;
mod clock;
mod delay;
mod detection;
mod disturbed;
mod errors;
mod faults;
mod fusion;
mod halves;
mod healing;
mod ims360;
mod ims360_faults;
mod ims360_j1939;
mod ims360_j1939_address;
mod ims360_j1939_bus_off;
mod invalid;
mod jn2101;
mod joining;
mod load;
mod memory;
mod memory_sizes;
mod probe;
mod ram;
mod sensing;
mod supply;
mod tiltix;
mod tiltix_network;
mod timing;
#[cfg(target_os = "linux")]
mod traces;
mod two_nodes;
mod unit;
mod vibration;
mod warm_up;
