//! Codings: the numbers of a parameter with their names and values, for example the codes of a bit rate or of a filter.
//!
//! A [`Coding`] is a constant of a product. It is the source of the names and the permitted values of a parameter, and of the
//! compact list in which the device finds the value of a number.

use super::Meaning;
use crate::walk::{at, each, put};

/// The numbers of a parameter, their names and their values.
#[derive(Clone, Copy, Debug)]
pub struct Coding<T: Copy + 'static, const N: usize>(pub [(u16, &'static str, T); N]);

impl<T: Copy, const N: usize> Coding<T, N> {
    /// The numbers with their names, for [`Parameter::meanings`](super::Parameter::meanings).
    pub const fn meanings(&self) -> [Meaning; N] {
        let mut meanings = [(0, ""); N];
        each!(row, (number, name, _) in &self.0 => {
            put(&mut meanings, row, (*number as u32, *name));
        });
        meanings
    }

    /// The numbers, for [`Permitted::OneOf`](super::Permitted::OneOf), if they need no names.
    pub const fn numbers(&self) -> [u32; N] {
        let mut numbers = [0; N];
        each!(row, (number, ..) in &self.0 => { put(&mut numbers, row, *number as u32) });
        numbers
    }

    /// The values in a list indexed by number, for the device. The numbers must count from 0; otherwise there is a compile error.
    pub const fn sequence(&self) -> [T; N] {
        let (_, _, first) = *at(&self.0, 0);
        let mut values = [first; N];
        each!(row, (number, _, value) in &self.0 => {
            assert!(*number as usize == row, "the numbers must count from 0");
            put(&mut values, row, *value);
        });
        values
    }

    /// The numbers with their values, for the device, if the numbers do not count from 0.
    pub const fn codes(&self) -> [(u16, T); N] {
        let (_, _, first) = *at(&self.0, 0);
        let mut codes = [(0, first); N];
        each!(row, (number, _, value) in &self.0 => { put(&mut codes, row, (*number, *value)) });
        codes
    }
}

/// The value of `number` in a [sequence](Coding::sequence); None if there is none.
pub fn meaning<T: Copy>(values: &[T], number: u32) -> Option<T> {
    values.get(number as usize).copied()
}

/// The value of `number` in a list of [codes](Coding::codes); None if there is none.
pub fn decode<T: Copy>(codes: &[(u16, T)], number: u32) -> Option<T> {
    let same = |(code, _): &&(u16, T)| u32::from(*code) == number;
    codes.iter().find(same).map(|(_, value)| *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODING: Coding<char, 3> = Coding([(0, "off", 'o'), (2, "ten", 't'), (1000, "all", 'a')]);

    #[test]
    fn meanings_numbers_and_codes_match_rows() {
        assert_eq!(CODING.meanings(), [(0, "off"), (2, "ten"), (1000, "all")]);
        assert_eq!(CODING.numbers(), [0, 2, 1000]);
        assert_eq!(CODING.codes(), [(0, 'o'), (2, 't'), (1000, 'a')]);
    }

    #[test]
    fn number_without_code_decodes_to_none() {
        let codes = CODING.codes();
        assert_eq!(decode(&codes, 1000), Some('a'));
        assert_eq!(decode(&codes, 1), None);
        assert_eq!(decode(&codes, 0x1_0000), None);
    }

    #[test]
    fn sequence_has_each_value_at_index_of_its_number() {
        let values = Coding([(0, "off", 'o'), (1, "on", 'n')]).sequence();
        assert_eq!(values, ['o', 'n']);
        assert_eq!(meaning(&values, 1), Some('n'));
        assert_eq!(meaning(&values, 2), None);
    }

    #[test]
    #[should_panic(expected = "count from 0")]
    fn sequence_with_gap_is_refused() {
        CODING.sequence();
    }
}
