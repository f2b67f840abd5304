//! GEMAC IS2D 90 P20, two axes, the older type.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Product;
use plumbline::model::is2d::{self, Is2d};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is2d::PLASTIC;

firmware_stm32::firmware!(Is2d, PRODUCT);
