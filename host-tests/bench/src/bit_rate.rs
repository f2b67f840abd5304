//! The bit rate as an option of a program.

use plumbline::can::BitRate;

/// How users write the unit behind its prefix.
const UNITS: [&str; 9] = [
    "", "bit/s", "bits/s", "bit", "bits", "bps", "b/s", "baud", "bd",
];

/// Below this, a number without a unit is in kbit/s.
const BITS: u64 = 10_000;

/// A bit rate in bit/s as users write it: `250`, `250k`, `250 kbit/s`, `0.25M` or `250000`.
pub fn in_bits(text: &str) -> Option<u64> {
    let text = text.trim();
    let is_number = |letter: char| letter.is_ascii_digit() || matches!(letter, '.' | ',');
    let end = text.find(|letter| !is_number(letter));
    let (number, unit) = text.split_at(end.unwrap_or(text.len()));
    let (whole, part) = number.split_once(['.', ',']).unwrap_or((number, ""));
    let digits: u64 = format!("{whole}{part}").parse().ok()?;
    let unit = unit.trim_start().to_lowercase();
    let prefixes = [("k", 1000), ("m", 1_000_000)].into_iter();
    let prefixed =
        prefixes.filter_map(|(prefix, factor)| Some((unit.strip_prefix(prefix)?, factor)));
    let mut known = prefixed.filter(|(unit, _)| UNITS.contains(unit));
    let factor = match known.next() {
        Some((_, factor)) => factor,
        None if unit.is_empty() && digits < BITS => 1000,
        None if UNITS.contains(&unit.as_str()) => 1,
        None => return None,
    };
    let bits = digits.checked_mul(factor)?;
    let power = 10_u64.checked_pow(part.len().try_into().ok()?)?;
    (bits % power == 0).then_some(bits / power)
}

/// One of the ten bit rates, see [`in_bits`].
///
/// # Errors
/// The text is not one of them; the message names all of them.
pub fn bit_rate(text: &str) -> Result<BitRate, String> {
    let kbits = |rate: &BitRate| f64::from(rate.bits_per_second()) / 1000.0;
    let wanted = in_bits(text);
    BitRate::ALL
        .into_iter()
        .find(|rate| Some(u64::from(rate.bits_per_second())) == wanted)
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
            ("255k", "250"),
            ("255000", "250"),
            ("1.1M", "1000"),
            ("250 kb/h", "250"),
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
    }

    #[test]
    fn rate_is_taken_as_users_write_it() {
        for (rate, texts) in [
            (
                BitRate::K250,
                &[
                    "250",
                    "250k",
                    "250K",
                    "250kbit/s",
                    "250 kbit/s",
                    "250 kBit/s",
                    "250kbps",
                    "250 kBaud",
                    "0.25M",
                    "0,25 Mbit/s",
                    "250000",
                    "250000 bit/s",
                ][..],
            ),
            (BitRate::K62_5, &["62.5", "62,5k", "62500"]),
            (BitRate::K10, &["10", "10k", "10000"]),
            (BitRate::M1, &["1000", "1M", "1 Mbit/s", "1000k", "1000000"]),
        ] {
            for text in texts {
                assert_eq!(bit_rate(text), Ok(rate), "{text}");
            }
        }
    }
}
