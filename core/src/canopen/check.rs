//! Checks that the description of a product is consistent. The compiler evaluates the checks where the tables are written. A mistake is a
//! compile error that names the row:
//!
//! - the objects that each device has ([`profile::standard`](super::profile::standard)) exist; those that the protocol uses have the
//!   types of CiA 301;
//! - sub-index 0 of an object of CiA 301 is the highest sub-index;
//! - node-ID and bit rate are parameters of the table, and each permitted bit rate has a code;
//! - the values of the application have room for its quantities;
//! - the numbers of TPDOs and of errors in the history are those of the dictionary, and each TPDO has both of its objects;
//! - mapped objects exist, can be mapped, have the mapped length, and fit into a frame;
//! - constant texts, and the names of a unit that replace them, fit into the buffer, which has at most 255 bytes;
//! - each own object has its functions, which return its type;
//! - with LSS: the identity object has its four numbers, and the node-ID 255 is permitted;
//! - with block transfer: the buffer for texts takes each number;
//! - the default COB-ID of the SYNC is permitted, and those of the TPDOs and of the EMCY are above 080h with each node-ID;
//! - each sub-index of 1010h and 1011h has a group of parameters;
//! - the hidden parameters of a product with a stored request exist and are stored.
#![allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only

mod identifiers;
mod pdo;

use super::consumer::Consumers;
use super::dictionary::{Object, Service, Target, object_at};
use super::emcy::History;
use super::feature::Feature;
use super::lss::UNCONFIGURED;
use super::own::Read;
use super::pdo::Tpdos;
use super::product::{Kept, Product, TableOf, ValuesOf};
use super::ranges::indices;
use super::sdo::Buffer;
use super::wide::has_wide;
use crate::application::{Application, Values};
use crate::mistake::Mistake;
use crate::param::{DataType, Parameter, ParameterId, Permitted, Persistence, Quantity, Table};
use crate::store::unit::NAME;

/// Checks the tables of a product.
#[track_caller]
pub const fn check<P: Product>() {
    let parameters = <TableOf<P> as Table>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    check_quantities(quantities, <ValuesOf<P> as Values>::CAPACITY);
    check_references(P::OBJECTS, parameters, quantities);
    check_profile(P::OBJECTS, parameters, quantities);
    check_highest(P::OBJECTS);
    pdo::check_tpdos::<P::Tpdos>(P::OBJECTS, parameters, quantities);
    check_consumers(P::OBJECTS, <P::Consumers as Consumers>::COUNT);
    check_texts(P::OBJECTS, P::Text::CAPACITY);
    check_history(P::OBJECTS, P::History::CAPACITY);
    identifiers::check(P::OBJECTS, parameters);
    identifiers::check_node_id(parameters, P::NODE_ID, P::Lss::PRESENT);
    identifiers::check_bit_rate(parameters, P::BIT_RATE, P::BIT_RATES);
    Mistake::in_item("Text").unless(
        P::Text::CAPACITY >= 4 || !P::Block::PRESENT,
        "block transfer needs a buffer for texts with at least 4 bytes",
    );
    check_own::<P>();
    Mistake::in_item("Text").unless(
        P::WRITABLE >= 8 || !has_wide(P::OBJECTS, parameters, quantities),
        "an object of 64 bits needs a buffer for texts with at least 8 bytes",
    );
    if P::Lss::PRESENT {
        check_lss(P::OBJECTS);
    }
    match P::KEPT {
        Some(kept) => check_kept(parameters, kept, P::History::CAPACITY),
        None => check_groups(P::OBJECTS, P::GROUPS),
    }
}

/// Checks that the id of each quantity is its index, and that the published values have room for all of them.
#[track_caller]
const fn check_quantities(quantities: &[Quantity], capacity: usize) {
    let mut row = 0;
    while row < quantities.len() {
        Mistake::in_row("quantity", row).unless(
            quantities[row].id.0 as usize == row,
            "the id of a quantity must be its index",
        );
        Mistake::in_row("quantity", row).unless(
            row < capacity,
            "the application publishes fewer values: `Values` has no room for it",
        );
        row += 1;
    }
}

