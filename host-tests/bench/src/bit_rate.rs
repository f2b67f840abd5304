//! The bit rate as an option of a program.

use plumbline::can::BitRate;

/// One of the ten bit rates, in kbit/s.
///
/// # Errors
/// The text is not one of them; the message names all of them.
pub fn bit_rate(text: &str) -> Result<BitRate, String> {
    let kbits = |rate: &BitRate| f64::from(rate.bits_per_second()) / 1000.0;
    let wanted = text.parse::<f64>().ok();
    BitRate::ALL
        .into_iter()
        .find(|rate| Some(kbits(rate)) == wanted)
        .ok_or_else(|| {
            let all: Vec<String> = BitRate::ALL
                .iter()
                .map(|rate| kbits(rate).to_string())
                .collect();
            format!("the bit rates are {} kbit/s{}", all.join(", "), meant(text))
        })
}

/// The question about the rate that a user has probably meant: the nearest one to a number in kbit/s, or in bit/s, with any unit.
fn meant(text: &str) -> String {
    let end = text.find(|letter: char| !letter.is_ascii_digit() && letter != '.');
    let number = text[..end.unwrap_or(text.len())].parse::<f64>().ok();
    let Some(number) = number.filter(|number| *number > 0.0) else {
        return String::new();
    };
    let unit = text[end.unwrap_or(text.len())..].trim_start();
    let kbits = match unit.chars().next() {
        Some('M' | 'm') => number * 1000.0,
        None if number > 2000.0 => number / 1000.0,
        _ => number,
    };
    let of = |rate: &BitRate| f64::from(rate.bits_per_second()) / 1000.0;
    let distance = |rate: &BitRate| (of(rate) / kbits).ln().abs();
    let mut rates = BitRate::ALL.to_vec();
    rates.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    let nearest = rates.first().filter(|rate| distance(rate) < 0.7);
    nearest.map_or(String::new(), |rate| {
        format!(". Did you mean {}?", of(rate))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_rate_asks_for_the_nearest_one() {
        for (text, meant) in [
            ("255", "250"),
            ("250k", "250"),
            ("250000", "250"),
            ("250 kbit/s", "250"),
            ("1M", "1000"),
            ("62", "62.5"),
            ("1024", "1000"),
        ] {
            let why = bit_rate(text).unwrap_err();
            assert!(why.ends_with(&format!(". Did you mean {meant}?")), "{why}");
        }
        for text in ["", "fast", "-250", "0", "1", "1e9", "9999999999"] {
            let why = bit_rate(text).unwrap_err();
            assert!(why.ends_with("kbit/s"), "{text}: {why}");
        }
        assert_eq!(bit_rate("62.5"), Ok(BitRate::K62_5));
    }
}
