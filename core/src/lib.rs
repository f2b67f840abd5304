//! The core of Plumbline: the firmware of a CAN inclination sensor without hardware access.
//!
//! A board, a test or the virtual sensor drives the core through one trait: [`node::Node`]. Inputs are samples and frames,
//! outputs are frames. The time is an argument of each call. A driver that answers frames at a higher priority uses the two halves of
//! a node ([`node::ProductNode`]).
//!
//! **The path of a sample**: [`measure`] corrects it ([`measure::calibration`]), filters it ([`measure::low_pass`],
//! [`measure::fir`]) and calculates the angles ([`measure::definition`], [`angle`]). The [`application`] of the product checks
//! the angles and adds the zero offset ([`measure::zero`]). [`heater`] controls the temperature of a heated measuring cell.
//!
//! **The path of a frame**: the driver passes a [`can::Frame`] to the [`node::Node`]. The protocol ([`fsc`], [`canopen`],
//! [`devicenet`], [`j1939`]) finds the request in the table of the product ([`model`]) and replies on reception. Bit rate detection, fault
//! confinement, LEDs and the transmit queue are independent of the protocol; they are in [`node`]. [`store`] keeps the parameters
//! and the calibration in nonvolatile memory.
//!
//! ```
//! use plumbline::can::{Frame, standard};
//! use plumbline::measure::{I32x3, ONE_G, Reading};
//! use plumbline::model::gemac::is2::{BP_CL, Is2};
//! use plumbline::node::{Boot, Node};
//! use plumbline::time::Instant;
//!
//! let now = Instant::from_ticks(0);
//! let mut sensor = Is2::new(&BP_CL, now, &Boot::default());
//! let level = I32x3 { x: 0, y: 0, z: ONE_G };
//! sensor.sample(now, &Reading { acceleration: level, ..Reading::default() });
//! // The node detects the bit rate with the first frame on the bus. Then it sends two boot-up messages.
//! sensor.receive(now, &Frame::data(standard(0x7FF), &[]).unwrap());
//! while sensor.poll(now).is_some() {}
//! let boot_up = sensor.transmit(now).unwrap();
//! assert_eq!(boot_up.bytes(), [0xFF, 0x03, 0x00, 0x03, 0x00, 0x00, 0x44, 0x03]);
//! ```
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic
    )
)]

pub mod angle;
pub mod application;
pub mod can;
pub mod canopen;
pub mod devicenet;
pub mod diagnosis;
pub mod fsc;
pub mod heater;
pub mod j1939;
pub mod measure;
mod mistake;
pub mod model;
pub mod node;
pub mod param;
pub mod prelude;
mod project;
pub mod store;
#[cfg(test)]
#[path = "../tests/wire/tester/sweep.rs"]
mod sweep;
pub mod text;
pub mod time;
pub mod update;
mod walk;
