//! GEMAC IS1D 00 P20, one axis, the older type.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Product;
use plumbline::model::is1d::{self, Is1d};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is1d::PLASTIC;

firmware_stm32::firmware!(Is1d, PRODUCT);
