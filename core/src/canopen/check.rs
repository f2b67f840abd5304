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
//! - constant texts are printable ASCII and not empty; they, and the names of a unit that replace them, fit into the buffer, which has at most 255 bytes;
//! - each object has a name and an index of CiA 301, and one with sub-indices has sub-index 0;
//! - each own object has its functions, which return its type; the limits of a command fit its type;
//! - with LSS: the identity object has its four numbers, the node-ID 255 is permitted, node-ID and bit rate are stored, and the tables of
//!   bit rates have selectors of the manufacturer;
//! - with block transfer: the buffer for texts takes each number;
//! - the default COB-ID of the SYNC is permitted; those of the TPDOs and of the EMCY contain no node-ID, and are free with each node-ID;
//! - each bit rate of the manufacturer's tables of LSS is one of the product;
//! - each sub-index of 1010h and 1011h has a group of parameters, the groups do not overlap, and each stored parameter is in one;
//! - each quantity has an object.

mod faults;
mod groups;
mod identifiers;
mod pdo;

use super::consumer::Consumers;
use super::dictionary::{Object, Service, Target, Use, mistake_at, object_at};
use super::emcy::History;
use super::feature::Feature;
use super::lss::{LssTable, UNCONFIGURED};
use super::own::Read;
use super::pdo::Tpdos;
use super::product::{Product, TableOf, ValuesOf};
use super::sdo::Buffer;
use super::wide::has_wide;
use crate::application::{Application, Values};
use crate::mistake::Mistake;
use crate::param::projection::{check_quantities, exists, has_quantity};
use crate::param::{DataType, Parameter, ParameterId, Quantity, Table};
use crate::store::unit::NAME;
use crate::walk::{at, each};

/// Checks the tables of a product.
#[track_caller]
pub const fn check<P: Product>() {
    let parameters = <TableOf<P> as Table>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    check_quantities(quantities, <ValuesOf<P> as Values>::CAPACITY);
    check_references(P::OBJECTS, parameters, quantities);
    check_profile(P::OBJECTS, parameters, quantities);
    check_highest(P::OBJECTS);
    check_names(P::OBJECTS, parameters, quantities);
    pdo::check_tpdos::<P::Tpdos>(P::OBJECTS, parameters, quantities);
    check_consumers(P::OBJECTS, <P::Consumers as Consumers>::COUNT);
    check_texts(P::OBJECTS, P::Text::CAPACITY);
    check_history(P::OBJECTS, P::History::CAPACITY);
    identifiers::check(P::OBJECTS, parameters);
    identifiers::check_node_id(parameters, P::NODE_ID, P::Lss::PRESENT);
    identifiers::check_bit_rate(parameters, P::BIT_RATE, P::BIT_RATES);
    Mistake::item("Text").unless(
        P::Text::CAPACITY >= 4 || !P::Block::PRESENT,
        "block transfer needs a buffer for texts with at least 4 bytes",
    );
    check_own::<P>();
    Mistake::item("WRITABLE").unless(
        P::WRITABLE <= P::Text::CAPACITY,
        "the buffer for texts is shorter",
    );
    Mistake::item("Text").unless(
        P::WRITABLE >= 8 || !has_wide(P::OBJECTS, parameters, quantities),
        "an object of 64 bits needs a buffer for texts with at least 8 bytes",
    );
    if P::Lss::PRESENT {
        check_lss(P::OBJECTS);
        identifiers::check_stored(at(parameters, P::BIT_RATE.0 as usize), true);
    }
    check_lss_tables(P::LSS_TABLES, P::Lss::PRESENT);
    let bit_rate = at(parameters, P::BIT_RATE.0 as usize);
    identifiers::check_lss_rates(P::LSS_TABLES, P::BIT_RATES, bit_rate);
    groups::check(P::OBJECTS, P::GROUPS, parameters);
    check_values(P::OBJECTS, quantities, P::HOSTED.is_some());
    faults::check(&P::FAULTS, P::EVENTS);
}

