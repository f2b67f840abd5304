//! Products outside of the crate whose rows have functions of their own. Those of CANopen objects are in `tester/gauge.rs` and
//! `tester/mapped.rs`, that of a function select code in `one_application.rs`.

mod devicenet;
mod j1939;
