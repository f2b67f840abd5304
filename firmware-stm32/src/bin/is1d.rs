//! GEMAC IS1D 00 P20, one axis, the older type.
#![no_std]
#![no_main]

use firmware_stm32::app;
use plumbline::fsc::Product;
use plumbline::model::is1d::{self, Is1d};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is1d::PLASTIC;

#[cortex_m_rt::entry]
fn main() -> ! {
    app::run(PRODUCT.image, Is1d::PAYLOAD, |now, boot| {
        Is1d::new(PRODUCT, now, boot)
    })
}