/// Checks that each own object of the dictionary has its functions.
#[track_caller]
const fn check_own<P: Product>() {
    let mut rest = P::OWN;
    each!(object in P::OBJECTS => {
        if let Target::Own(_) = object.target {
            let mistake = object.mistake();
            let text = "`OWN` has no functions for this object, or they are not in the order of the dictionary";
            let [own, others @ ..] = rest else {
                mistake.text(text).fail();
            };
            mistake.unless(own.index == object.index && own.sub == object.sub, text);
            mistake.unless(
                matches!(own.read, Read::No) != object.access.is_readable(),
                "the access does not match its functions: `Own::number` or `Own::text` for an object that can be read",
            );
            let is_right = match own.read {
                Read::No => true,
                Read::Number(_) => object.data_type.size() > 0,
                Read::Text(_) => object.data_type.size() == 0,
            };
            mistake.unless(is_right, "its function returns another type");
            mistake.unless(
                own.write.is_some() == object.access.is_writable(),
                "the access does not match its functions: `Own::written` for an object that can be written",
            );
            if let Target::Own(Use::Command(command)) = object.target {
                let (least, most) = object.data_type.range();
                let (low, high) = command.limits;
                mistake.unless(
                    object.data_type.size() == 0 || least <= low && low <= high && high <= most,
                    "the limits of the command must fit the type",
                );
            }
            rest = others;
        }
    });
    if let [own, ..] = rest {
        Mistake::object(own.index, own.sub)
            .text("the dictionary does not have this own object")
            .fail();
    }
}

/// Checks that the parameters and values of the objects exist.
#[track_caller]
const fn check_references(objects: &[Object], parameters: &[Parameter], quantities: &[Quantity]) {
    each!(object in objects => {
        let mistake = object.mistake();
        let (parameter, value) = match object.target {
            Target::Parameter(id) | Target::CobId(id) | Target::FreeCobId(id) => (Some(id), None),
            Target::Command(id, value) => (Some(id), Some(value)),
            Target::Value(id) => (None, Some(id)),
            _ => (None, None),
        };
        if let Some(id) = parameter {
            exists(mistake, parameters, id);
        }
        if let Some(id) = value {
            has_quantity(mistake, quantities, id);
        }
    });
}

/// Checks that each quantity is the value of an object, unless another protocol may send it.
#[track_caller]
const fn check_values(objects: &[Object], quantities: &[Quantity], hosted: bool) {
    each!(quantity in quantities => {
        let mut found = hosted;
        each!(object in objects => {
            if let Target::Value(id) | Target::Command(_, id) = object.target {
                found |= id.0 == quantity.id.0;
            }
        });
        quantity.mistake()
            .unless(found, "no object has this value");
    });
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
    each!((index, sub, data_type, mandatory) in &PROFILE => {
        let mistake = mistake_at(objects, *index, *sub);
        let Some(object) = object_at(objects, *index, *sub) else {
            mistake.unless(!*mandatory, "this object is mandatory in CiA 301");
            continue;
        };
        mistake.unless(
            object.data_type(parameters, quantities) as u8 == *data_type as u8,
            "CiA 301 defines another data type for this object",
        );
        let is_setting = matches!(
            object.target,
            Target::Parameter(_)
                | Target::CobId(_)
                | Target::FreeCobId(_)
                | Target::Constant(_)
        );
        mistake.unless(
            *index != 0x1014 || !matches!(object.target, Target::Parameter(_)),
            "the COB-ID of the EMCY is `profile::cob_id` or `profile::free_cob_id`",
        );
        if *index == 0x1001 {
            mistake.unless(
                matches!(object.target, Target::Service(Service::ErrorRegister)),
                "the error register is a service of the node",
            );
        } else {
            mistake.unless(is_setting, "the protocol needs a parameter or a constant here");
        }
    });
}

/// Checks that a constant at sub-index 0 of an object of CiA 301 is the highest sub-index. Manufacturer-specific objects (from 2000h) are
/// not checked.
#[track_caller]
const fn check_highest(objects: &[Object]) {
    each!(object in objects => {
        let Object { index, sub, .. } = *object;
        let mut highest = 0;
        each!(other in objects => {
            if other.index == index {
                highest = other.sub as u32 + other.count as u32 - 1;
            }
        });
        if let Target::Constant(number) = object.target
            && sub == 0
            && highest > 0
            && index < 0x2000
            && number != highest
        {
            mistake_at(objects, index, 0)
                .text("the highest sub-index is ")
                .number(highest)
                .text(", not ")
                .number(number)
                .fail();
        }
    });
}

