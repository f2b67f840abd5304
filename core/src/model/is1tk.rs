//! IS1TK360-C-RL: the 1-axis type of the reference line. It speaks as [IS1](super::is1) does and measures in its range; its measuring
//! cell is heated.

use crate::fsc::{self, Product};
use crate::store::ImageId;

/// The model: tables and measurement of one axis, and the heater.
pub type OneAxis = super::gemac_reference::Heated<super::is1::OneAxis>;

/// The sensor.
pub type Is1tk = fsc::Sensor<OneAxis>;

/// Metal housing (PR-23020-30).
pub static METAL: Product = Product {
    name: "IS1TK360-C-RL",
    article: 2_302_030,
    image: ImageId(0x4721),
    ..super::is1::CLASSIC
};
