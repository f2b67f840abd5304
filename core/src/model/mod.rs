//! The products that are replaced, one file each: parameters, factory values, limits, LEDs, and what they are composed of.

mod gemac;
mod gemac_reference;
pub mod is1;
pub mod is1d;
pub mod is1tk;
pub mod is2;
pub mod is2d;
pub mod is2tk;
pub mod jn2101;
