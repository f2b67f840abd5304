//! What the descriptions of CANopen models have in common: an object's type, permitted values and factory value as text.

use plumbline::canopen::dictionary::{DataType, Home, Live, Object};

/// A number as its type reads it: FFFFh in an INTEGER16 is -1.
pub fn signed(data_type: DataType, number: u32) -> i64 {
    match data_type {
        DataType::I16 => i64::from(number as u16 as i16),
        DataType::I32 => i64::from(number as i32),
        DataType::U8 | DataType::U16 | DataType::U32 | DataType::Text => number.into(),
    }
}

/// The number that an object has as delivered, without node id; None for texts and for what is measured or differs between units.
pub fn factory(object: &Object) -> Option<u32> {
    match object.home {
        Home::Constant(number) => Some(number),
        Home::Live(Live::Serial) | Home::Text(_) | Home::Measured(_) | Home::Key => None,
        // There is no error yet, and nothing is being stored.
        Home::Live(_) => Some(0),
        Home::Any(_)
        | Home::Range(..)
        | Home::OneOf(..)
        | Home::Transmission(_)
        | Home::SyncId(_) => Some(object.factory),
    }
}

/// The lowest and the highest number that can be written; None where those of the type are the limits.
///
/// The factory value lies within: it can be read, though not always written.
pub fn limits(object: &Object) -> Option<[u32; 2]> {
    let (low, high) = match object.home {
        Home::Range(_, low, high) => (low.into(), high.into()),
        Home::OneOf(_, list) => (
            u32::from(*list.iter().min()?),
            u32::from(*list.iter().max()?),
        ),
        _ => return None,
    };
    Some([low.min(object.factory), high.max(object.factory)])
}

/// What can be written, and what the numbers mean; empty when the type says all.
pub fn permitted(object: &Object) -> String {
    let numbers: Vec<u32> = match object.home {
        Home::Range(_, low, high) => (low.into()..=high.into()).collect(),
        Home::OneOf(_, list) => list.iter().map(|&number| number.into()).collect(),
        _ => Vec::new(),
    };
    let meanings: Vec<_> = object
        .meanings
        .iter()
        .map(|(number, name)| format!("{number} = {name}"))
        .collect();
    let named: Vec<u32> = object.meanings.iter().map(|&(number, _)| number).collect();
    let mut parts = Vec::new();
    if numbers.is_empty() || numbers != named {
        parts.push(match object.home {
            Home::Range(_, low, high) => format!("{low}..{high}"),
            Home::OneOf(..) => listed(&numbers),
            Home::Transmission(_) => "0..240, 252..255".to_owned(),
            Home::SyncId(_) => "11-bit identifier that is free".to_owned(),
            Home::Live(Live::ErrorCount) => "0 clears".to_owned(),
            Home::Live(Live::Store) => "\"save\"".to_owned(),
            Home::Live(Live::Restore) => "\"load\"".to_owned(),
            _ => String::new(),
        });
    }
    parts.push(meanings.join(", "));
    parts.retain(|part| !part.is_empty());
    parts.join("; ")
}

fn listed(numbers: &[u32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(u32::to_string).collect();
    numbers.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Object = Object {
        home: Home::OneOf(0, &LIST),
        meanings: &[(0, "failed"), (1, "make")],
        ..Object::PLAIN
    };
    static LIST: &[u16] = &[1];

    #[test]
    fn numbers_of_signed_types_can_be_negative() {
        assert_eq!(signed(DataType::I16, 0xFFFF), -1);
        assert_eq!(signed(DataType::I32, 0x8000_0000), i64::from(i32::MIN));
        assert_eq!(signed(DataType::U32, 0x8000_0000), 0x8000_0000);
    }

    #[test]
    fn the_factory_value_lies_within_the_limits() {
        assert_eq!(limits(&ALONE), Some([0, 1]));
        let range = Object {
            home: Home::Range(0, 1, 127),
            factory: 10,
            ..Object::PLAIN
        };
        assert_eq!(limits(&range), Some([1, 127]));
        assert_eq!(limits(&Object::PLAIN), None);
    }

    #[test]
    fn what_can_be_written_is_told_unless_the_meanings_tell_it() {
        assert_eq!(permitted(&ALONE), "1; 0 = failed, 1 = make");
        let named = Object {
            home: Home::Range(0, 0, 1),
            ..ALONE
        };
        assert_eq!(permitted(&named), "0 = failed, 1 = make");
        assert_eq!(permitted(&Object::PLAIN), "");
    }
}
