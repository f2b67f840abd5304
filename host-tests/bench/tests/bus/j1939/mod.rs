//! IMS360 in J1939 on the simulated wire: nodes that contend for addresses, transfers that end with the address, bus-off.

mod contention;
mod faults;
mod network;
mod transport;
