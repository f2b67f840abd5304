//! Sensors and adapters on the simulated bus: arbitration, bit rates, errors, faults of the flash, and networks of several nodes.

mod bus;
mod bus_rates;
mod devicenet;
mod devicenet_nodes;
mod faults;
mod flash;
mod j1939;
mod joining;
mod rate_change;
mod sensor;
