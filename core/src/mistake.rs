//! The message of a compile error for a mistake in the tables of a product. It names the row.
//!
//! The checks of tables are `const fn`s that the macro [`project!`](crate::project) calls where the table is written. All of them are
//! `#[track_caller]`, so that the error is shown at that macro.
#![allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only

/// The longest message in bytes; the rest is cut off.
const LONGEST: usize = 160;

/// A row of a table in which there is a mistake.
#[derive(Clone, Copy)]
pub(crate) enum Mistake<'a> {
    Object(u16, u8),
    Parameter(usize, &'a str),
    Row(&'a str, usize),
    Item(&'a str),
}

impl<'a> Mistake<'a> {
    /// A mistake in the object at an address: `object 2100h:02: `.
    pub const fn in_object(index: u16, sub: u8) -> Self {
        Self::Object(index, sub)
    }

    /// A mistake in a parameter: `parameter 7 "Cycle time": `.
    pub const fn in_parameter(place: usize, name: &'a str) -> Self {
        Self::Parameter(place, name)
    }

    /// A mistake in another row, for example `quantity 2: `.
    pub const fn in_row(kind: &'a str, place: usize) -> Self {
        Self::Row(kind, place)
    }

    /// A mistake in an item of the product, for example `NODE_ID: `.
    pub const fn in_item(item: &'a str) -> Self {
        Self::Item(item)
    }

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
                .text(" \"")
                .text(name)
                .text("\""),
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
        let bytes = text.as_bytes();
        let mut place = 0;
        while place < bytes.len() && self.length < LONGEST {
            self.text[self.length] = bytes[place];
            self.length += 1;
            place += 1;
        }
        self
    }

    /// Appends a decimal number to the message.
    pub const fn number(self, number: u32) -> Self {
        let (mut digits, mut first) = ([0; 10], 10);
        let mut rest = number;
        loop {
            first -= 1;
            digits[first] = b'0' + (rest % 10) as u8;
            rest /= 10;
            if rest == 0 {
                return self.digits(&digits, first);
            }
        }
    }

    /// Appends a hexadecimal number with this number of digits to the message.
    pub const fn hexadecimal(self, number: u32, count: usize) -> Self {
        let mut digits = [0; 8];
        let mut place = 8;
        while place > 8 - count {
            place -= 1;
            digits[place] = b"0123456789ABCDEF"[(number >> (4 * (7 - place)) & 15) as usize];
        }
        self.digits(&digits, place)
    }

    const fn digits(mut self, digits: &[u8], first: usize) -> Self {
        let mut place = first;
        while place < digits.len() && self.length < LONGEST {
            self.text[self.length] = digits[place];
            self.length += 1;
            place += 1;
        }
        self
    }

    /// Ends the evaluation with this message.
    #[track_caller]
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
        Mistake::in_object(0x6FA1, 0x0C)
            .text("the value is ")
            .number(1_048_576)
            .text(", not ")
            .number(0)
            .fail();
    }

    #[test]
    #[should_panic = "parameter 12 \"Zero\": wrong"]
    fn message_has_the_name_of_the_parameter() {
        Mistake::in_parameter(12, "Zero").unless(false, "wrong");
    }

    #[test]
    fn correct_row_has_no_message() {
        Mistake::in_item("NODE_ID").unless(true, "wrong");
    }

    #[test]
    #[should_panic = "quantity 3: aaaa"]
    fn long_message_is_cut_at_a_letter() {
        let name = std::format!("{}\u{e4}{}", "a".repeat(148), "a".repeat(99));
        Mistake::in_row("quantity", 3).text(&name).fail();
    }
}
