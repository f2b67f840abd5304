//! The object dictionary of the JN2101 (manual 7.6, 7.7 and 14).

mod application;
mod communication;

use crate::canopen::dictionary::{Access, DataType, Home, Object};

const PLAIN: Object = Object::PLAIN;

const fn number(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    value: u32,
) -> Object {
    Object {
        index,
        sub,
        name,
        data_type,
        home: Home::Constant(value),
        ..PLAIN
    }
}

/// The sub-index 0 that tells the highest one.
const fn highest(index: u16, group: &'static str, data_type: DataType, sub: u8) -> Object {
    Object {
        index,
        group,
        name: "Highest supported sub-index",
        data_type,
        home: Home::Constant(sub as u32),
        ..PLAIN
    }
}

/// A parameter that is stored.
const fn parameter(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    home: Home,
    factory: u32,
) -> Object {
    Object {
        index,
        sub,
        name,
        data_type,
        access: Access::Rw,
        home,
        factory,
        stored: true,
        ..PLAIN
    }
}

/// A command or setting of the model that starts with its factory value at each boot.
const fn volatile(object: Object) -> Object {
    Object {
        stored: false,
        ..object
    }
}

/// The number of rows.
pub const ROWS: usize = communication::OBJECTS.len() + application::OBJECTS.len();

/// All objects, sorted.
pub const OBJECTS: [Object; ROWS] = joined();

#[allow(clippy::indexing_slicing)] // evaluated at compile time only
const fn joined() -> [Object; ROWS] {
    let first = &communication::OBJECTS;
    let second = &application::OBJECTS;
    let mut objects = [PLAIN; ROWS];
    let mut row = 0;
    while row < ROWS {
        objects[row] = if row < first.len() {
            first[row]
        } else {
            second[row - first.len()]
        };
        row += 1;
    }
    objects
}
