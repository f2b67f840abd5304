//! GEMAC IS2xx090-C-xL, two axes.
#![no_std]
#![no_main]

use firmware_stm32::app;
use plumbline::fsc::Product;
use plumbline::model::is2::{self, Is2};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is2::BP_CL;

#[cortex_m_rt::entry]
fn main() -> ! {
    app::run(PRODUCT.image, Is2::PAYLOAD, |now, boot| {
        Is2::new(PRODUCT, now, boot)
    })
}
