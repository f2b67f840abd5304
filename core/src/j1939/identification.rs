//! Identification of component, software and ECU (SAE J1939-71, 5.3): texts, each with `*` at its end.
//!
//! ```text
//!  component (65259)   make * model * serial number * unit number *
//!  software (65242)    01h (number of fields) version *
//!  ECU (64965)         part number * serial number * location * type * manufacturer *
//! ```
//!
//! The unit number and the location are empty. A message of less than 8 bytes is filled with FFh.

use super::identifier::{
    COMPONENT_IDENTIFICATION, ECU_IDENTIFICATION, Pgn, SOFTWARE_IDENTIFICATION,
};
use super::product::Product;
use super::transport::Message;
use crate::node::Shell;
use crate::store::Name;
use crate::text::{Text, decimal};

/// The message with this identification of a unit; None for another group.
pub fn message<P: Product>(pgn: Pgn, shell: &Shell) -> Option<Message> {
    let serial: Text<10> = decimal(shell.serial());
    let make = P::MAKE.as_bytes();
    let model = given(shell.unit().name.as_ref(), P::MODEL);
    let version = given(shell.unit().software.as_ref(), P::VERSION);
    let fields: &[&[u8]] = match pgn {
        COMPONENT_IDENTIFICATION => &[make, model, &serial, b""],
        SOFTWARE_IDENTIFICATION => &[version],
        ECU_IDENTIFICATION => &[model, &serial, b"", P::TYPE.as_bytes(), make],
        _ => return None,
    };
    let mut message = Message::new();
    // There is always room: the lengths are checked at compile time.
    if pgn == SOFTWARE_IDENTIFICATION {
        let _ = message.push(fields.len() as u8);
    }
    for field in fields {
        let _ = message.extend_from_slice(field);
        let _ = message.push(b'*');
    }
    while message.len() < 8 {
        let _ = message.push(0xFF);
    }
    Some(message)
}

/// The text of the unit, or else that of the product. A text with the end of a field is not possible.
fn given<'a>(unit: Option<&'a Name>, product: &'static str) -> &'a [u8] {
    let unit = unit.map(Name::bytes).filter(|text| !text.contains(&b'*'));
    unit.unwrap_or(product.as_bytes())
}