/// Checks that each own object of the dictionary has its functions.
#[track_caller]
const fn check_own<P: Product>() {
    let (mut place, mut row) = (0, 0);
    while row < P::OBJECTS.len() {
        let object = &P::OBJECTS[row];
        if let Target::Own(_) = object.target {
            let mistake = Mistake::in_object(object.index, object.sub);
            mistake.unless(
                place < P::OWN.len()
                    && P::OWN[place].index == object.index
                    && P::OWN[place].sub == object.sub,
                "`OWN` has no functions for this object, or they are not in the order of the dictionary",
            );
            let is_right = match P::OWN[place].read {
                Read::No => !object.access.is_readable(),
                Read::Number(_) => object.data_type.size() > 0,
                Read::Text(_) => object.data_type.size() == 0,
            };
            mistake.unless(is_right, "its function returns another type");
            place += 1;
        }
        row += 1;
    }
    if place < P::OWN.len() {
        let own = &P::OWN[place];
        Mistake::in_object(own.index, own.sub)
            .text("the dictionary does not have this own object")
            .fail();
    }
}

/// Checks that the parameters and values of the objects exist.
#[track_caller]
const fn check_references(objects: &[Object], parameters: &[Parameter], quantities: &[Quantity]) {
    let mut row = 0;
    while row < objects.len() {
        let Object { index, sub, .. } = objects[row];
        let (parameter, value) = match objects[row].target {
            Target::Parameter(id) | Target::CobId(id) | Target::FreeCobId(id) => (Some(id), None),
            Target::Command(id, value) => (Some(id), Some(value)),
            Target::Value(id) => (None, Some(id)),
            _ => (None, None),
        };
        if let Some(ParameterId(id)) = parameter
            && id as usize >= parameters.len()
        {
            Mistake::in_object(index, sub)
                .text("the table has no parameter ")
                .number(id as u32)
                .fail();
        }
        if let Some(id) = value
            && id.0 as usize >= quantities.len()
        {
            Mistake::in_object(index, sub)
                .text("the application has no quantity ")
                .number(id.0 as u32)
                .fail();
        }
        row += 1;
    }
}

/// The objects of CiA 301 that the protocol uses: their data types, and whether they are mandatory.
const PROFILE: [(u16, u8, DataType, bool); 12] = [
    (0x1000, 0, DataType::U32, true),
    (0x1001, 0, DataType::U8, true),
    (0x1005, 0, DataType::U32, false),
    (0x100C, 0, DataType::U16, false),
    (0x100D, 0, DataType::U8, false),
    (0x1014, 0, DataType::U32, false),
    (0x1015, 0, DataType::U16, false),
    (0x1017, 0, DataType::U16, false),
    (0x1018, 0, DataType::U8, true),
    (0x1018, 1, DataType::U32, true),
    (0x1029, 1, DataType::U8, false),
    (0x1F80, 0, DataType::U32, false),
];

/// Checks the presence and the type of the objects of CiA 301.
#[track_caller]
const fn check_profile(objects: &[Object], parameters: &[Parameter], quantities: &[Quantity]) {
    let mut row = 0;
    while row < PROFILE.len() {
        let (index, sub, data_type, mandatory) = PROFILE[row];
        match object_at(objects, index, sub) {
            Some(object) => {
                Mistake::in_object(index, sub).unless(
                    object.data_type(parameters, quantities) as u8 == data_type as u8,
                    "CiA 301 defines another data type for this object",
                );
                let is_setting = matches!(
                    object.target,
                    Target::Parameter(_)
                        | Target::CobId(_)
                        | Target::FreeCobId(_)
                        | Target::Constant(_)
                );
                Mistake::in_object(index, sub).unless(
                    is_setting || index == 0x1001,
                    "the protocol needs a parameter or a constant here",
                );
            }
            None => Mistake::in_object(index, sub)
                .unless(!mandatory, "this object is mandatory in CiA 301"),
        }
        row += 1;
    }
}

/// Checks that a constant at sub-index 0 of an object of CiA 301 is the highest sub-index. Manufacturer-specific objects (from 2000h) are
/// not checked.
#[track_caller]
const fn check_highest(objects: &[Object]) {
    let mut row = 0;
    while row + 1 < objects.len() {
        let Object { index, sub, .. } = objects[row];
        let mut last = row;
        while last + 1 < objects.len() && objects[last + 1].index == index {
            last += 1;
        }
        let highest = objects[last].sub as u32 + objects[last].count as u32 - 1;
        if let Target::Constant(number) = objects[row].target
            && sub == 0
            && last > row
            && index < 0x2000
            && number != highest
        {
            Mistake::in_object(index, 0)
                .text("the highest sub-index is ")
                .number(highest)
                .text(", not ")
                .number(number)
                .fail();
        }
        row = last + 1;
    }
}

