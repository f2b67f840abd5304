//! Identification of component, software and ECU (SAE J1939-71, 5.3): texts, each with `*` at its end.
//!
//! ```text
//!  component (65259)   make * model * serial number * unit number *
//!  software (65242)    01h (number of fields) version *
//!  ECU (64965)         part number * serial number * location * type * manufacturer *
//! ```
//!
//! The unit number and the location are empty.

use super::identifier::{
    COMPONENT_IDENTIFICATION, ECU_IDENTIFICATION, Pgn, SOFTWARE_IDENTIFICATION,
};
use super::product::{Product, model, version};
use super::transport::Message;
use crate::canopen::{Text, decimal};

/// The message with this identification; None for another group.
pub fn message<P: Product>(pgn: Pgn, serial: u32) -> Option<Message> {
    let serial: Text<10> = decimal(serial);
    let (make, model) = (P::MAKE.as_bytes(), const { model::<P>() }.as_bytes());
    let fields: &[&[u8]] = match pgn {
        COMPONENT_IDENTIFICATION => &[make, model, &serial, b""],
        SOFTWARE_IDENTIFICATION => &[const { version::<P>() }.as_bytes()],
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
    Some(message)
}
