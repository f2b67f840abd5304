//! The very image that is flashed, on the simulated microcontroller: what the manual says, on the wire.

mod rig;

mod accelerometer;
mod boot;
mod detection;
mod errors;
mod load;
mod memory;
mod timing;
mod traces;
