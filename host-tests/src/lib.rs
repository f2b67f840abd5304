//! Everything a PC does with Plumbline's core.
