//! Raw CAN with function select codes: IS1 and IS2.

mod angles;
mod any_input;
mod behaviour;
mod codings;
mod cyclic;
mod heating;
mod memory;
mod parameters;
mod products;
mod tables;
mod validity;
