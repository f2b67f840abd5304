//! The image that is flashed, run on the simulated microcontroller: its behaviour on the bus as in the manual.

mod rig;

mod accelerometer;
mod boot;
mod can_faults;
mod clock;
mod detection;
mod errors;
mod faults;
mod joining;
mod load;
mod memory;
mod supply;
mod timing;
mod traces;
mod vibration;
