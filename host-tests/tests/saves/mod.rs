//! What the tests of the store share: payloads, saves, and what a device would find.
#![allow(dead_code, reason = "not every test uses everything")]

use bench::{Flash, PAGE_SIZE};
use plumbline::store::{ImageId, Loaded, Store, StoreError};

pub const ID: ImageId = ImageId(0x1234);

/// A payload of this size makes images of 76 bytes.
pub const PAYLOAD: usize = 60;
pub const IMAGE: usize = 76;

/// So many of them fit a page.
pub const PLACES: usize = PAGE_SIZE / IMAGE;

/// The payload of save `number`; no two of them have a byte in common at the same place, so that a mix shows.
pub fn payload(number: usize) -> [u8; PAYLOAD] {
    std::array::from_fn(|index| (number as u8).wrapping_mul(3) ^ index as u8)
}

/// Power-up: looks for images and erases ahead.
pub fn boot(flash: Flash) -> Store<Flash> {
    let mut store = Store::open(flash, ID, PAYLOAD).0;
    store.prepare();
    store
}

/// What a device would find that lost its power now; the memory is left alone.
pub fn found(flash: &Flash) -> Loaded {
    Store::open(copy(flash), ID, PAYLOAD).1
}

/// Another memory with the same content.
pub fn copy(flash: &Flash) -> Flash {
    Flash::new(flash.bytes().to_vec())
}

/// The image of save `number`, or none, and whether something newer is damaged.
pub fn loaded(number: Option<usize>, damaged: bool) -> Loaded {
    Loaded {
        payload: number.map(|number| payload(number).as_slice().try_into().unwrap()),
        damaged,
    }
}

pub fn finish(store: &mut Store<Flash>) -> Result<(), StoreError> {
    // An erase, the image in steps of four bytes, the verification, with some to spare.
    for _ in 0..IMAGE / 4 + 5 {
        if let Some(result) = store.step() {
            assert!(!store.busy());
            return result;
        }
        assert!(store.busy());
    }
    panic!("the save does not come to an end");
}

pub fn save(store: &mut Store<Flash>, number: usize) -> Result<(), StoreError> {
    store.save(&payload(number));
    finish(store)
}
