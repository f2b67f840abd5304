//! The message of a compile error for a mistake in the tables of a product. It begins with the line of the row and names the row.
//!
//! The checks of tables are `const fn`s that the macro [`project!`](crate::project) calls where the table is written. All of them are
//! `#[track_caller]`, so that the error is shown at that macro. So are the functions that return a row, so that its [`Origin`] is the line
//! in the table.

use core::panic::Location;

use crate::walk::{at, each, put};

/// The longest message in bytes; the rest is cut off.
const LONGEST: usize = 400;

/// The line where a row of a table is written. Only messages of mistakes use it, so it makes no difference between two rows, and no
/// image has it.
#[derive(Clone, Copy, Eq, Debug)]
pub struct Origin(&'static Location<'static>);

impl Origin {
    /// The line of the caller. A function that returns a row is `#[track_caller]`, so that its caller is the line in the table.
    #[track_caller]
    pub const fn here() -> Self {
        Self(Location::caller())
    }
}

impl PartialEq for Origin {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A mistake in a table.
#[derive(Clone, Copy)]
pub(crate) struct Mistake<'a> {
    row: Row<'a>,
    origin: Option<Origin>,
}

/// The row with the mistake, as the message names it.
#[derive(Clone, Copy)]
enum Row<'a> {
    /// An object of CANopen: `object 2100h:02: `.
    Object(u16, u8),
    /// A parameter: `parameter 7 "Cycle time": `.
    Parameter(usize, &'a str),
    /// A function select code: `code 28h "Zero offset": `.
    Code(u8, &'a str),
    /// A class of DeviceNet: `class 64h: `.
    Class(u8),
    /// An attribute of instance 1 of a class: `class 64h, instance 1, attribute 71h: `.
    Attribute(u8, u8),
    /// A group of J1939: `group 65312 "SLOPE": `.
    Group(u32, &'a str),
    /// A signal of a group: `group 65312 "SLOPE", signal "Quality": `.
    Signal(u32, &'a str, &'a str),
    /// Another row, for example `quantity 2: `.
    Other(&'a str, usize),
    /// An item of the product, for example `NODE_ID: `.
    Item(&'a str),
}

impl<'a> Mistake<'a> {
    const fn new(row: Row<'a>) -> Self {
        Self { row, origin: None }
    }

    /// In an object of CANopen.
    pub const fn object(index: u16, sub: u8) -> Self {
        Self::new(Row::Object(index, sub))
    }

    /// In the parameter at this place.
    pub const fn parameter(place: usize, name: &'a str) -> Self {
        Self::new(Row::Parameter(place, name))
    }

    /// In a function select code.
    pub const fn code(code: u8, name: &'a str) -> Self {
        Self::new(Row::Code(code, name))
    }

    /// In a class of DeviceNet.
    pub const fn class(class: u8) -> Self {
        Self::new(Row::Class(class))
    }

    /// In an attribute of instance 1 of a class.
    pub const fn attribute(class: u8, number: u8) -> Self {
        Self::new(Row::Attribute(class, number))
    }

    /// In a group of J1939.
    pub const fn group(pgn: u32, name: &'a str) -> Self {
        Self::new(Row::Group(pgn, name))
    }

    /// In a signal of a group.
    pub const fn signal(pgn: u32, group: &'a str, name: &'a str) -> Self {
        Self::new(Row::Signal(pgn, group, name))
    }

    /// In the row of this kind at this place.
    pub const fn row(kind: &'a str, place: usize) -> Self {
        Self::new(Row::Other(kind, place))
    }

    /// In an item of the product.
    pub const fn item(item: &'a str) -> Self {
        Self::new(Row::Item(item))
    }

    /// The same with the line of the row.
    pub const fn at(self, origin: Origin) -> Self {
        Self {
            origin: Some(origin),
            ..self
        }
    }

    /// The message, which begins with the line, the row and this text.
    pub const fn text(self, text: &str) -> Message {
        const EMPTY: Message = Message {
            text: [0; LONGEST],
            length: 0,
        };
        let line = match self.origin {
            Some(Origin(line)) => EMPTY
                .text(line.file())
                .text(":")
                .number(line.line())
                .text(": "),
            None => EMPTY,
        };
        let row = match self.row {
            Row::Object(index, sub) => line
                .text("object ")
                .hexadecimal(index as u32, 4)
                .text("h:")
                .hexadecimal(sub as u32, 2),
            Row::Parameter(place, name) => line
                .text("parameter ")
                .number(place as u32)
                .text(" ")
                .quoted(name),
            Row::Code(code, name) => line
                .text("code ")
                .hexadecimal(code as u32, 2)
                .text("h ")
                .quoted(name),
            Row::Class(class) => line.text("class ").hexadecimal(class as u32, 2).text("h"),
            Row::Attribute(class, number) => line
                .text("class ")
                .hexadecimal(class as u32, 2)
                .text("h, instance 1, attribute ")
                .hexadecimal(number as u32, 2)
                .text("h"),
            Row::Group(pgn, name) => line.text("group ").number(pgn).text(" ").quoted(name),
            Row::Signal(pgn, group, name) => line
                .text("group ")
                .number(pgn)
                .text(" ")
                .quoted(group)
                .text(", signal ")
                .quoted(name),
            Row::Other(kind, place) => line.text(kind).text(" ").number(place as u32),
            Row::Item(item) => line.text(item),
        };
        row.text(": ").text(text)
    }

    /// Ends the evaluation with this message, unless the row is correct.
    #[track_caller]
    pub const fn unless(self, is_right: bool, what: &str) {
        if !is_right {
            self.text(what).fail();
        }
    }
}

/// The message about a mistake.
pub(crate) struct Message {
    text: [u8; LONGEST],
    length: usize,
}

impl Message {
    /// Appends a text to the message.
    pub const fn text(mut self, text: &str) -> Self {
        each!(letter in text.as_bytes() => {
            if self.length < LONGEST {
                put(&mut self.text, self.length, *letter);
                self.length += 1;
            }
        });
        self
    }

    /// Appends a name in quotation marks.
    const fn quoted(self, name: &str) -> Self {
        self.text("\"").text(name).text("\"")
    }

    /// Appends a decimal number to the message.
    pub const fn number(self, number: u32) -> Self {
        let (mut digits, mut first) = ([0; 10], 10);
        let mut rest = number;
        loop {
            first -= 1;
            put(&mut digits, first, b'0' + (rest % 10) as u8);
            rest /= 10;
            if rest == 0 {
                return self.digits(digits.split_at(first).1);
            }
        }
    }

    /// Appends a hexadecimal number with this number of digits to the message.
    pub const fn hexadecimal(self, number: u32, count: usize) -> Self {
        let mut digits = [0; 8];
        let mut place = 8;
        while place > 8 - count {
            place -= 1;
            let digit = (number >> (4 * (7 - place)) & 15) as usize;
            put(&mut digits, place, *at(b"0123456789ABCDEF", digit));
        }
        self.digits(digits.split_at(place).1)
    }

    const fn digits(self, digits: &[u8]) -> Self {
        match core::str::from_utf8(digits) {
            Ok(digits) => self.text(digits),
            Err(_) => self,
        }
    }

    /// Ends the evaluation with this message.
    #[track_caller]
    #[expect(clippy::panic, reason = "evaluated at compile time only")]
    pub const fn fail(&self) -> ! {
        // A name that is not ASCII can be cut within a letter.
        let mut length = self.length;
        loop {
            let (text, _) = self.text.split_at(length);
            match core::str::from_utf8(text) {
                Ok(text) => panic!("{}", text),
                Err(_) => length -= 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic = "object 6FA1h:0C: the value is 1048576, not 0"]
    fn message_has_the_address_and_the_numbers() {
        Mistake::object(0x6FA1, 0x0C)
            .text("the value is ")
            .number(1_048_576)
            .text(", not ")
            .number(0)
            .fail();
    }

    #[test]
    #[should_panic = "parameter 12 \"Zero\": wrong"]
    fn message_has_the_name_of_the_parameter() {
        Mistake::parameter(12, "Zero").unless(false, "wrong");
    }

    #[test]
    fn message_begins_with_the_line_of_the_row() {
        let (origin, line) = (Origin::here(), line!());
        let message = Mistake::item("row").at(origin).text("wrong");
        let text = core::str::from_utf8(message.text.split_at(message.length).0);
        assert_eq!(text, Ok(&*std::format!("{}:{line}: row: wrong", file!())));
    }

    #[test]
    fn correct_row_has_no_message() {
        Mistake::item("NODE_ID").unless(true, "wrong");
    }

    #[test]
    #[should_panic = "quantity 3: aaaa"]
    fn long_message_is_cut_at_a_letter() {
        let name = std::format!("{}\u{e4}{}", "a".repeat(388), "a".repeat(99));
        Mistake::row("quantity", 3).text(&name).fail();
    }
}
