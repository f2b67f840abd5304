//! GEMAC IS1TK360-C-RL, one axis, with a heated measuring cell.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Product;
use plumbline::model::is1tk::{self, Is1tk};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is1tk::METAL;

firmware_stm32::firmware!(Is1tk, PRODUCT);
