//! The commands against every product, in the virtual time of the simulated bus.

mod commands;
mod files;
mod names;
mod rates;
mod refusals;
mod rig;
mod samples;
mod scan;
