//! The complete sensor built for the PC: its store with power cuts, its measuring path against reference numbers, random input, the
//! recorded traces, and the documents of the products.

mod any_input;
mod bit_rate;
mod delay;
mod devicenet_saves;
mod documents;
mod examples;
mod fastscan;
mod fusion;
mod measure;
mod own_j1939_sensor;
mod plots;
mod recipes;
mod rise_time;
mod saves;
mod saves_without_erased_page;
mod store;
mod store_faults;
mod store_records;
mod store_units;
mod store_usage;
mod trace_runner;
mod traces;
mod usage;
mod vibration;
mod warm_up;
