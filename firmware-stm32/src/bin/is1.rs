//! GEMAC IS1xx360-C-xL, one axis.
#![no_std]
#![no_main]

use firmware_stm32::app;
use plumbline::fsc::Product;
use plumbline::model::is1::{self, Is1};

/// The article that this sensor replaces.
const PRODUCT: &Product = &is1::BP_CL;

#[cortex_m_rt::entry]
fn main() -> ! {
    app::run(PRODUCT.image, Is1::PAYLOAD, |now, boot| {
        Is1::new(PRODUCT, now, boot)
    })
}
