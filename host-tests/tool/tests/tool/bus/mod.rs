//! The commands against every product, in the virtual time of the simulated bus.

mod adjust;
mod align;
mod bit_rate;
#[cfg(unix)]
mod calibrate;
mod commands;
mod cyclic;
mod data_sheets;
mod decode;
mod decode_eds;
mod decode_view;
mod doctor;
mod documents;
mod eds_files;
mod every_rate;
mod files;
mod foreign;
mod identity;
mod interrupted;
mod j1939;
mod labels;
mod listen_only;
mod mixed_traffic;
mod names;
mod opening;
mod products;
mod rates;
mod refusals;
mod replaced;
mod replay;
mod restored;
pub mod rig;
mod samples;
mod scan;
mod sending;
mod several;
pub mod talking;
