//! The EEPROM image and the two slots it lives in.

mod image;
mod slots;

pub use slots::{Loaded, Store};

/// The largest payload of an image in bytes.
pub const PAYLOAD_MAX: usize = 100;

/// The payload of an image: what a model wants kept.
pub type Payload = heapless::Vec<u8, PAYLOAD_MAX>;

/// Names the model and its payload layout, so that another model's image is not taken for one's own.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ImageId(pub u16);

/// An image could not be written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoreError;
