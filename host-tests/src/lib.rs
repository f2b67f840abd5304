//! Everything a PC does with Plumbline's core.

pub mod motion;
pub mod scene;
pub mod slcan;
