//! The devices on a bus, and the products that each can be.

use super::Named;
use crate::master::Protocol;
use crate::sheet::{Address, Entry, Sheet};
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::{ValueId, number};
use std::rc::Rc;

/// The products that a decoder knows.
#[derive(Clone, Debug)]
pub struct Known {
    sheets: Rc<[Sheet]>,
    /// The user has named the product.
    is_given: bool,
    /// The place of the data sheet of a device that is not in the catalogue.
    described: Option<usize>,
}

impl Known {
    /// All products of a protocol.
    pub(super) fn all(protocol: &Protocol) -> Self {
        let products = PRODUCTS.iter().filter(|product| protocol.is_of(product));
        Self {
            sheets: products.map(Sheet::of).collect(),
            is_given: false,
            described: None,
        }
    }

    /// The product or device with this sheet, which the user has named.
    pub(super) fn given(sheet: Sheet) -> Self {
        Self {
            sheets: [sheet].into(),
            is_given: true,
            described: None,
        }
    }

    /// All products of a protocol, and a device with a data sheet.
    pub(super) fn beside(protocol: &Protocol, sheet: Sheet) -> Self {
        let all = Self::all(protocol);
        let sheets = all.sheets.iter().cloned();
        Self {
            described: Some(all.sheets.len()),
            sheets: sheets.chain([sheet]).collect(),
            ..all
        }
    }

    /// A device that can be each of them. One that tells no other identity is that of the data sheet.
    pub fn device(&self) -> Device {
        let places = 0..self.sheets.len();
        Device {
            known: self.clone(),
            possible: places
                .filter(|place| Some(*place) != self.described)
                .collect(),
            described: self.described,
            is_told: self.is_given,
            resolution: None,
        }
    }

    /// The same products, for devices of which nobody has told that they are one of them.
    pub fn untold(self) -> Self {
        Self {
            is_given: false,
            ..self
        }
    }

    /// The products.
    pub fn products(&self) -> impl Iterator<Item = &'static Product> {
        self.sheets.iter().map(|sheet| sheet.product)
    }
}

/// A device on the bus: the products that it can be.
#[derive(Clone, Debug)]
pub struct Device {
    known: Known,
    possible: Vec<usize>,
    /// The data sheet, if the device has not told another identity.
    described: Option<usize>,
    /// The device or the user has named the product.
    is_told: bool,
    /// The number of the parameter that selects the unit of others, if it was read or written.
    resolution: Option<u32>,
}

impl Device {
    /// Whether its product was told, by itself or by the user, or some of its products.
    pub fn is_told(&self) -> bool {
        self.is_told
    }

    /// Whether it has the data sheet.
    pub fn is_described(&self) -> bool {
        self.described.is_some() && !self.is_told
    }

    /// Whether it is known what its data mean: by its product, or by its data sheet.
    pub fn is_identified(&self) -> bool {
        self.is_told || self.is_described()
    }

    /// The name of the product, if it was told or has the data sheet.
    pub fn product(&self) -> Option<&'static str> {
        match self.places() {
            [only] if self.is_identified() => Some(self.known.sheets[*only].product.name),
            _ => None,
        }
    }

    fn places(&self) -> &[usize] {
        match &self.described {
            Some(own) if !self.is_told => std::slice::from_ref(own),
            _ => &self.possible,
        }
    }

    fn sheets(&self) -> impl Iterator<Item = &Sheet> {
        self.places().iter().map(|place| &self.known.sheets[*place])
    }

    /// The possible products.
    pub fn products(&self) -> impl Iterator<Item = &'static Product> {
        self.sheets().map(|sheet| sheet.product)
    }

    /// The device has told something that only some products have. A device that is none of them stays as it is.
    pub fn keep(&mut self, is: impl Fn(&Product) -> bool) {
        let is = |place: &usize| is(self.known.sheets[*place].product);
        let possible: Vec<usize> = self.possible.iter().copied().filter(is).collect();
        if !possible.is_empty() {
            self.is_told = true;
            self.possible = possible;
        }
    }

    /// The same for a number of the identity: 0 is the vendor, 1 the product code. The data sheet has them too.
    pub fn identify(&mut self, place: usize, told: u32, is: impl Fn(&Product) -> bool) {
        let sheet = self.described.map(|own| &self.known.sheets[own]);
        let data_sheet = sheet.and_then(|sheet| sheet.data_sheet.as_ref());
        match data_sheet.and_then(|own| own.identity[place]) {
            Some(own) if own == told => {
                let sheets = &self.known.sheets;
                self.possible.retain(|place| is(sheets[*place].product));
            }
            Some(_) => {
                self.described = None;
                self.keep(is);
            }
            None => self.keep(is),
        }
    }

    /// What all possible products have that have it, if it is the same.
    pub fn agreed<T: PartialEq>(&self, get: impl Fn(&'static Product) -> Option<T>) -> Option<T> {
        let mut all = self.products().filter_map(get);
        let first = all.next()?;
        all.all(|other| other == first).then_some(first)
    }

    /// The entries at addresses, if they are the same in all possible products that have some.
    pub fn entries(&self, is: impl Fn(Address) -> bool) -> Vec<Entry> {
        let own = |sheet: &Sheet| -> Vec<Entry> {
            let entries = sheet.entries.iter().filter(|entry| is(entry.address));
            entries.map(|entry| self.scaled(sheet, entry)).collect()
        };
        let mut all = self.sheets().map(own).filter(|own| !own.is_empty());
        let Some(first) = all.next() else {
            return Vec::new();
        };
        match all.all(|other| is_same(&first, &other)) {
            true => first,
            false => Vec::new(),
        }
    }

    /// The entry at an address.
    pub fn entry(&self, address: Address) -> Option<Entry> {
        self.entries(|own| own == address).into_iter().next()
    }

    /// The entry of a published value, if it is the same in all possible products.
    pub fn published(&self, id: ValueId) -> Option<Entry> {
        let mut all = self.sheets();
        let first = all.next()?;
        let entry = first.value(id)?;
        let is_own = |sheet: &Sheet| {
            let other = sheet.value(id);
            other.is_some_and(|other| {
                is_same(std::slice::from_ref(entry), std::slice::from_ref(other))
            })
        };
        all.all(is_own).then(|| self.scaled(first, entry))
    }

    /// An entry with the unit in force.
    fn scaled(&self, sheet: &Sheet, entry: &Entry) -> Entry {
        let mut entry = entry.clone();
        let own = sheet.product.guide.resolution;
        let own = own.and_then(|resolution| sheet.parameter(resolution.parameter));
        if let (Some(own), Some(raw)) = (own, self.resolution)
            && sheet.follows_resolution(&entry)
        {
            entry.scale = own.scale.times(raw);
        }
        entry
    }

    /// The value of an entry that was read, written or sent. A unit that it selects is in force from now on.
    pub fn value(&mut self, entry: &Entry, bytes: &[u8]) -> Named {
        let is_resolution = self.sheets().any(|sheet| sheet.is_resolution(entry));
        if is_resolution && bytes.len() == usize::from(entry.data_type.size()) {
            self.resolution = Some(number(bytes));
        }
        Named::of(entry, bytes)
    }
}

/// Whether entries of two products are shown alike.
fn is_same(one: &[Entry], other: &[Entry]) -> bool {
    let is_same = |(one, other): (&Entry, &Entry)| {
        (&one.name, one.address, one.data_type, &one.scale, one.form)
            == (
                &other.name,
                other.address,
                other.data_type,
                &other.scale,
                other.form,
            )
            && one.meanings == other.meanings
    };
    one.len() == other.len() && one.iter().zip(other).all(is_same)
}
