//! The values of the parameters: range checks, factory values, and their bytes in the image in nonvolatile memory.
//!
//! In the image the stored values stand one behind the other in the order of the dictionary, each in the size of its type,
//! little-endian; behind them the model's hidden values of four bytes each.

use super::abort::Abort;
use super::dictionary::{Home, Rule};
use super::{key::Key, wire};
use crate::store::Payload;
use core::ops::Range;

/// The number of slots for values, enough for every model.
pub const SLOTS: usize = 36;

/// The values of all parameters of one sensor, by slot; a signed number is there as its bytes make it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Values([u32; SLOTS]);

impl Values {
    /// These values, by slot.
    pub const fn new(values: [u32; SLOTS]) -> Self {
        Self(values)
    }

    /// The value in a slot.
    pub fn at(&self, slot: u8) -> u32 {
        self.0.get(usize::from(slot)).copied().unwrap_or(0)
    }

    /// The value of the communication profile in `key`.
    pub fn get(&self, key: Key) -> u32 {
        self.at(key as u8)
    }

    /// Sets a slot.
    pub fn set(&mut self, slot: u8, value: u32) {
        if let Some(place) = self.0.get_mut(usize::from(slot)) {
            *place = value;
        }
    }

    /// Takes the values in `slots` over from `other`.
    pub fn copy(&mut self, other: &Self, slots: impl IntoIterator<Item = u8>) {
        for slot in slots {
            self.set(slot, other.at(slot));
        }
    }

    /// Appends the bytes of the stored values and of the `hidden` slots.
    pub fn encode(&self, rules: &[Rule], hidden: Range<u8>, payload: &mut Payload) {
        for rule in rules {
            if let Some(slot) = rule.home.slot().filter(|_| rule.is_stored()) {
                self.append(slot, rule.data_type().size(), payload);
            }
        }
        for slot in hidden {
            self.append(slot, 4, payload);
        }
    }

    /// Appends a value of `size` bytes.
    #[inline(never)]
    fn append(&self, slot: u8, size: u8, payload: &mut Payload) {
        for byte in self.at(slot).to_le_bytes().into_iter().take(size.into()) {
            // There is room: the size is checked where the model is put together.
            let _ = payload.push(byte);
        }
    }

    /// These values, but the stored ones from the bytes of an image; None unless every single one is permitted and nothing is left.
    pub fn decode(&self, rules: &[Rule], hidden: Range<u8>, mut bytes: &[u8]) -> Option<Self> {
        let mut values = *self;
        for rule in rules.iter().filter(|rule| rule.is_stored()) {
            let size = rule.data_type().size();
            let (value, rest) = bytes.split_at_checked(size.into())?;
            let value = number(value, size)?;
            check(rule.home, value).ok()?;
            values.set(rule.home.slot()?, value);
            bytes = rest;
        }
        for slot in hidden {
            let (number, rest) = bytes.split_first_chunk()?;
            values.set(slot, u32::from_le_bytes(*number));
            bytes = rest;
        }
        bytes.is_empty().then_some(values)
    }
}

/// The little-endian number of `size` bytes; None when there are more or fewer.
pub fn number(bytes: &[u8], size: u8) -> Option<u32> {
    if bytes.len() != usize::from(size) {
        return None;
    }
    let digits = bytes.iter().rev();
    Some(digits.fold(0, |number, &byte| number << 8 | u32::from(byte)))
}

/// Whether `value` may be written to a value that lives in `home`.
pub fn check(home: Home, value: u32) -> Result<(), Abort> {
    let permitted = match home {
        Home::Any(_) => true,
        Home::Range(_, low, _) if value < low.into() => return Err(Abort::TooLow),
        Home::Range(_, _, high) if value > high.into() => return Err(Abort::TooHigh),
        Home::Range(..) => true,
        Home::OneOf(_, list) => list.iter().any(|&one| value == one.into()),
        // 241 to 251 are reserved.
        Home::Transmission(_) => !(241..=251).contains(&value),
        // Bit 30 would make the device a producer, bit 29 a 29-bit identifier; bit 31 means nothing.
        Home::SyncId(_) => wire::is_free(value & !(1 << 31)),
        Home::Constant(_) | Home::Text(_) | Home::Live(_) | Home::Measured(_) | Home::Key => false,
    };
    if permitted { Ok(()) } else { Err(Abort::Value) }
}
