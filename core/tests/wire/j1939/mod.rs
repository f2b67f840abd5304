//! J1939, with the IMS360.

mod addresses;
mod bus_off;
mod claim;
mod codes;
mod commanded;
mod cyclic;
mod diagnostics;
mod dictionary;
mod objects;
mod parameters;
mod process_data;
mod requests;
mod standalone;
mod switching;
mod transport;
mod values;
