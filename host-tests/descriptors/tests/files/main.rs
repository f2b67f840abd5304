//! The data sheets and databases of the products against the rules of their formats and the answers of the sensors.

mod clients;
mod devicenet;
mod eds;
