//! Plumbline's core.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic
    )
)]

pub mod angle;
pub mod can;
pub mod measure;
pub mod node;
pub mod store;
pub mod time;
