//! What a program behind a bootloader tells of itself over the bus.
//!
//! A client compares the [`Hardware`] with that of a [`Header`](super::Header), so that it refuses a file for another one before the program stops.

use super::element::Element;

/// The program that runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Installed {
    /// The CRC-32 of its body.
    pub crc: u32,
    /// The hardware for which it is built.
    pub hardware: Hardware,
}

/// The hardware for which a program is built: bits 0 to 14 are the number of the board, bit 15 is the [measuring element](Element).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Hardware(u16);

impl Hardware {
    /// A board with a measuring element.
    pub const fn new(board: u16, element: Element) -> Self {
        Self(element.with(board))
    }

    /// The hardware of this number.
    pub const fn of(number: u16) -> Self {
        Self(number)
    }

    /// Its number.
    pub const fn number(self) -> u16 {
        self.0
    }

    /// The number of the board.
    pub const fn board(self) -> u16 {
        Element::product(self.0)
    }

    /// The measuring element.
    pub const fn element(self) -> Element {
        Element::of(self.0)
    }
}
