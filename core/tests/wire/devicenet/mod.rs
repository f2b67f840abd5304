//! DeviceNet, with the products of the TILTIX family.

mod acknowledge;
mod any_input;
mod examples;
mod explicit;
mod fragments;
mod ignored;
mod io;
mod leds;
mod mac_ids;
mod network;
mod objects;
mod port;
mod production;
mod sweeps;
mod tiltix;
mod tiltix_scaling;
mod tiltix_settings;
mod timeouts;
