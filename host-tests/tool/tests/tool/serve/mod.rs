//! The server of the page over TCP, without a browser.

mod adapter;
mod align;
pub mod api;
mod calibrate;
pub mod client;
mod cyclic;
pub mod data_sheets;
mod documents;
mod fast_bus;
mod files;
pub mod foreign;
mod frames;
mod guard;
mod hooked;
mod identity;
mod j1939;
mod owner;
mod plugged;
mod scan;
mod stand_in;
mod stream;
mod texts;
mod transmit;
mod unsaved;
mod update;
mod which;
