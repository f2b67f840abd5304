//! Everything a PC does with Plumbline's core.

pub mod bench;
pub mod descriptors;
pub mod fuzz;
pub mod image;
pub mod models;
pub mod motion;
pub mod scene;
pub mod server;
pub mod slcan;
pub mod virtual_sensor;
