//! GEMAC IS2D 90 P20, two axes, the older type.
#![no_std]
#![no_main]

use firmware_stm32::app;
use plumbline::fsc::Product;
use plumbline::model::is2d::{self, Is2d};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is2d::PLASTIC;

#[cortex_m_rt::entry]
fn main() -> ! {
    app::run(PRODUCT.image, Is2d::PAYLOAD, |now, boot| {
        Is2d::new(PRODUCT, now, boot)
    })
}