/// Checks that each object has a name, its own or that of its parameter or value, and that an object with sub-indices has sub-index 0.
#[track_caller]
const fn check_names(objects: &[Object], parameters: &[Parameter], quantities: &[Quantity]) {
    each!(object in objects => {
        let mistake = object.mistake();
        let described = match object.target {
            Target::Parameter(id)
            | Target::CobId(id)
            | Target::FreeCobId(id)
            | Target::Command(id, _) => at(parameters, id.0 as usize).name,
            Target::Value(id) => at(quantities, id.0 as usize).name,
            _ => "",
        };
        mistake.unless(
            !object.name.is_empty() || !described.is_empty(),
            "the object has no name",
        );
        mistake.unless(
            matches!(object.index, 0x1000..0xC000),
            "the index of an object is 1000h to BFFFh",
        );
        mistake.unless(
            object_at(objects, object.index, 0).is_some(),
            "an object with sub-indices has sub-index 0",
        );
    });
}

/// Checks that each entry of the heartbeat consumer is a parameter, and that the dictionary has as many entries as the product.
#[track_caller]
const fn check_consumers(objects: &[Object], count: usize) {
    let mut sub = 1;
    while sub <= count + 1 && sub < 256 {
        let entry = object_at(objects, 0x1016, sub as u8);
        mistake_at(objects, 0x1016, sub as u8).unless(
            entry.is_some() == (sub <= count),
            "the number of entries is not that of `Consumers`",
        );
        if let Some(entry) = entry {
            mistake_at(objects, 0x1016, sub as u8).unless(
                matches!(entry.target, Target::Parameter(_)),
                "an entry of the heartbeat consumer is a parameter",
            );
        }
        sub += 1;
    }
}

#[track_caller]
const fn check_texts(objects: &[Object], text: usize) {
    Mistake::item("Text").unless(
        text <= u8::MAX as usize,
        "the buffer for texts has more than 255 bytes",
    );
    each!(object in objects => {
        if let Target::Text(constant) = object.target {
            let mistake = object.mistake();
            mistake.unless(!constant.is_empty(), "the text is empty");
            mistake.unless(constant.len() <= text, "the text is longer than its buffer");
            each!(letter in constant.as_bytes() => {
                mistake.unless(
                    matches!(*letter, b' '..=b'~'),
                    "a text consists of printable ASCII characters",
                );
            });
            mistake.unless(
                text >= NAME || !super::objects::is_name(object.index),
                "the name of a unit is longer than the buffer",
            );
        }
    });
}

#[track_caller]
const fn check_history(objects: &[Object], capacity: usize) {
    let errors = match object_at(objects, 0x1003, 1) {
        Some(errors) if errors.is_history() => errors.count as usize,
        _ => 0,
    };
    if errors != capacity {
        mistake_at(objects, 0x1003, 1)
            .text("the dictionary has ")
            .number(errors as u32)
            .text(" errors, the capacity of the error history is ")
            .number(capacity as u32)
            .fail();
    }
}

#[track_caller]
const fn check_lss(objects: &[Object]) {
    let mut sub = 1;
    while sub <= 4 {
        mistake_at(objects, 0x1018, sub).unless(
            object_at(objects, 0x1018, sub).is_some(),
            "a product with LSS needs all numbers of the identity object",
        );
        sub += 1;
    }
}

/// Checks the manufacturer-specific tables of bit rates. CiA 305 has or reserves the selectors below 128.
#[track_caller]
const fn check_lss_tables(tables: &[LssTable], lss: bool) {
    each!(place, table in tables => {
        let mistake = table.mistake(place);
        mistake.unless(lss, "a product without LSS has no table of bit rates");
        mistake.unless(table.selector >= 128, "the selector is 128 to 255");
        each!(other in tables.split_at(place).0 => {
            mistake.unless(other.selector != table.selector, "another table has this selector");
        });
    });
}

/// The parameter with this id, which an item of the product names.
#[track_caller]
const fn parameter<'a>(parameters: &'a [Parameter], id: ParameterId, item: &str) -> &'a Parameter {
    exists(Mistake::item(item), parameters, id);
    at(parameters, id.0 as usize)
}

#[cfg(test)]
mod tests;
