//! Everything a PC does with Plumbline's core.

pub mod bench;
pub mod models;
pub mod motion;
