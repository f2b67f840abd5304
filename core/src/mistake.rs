//! The message of a compile error for a mistake in the tables of a product. It names the row.
//!
//! The checks of tables are `const fn`s that the macro [`project!`](crate::project) calls where the table is written. All of them are
//! `#[track_caller]`, so that the error is shown at that macro.

use crate::walk::{at, each, put};

/// The longest message in bytes; the rest is cut off.
const LONGEST: usize = 160;

/// A row of a table in which there is a mistake.
#[derive(Clone, Copy)]
pub(crate) enum Mistake<'a> {
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
    Row(&'a str, usize),
    /// An item of the product, for example `NODE_ID: `.
    Item(&'a str),
}

impl Mistake<'_> {
    /// The message, which begins with the row and this text.
    pub const fn text(self, text: &str) -> Message {
        const NONE: Message = Message {
            text: [0; LONGEST],
            length: 0,
        };
        let row = match self {
            Self::Object(index, sub) => NONE
                .text("object ")
                .hexadecimal(index as u32, 4)
                .text("h:")
                .hexadecimal(sub as u32, 2),
            Self::Parameter(place, name) => NONE
                .text("parameter ")
                .number(place as u32)
                .text(" ")
                .quoted(name),
            Self::Code(code, name) => NONE
                .text("code ")
                .hexadecimal(code as u32, 2)
                .text("h ")
                .quoted(name),
            Self::Class(class) => NONE.text("class ").hexadecimal(class as u32, 2).text("h"),
            Self::Attribute(class, number) => NONE
                .text("class ")
                .hexadecimal(class as u32, 2)
                .text("h, instance 1, attribute ")
                .hexadecimal(number as u32, 2)
                .text("h"),
            Self::Group(pgn, name) => NONE.text("group ").number(pgn).text(" ").quoted(name),
            Self::Signal(pgn, group, name) => NONE
                .text("group ")
                .number(pgn)
                .text(" ")
                .quoted(group)
                .text(", signal ")
                .quoted(name),
            Self::Row(kind, place) => NONE.text(kind).text(" ").number(place as u32),
            Self::Item(item) => NONE.text(item),
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
        Mistake::Object(0x6FA1, 0x0C)
            .text("the value is ")
            .number(1_048_576)
            .text(", not ")
            .number(0)
            .fail();
    }

    #[test]
    #[should_panic = "parameter 12 \"Zero\": wrong"]
    fn message_has_the_name_of_the_parameter() {
        Mistake::Parameter(12, "Zero").unless(false, "wrong");
    }

    #[test]
    fn correct_row_has_no_message() {
        Mistake::Item("NODE_ID").unless(true, "wrong");
    }

    #[test]
    #[should_panic = "quantity 3: aaaa"]
    fn long_message_is_cut_at_a_letter() {
        let name = std::format!("{}\u{e4}{}", "a".repeat(148), "a".repeat(99));
        Mistake::Row("quantity", 3).text(&name).fail();
    }
}