/// Checks that each entry of the heartbeat consumer is a parameter, and that the dictionary has as many entries as the product.
#[track_caller]
const fn check_consumers(objects: &[Object], count: usize) {
    let mut sub = 1;
    while sub <= count + 1 && sub < 256 {
        let entry = object_at(objects, 0x1016, sub as u8);
        Mistake::in_object(0x1016, sub as u8).unless(
            entry.is_some() == (sub <= count),
            "the number of entries is not that of `Consumers`",
        );
        if let Some(entry) = entry {
            Mistake::in_object(0x1016, sub as u8).unless(
                matches!(entry.target, Target::Parameter(_)),
                "an entry of the heartbeat consumer is a parameter",
            );
        }
        sub += 1;
    }
}

#[track_caller]
const fn check_texts(objects: &[Object], text: usize) {
    Mistake::in_item("Text").unless(
        text <= u8::MAX as usize,
        "the buffer for texts has more than 255 bytes",
    );
    let mut row = 0;
    while row < objects.len() {
        let Object { index, sub, .. } = objects[row];
        if let Target::Text(constant) = objects[row].target {
            Mistake::in_object(index, sub)
                .unless(constant.len() <= text, "the text is longer than its buffer");
            Mistake::in_object(index, sub).unless(
                text >= NAME || !super::objects::is_name(index),
                "the name of a unit is longer than the buffer",
            );
        }
        row += 1;
    }
}

#[track_caller]
const fn check_history(objects: &[Object], capacity: usize) {
    if let Some(errors) = object_at(objects, 0x1003, 1)
        && matches!(errors.target, Target::Service(Service::ErrorHistory))
        && errors.count as usize != capacity
    {
        Mistake::in_object(0x1003, 1)
            .text("the dictionary has ")
            .number(errors.count as u32)
            .text(" errors, the capacity of the error history is ")
            .number(capacity as u32)
            .fail();
    }
}

#[track_caller]
const fn check_lss(objects: &[Object]) {
    let mut sub = 1;
    while sub <= 4 {
        Mistake::in_object(0x1018, sub).unless(
            object_at(objects, 0x1018, sub).is_some(),
            "a product with LSS needs all numbers of the identity object",
        );
        sub += 1;
    }
}

/// Checks that a group of parameters exists for each sub-index of 1010h and 1011h that stores or restores a group.
#[track_caller]
const fn check_groups(objects: &[Object], groups: &[(u16, u16)]) {
    let mut row = 0;
    while row < objects.len() {
        let Object { index, sub, .. } = objects[row];
        if let Target::Service(Service::StoreGroup | Service::RestoreGroup) = objects[row].target {
            let is_group = sub == 1 || indices(groups, sub).is_some();
            Mistake::in_object(index, sub).unless(
                matches!(index, 0x1010 | 0x1011) && is_group,
                "there is no group of parameters for this sub-index",
            );
            Mistake::in_object(index, 1).unless(
                object_at(objects, index, 1).is_some(),
                "an object with groups has sub-index 1, all parameters",
            );
        }
        row += 1;
    }
    row = 0;
    while row < groups.len() {
        let (first, last) = groups[row];
        Mistake::in_row("GROUPS", row).unless(
            first <= last && first >= 0x2000 && last < 0x6000,
            "a manufacturer-specific index is 2000h to 5FFFh",
        );
        row += 1;
    }
}

/// Checks the hidden parameters of a product with groups.
#[track_caller]
const fn check_kept(parameters: &[Parameter], kept: Kept, history: usize) {
    check_hidden(parameters, kept.request, DataType::U8);
    let mut place = 0;
    while place < history {
        let ParameterId(first) = kept.history;
        check_hidden(
            parameters,
            ParameterId(first.wrapping_add(place as u8)),
            DataType::U16,
        );
        place += 1;
    }
}

#[track_caller]
const fn check_hidden(parameters: &[Parameter], id: ParameterId, data_type: DataType) {
    let parameter = parameter(parameters, id, "KEPT");
    Mistake::in_parameter(id.0 as usize, parameter.name).unless(
        parameter.data_type as u8 == data_type as u8
            && parameter.persistence as u8 == Persistence::OnSave as u8
            && parameter.factory == 0
            && matches!(parameter.permitted, Permitted::Any),
        "a hidden parameter is stored on save, permits all numbers and has the factory value 0; the request has 8 bits, an error 16",
    );
}

/// The parameter with this id, which an item of the product names.
#[track_caller]
const fn parameter<'a>(parameters: &'a [Parameter], id: ParameterId, item: &str) -> &'a Parameter {
    if id.0 as usize >= parameters.len() {
        Mistake::in_item(item)
            .text("the table has no parameter ")
            .number(id.0 as u32)
            .fail();
    }
    &parameters[id.0 as usize]
}

#[cfg(test)]
mod tests;
