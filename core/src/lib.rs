//! Plumbline's core: everything in a CAN inclination sensor that is not a register.
//!
//! A sample comes in, a frame goes out. A frame comes in, a frame goes out. Time is an argument. That is the whole program, and
//! whoever drives it, a board, a test or the virtual sensor, does it through one face: [`node::Node`].
//!
//! **The path of a sample**: [`measure`] corrects it ([`measure::calibration`]), filters it ([`measure::low_pass`],
//! [`measure::fir`]) and turns it into angles ([`measure::definition`], [`angle`]); the model judges them and adds the zero offset
//! ([`measure::zero`]). Where the measuring cell is kept warm, [`heater`] does it.
//!
//! **The path of a frame**: the driver hands a [`can::Frame`] to the [`node::Node`]; the protocol ([`fsc`], [`canopen`]) finds
//! out what it means in the model's table ([`model`]) and answers it on the spot. What the bus does meanwhile, bit rate detection, fault
//! states, LEDs and the transmit queue, is the business of [`node`], whatever the protocol. What must outlast a power cut goes
//! through [`store`].
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
//! // Any frame on the bus reveals the bit rate, and two boot-up messages answer it.
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
pub mod fsc;
pub mod heater;
pub mod measure;
pub mod model;
pub mod node;
pub mod param;
pub mod prelude;
pub mod store;
pub mod time;
