//! IS2TK090-C-RL: the 2-axis type of the reference line. It speaks as [IS2](super::is2) does and measures in its range; its measuring
//! cell is heated.

use crate::fsc::{self, Product};
use crate::store::ImageId;

/// The model: tables and measurement of two axes, and the heater.
pub type TwoAxes = super::gemac_reference::Heated<super::is2::TwoAxes>;

/// The sensor.
pub type Is2tk = fsc::Sensor<TwoAxes>;

/// Metal housing (PR-23024-30).
pub static METAL: Product = Product {
    name: "IS2TK090-C-RL",
    article: 2_302_430,
    image: ImageId(0x4722),
    ..super::is2::CLASSIC
};
