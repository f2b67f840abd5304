//! GEMAC inclination sensors: function select codes on raw CAN, one or two axes, with or without a heated measuring cell.
//!
#![doc = include_str!("README.md")]

pub mod application;
pub mod functions;
mod heated;
pub mod is1;
pub mod is1d;
pub mod is1dm;
pub mod is1tk;
pub mod is2;
pub mod is2d;
pub mod is2dm;
pub mod is2tk;
pub mod parameters;

/// The maker, as the descriptors print it.
const MAKER: &str = "GEMAC";
