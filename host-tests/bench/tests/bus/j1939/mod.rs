//! IMS360 in J1939 on the simulated wire: nodes that contend for addresses, transfers that end with the address, bus-off, load.

mod contention;
mod faults;
mod load;
mod network;
mod transport;
