//! The products that are replaced, one room for each maker's family: parameters, factory values, limits, LEDs, measurement; and the
//! [`catalog`] of all of them.

pub mod catalog;
pub mod gemac;
pub mod jn2101;
pub mod listing;
