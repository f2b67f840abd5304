//! The products, one module for each family of a manufacturer: parameters, factory values, limits, LEDs and measurement. The
//! [`catalog`] lists them all.

pub mod catalog;
pub mod dual;
pub mod gemac;
pub mod ims360;
pub mod jn2101;
pub mod listing;
pub mod tiltix;
