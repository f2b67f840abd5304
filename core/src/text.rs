//! Texts of a few bytes without a heap, for names and numbers in messages.

/// A text of up to `N` bytes.
pub type Text<const N: usize> = heapless::Vec<u8, N>;

/// A number as a decimal text. `N` is at least 10.
pub fn decimal<const N: usize>(number: u32) -> Text<N> {
    let (mut text, mut unit, mut rest) = (Text::new(), 1_000_000_000, number);
    while unit > 0 {
        if number >= unit || unit == 1 {
            let digit = rest.checked_div(unit).unwrap_or(0);
            rest = rest.wrapping_sub(digit.wrapping_mul(unit));
            // There is room for ten digits.
            let _ = text.push(b'0'.wrapping_add(digit as u8));
        }
        unit /= 10;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_text_has_no_leading_zeros() {
        for number in [0, 9, 10, 1_000_000_000, u32::MAX] {
            let text: Text<10> = decimal(number);
            assert_eq!(*text, *std::format!("{number}").as_bytes());
        }
    }
}
