//! Which frames of a log are shown: by identifier and mask as with `candump`, by words of their meaning, by the address of a sensor.

use super::Decoded;
use plumbline::can::Frame;
use std::str::FromStr;

/// One of several conditions, of which one is sufficient.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Term {
    /// Identifier, mask, 29 bits, and whether all other identifiers are taken.
    Id(u32, u32, bool, bool),
    /// Words of the meaning, in lower case.
    Words(String),
}

/// The highest identifiers.
const STANDARD: u32 = 0x7FF;
const EXTENDED: u32 = 0x1FFF_FFFF;

impl FromStr for Term {
    type Err = String;

    /// `181`, `80`, `18EEFF80`, `181:7F0`, `181~7F0`, or words. One or two digits with a letter are words: `f1` can be a name.
    fn from_str(text: &str) -> Result<Self, String> {
        let masked = text.split_once(':').map(|parts| (parts, false));
        let masked = masked.or_else(|| text.split_once('~').map(|parts| (parts, true)));
        let number = |text: &str| {
            let is_number =
                (1..=8).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
            u32::from_str_radix(text, 16).ok().filter(|_| is_number)
        };
        let highest = |digits: &str| match digits.len() {
            8 => EXTENDED,
            _ => STANDARD,
        };
        if let Some(((id, mask), is_other)) = masked {
            let (highest, is_extended) = (highest(id), id.len() == 8);
            let parts = (number(id).filter(|id| *id <= highest), number(mask));
            let (Some(id), Some(mask)) = parts else {
                return Err("an identifier has up to 3 hexadecimal digits or 8, and so has its mask: 181:7F0".into());
            };
            return Ok(Self::Id(id, mask & highest, is_extended, is_other));
        }
        let is_short = text.len() < 3 && text.bytes().all(|byte| byte.is_ascii_digit());
        match number(text).filter(|_| is_short || matches!(text.len(), 3 | 8)) {
            Some(id) if id <= highest(text) => {
                Ok(Self::Id(id, highest(text), text.len() == 8, false))
            }
            Some(_) => {
                Err("an identifier of 11 bits is up to 7FF, one of 29 bits up to 1FFFFFFF".into())
            }
            None if text.trim().is_empty() => Err("give an identifier or words".into()),
            None => Ok(Self::Words(text.trim().to_lowercase())),
        }
    }
}

impl Term {
    fn takes(&self, frame: &Frame, meaning: &str) -> bool {
        match self {
            Self::Id(id, mask, is_extended, is_other) => {
                let own = frame.can_id().bits();
                let is_own = own & mask == id & mask && (own > EXTENDED) == *is_extended;
                is_own != *is_other
            }
            Self::Words(words) => has_words(meaning, words),
        }
    }
}

/// Whether a text has these words, not as a part of others.
fn has_words(text: &str, words: &str) -> bool {
    let is_part = |letter: Option<char>| letter.is_some_and(char::is_alphanumeric);
    text.match_indices(words).any(|(place, _)| {
        let before = text[..place].chars().next_back();
        let behind = text[place + words.len()..].chars().next();
        !is_part(before) && !is_part(behind)
    })
}

/// The frames that are shown.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Without terms, all.
    pub terms: Vec<Term>,
    /// Only those of the sensor with this protocol and address.
    pub sensor: Option<(&'static str, String)>,
}

impl Filter {
    /// Whether the meaning of a frame decides.
    pub fn needs_meaning(&self) -> bool {
        let mut terms = self.terms.iter();
        self.sensor.is_some() || terms.any(|term| matches!(term, Term::Words(_)))
    }

    /// Whether a frame is shown.
    pub fn takes(&self, frame: &Frame, decoded: Option<&Decoded>) -> bool {
        let is_of_sensor = self.sensor.as_ref().is_none_or(|(protocol, address)| {
            decoded.is_some_and(|decoded| decoded.protocol == *protocol && decoded.is_of(address))
        });
        let mut terms = self.terms.iter().peekable();
        let meaning = decoded.map_or(String::new(), |decoded| decoded.to_string().to_lowercase());
        is_of_sensor && (terms.peek().is_none() || terms.any(|term| term.takes(frame, &meaning)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_wire::text::frame;

    fn takes(term: &str, text: &str, meaning: &str) -> bool {
        let term: Term = term.parse().expect("a term");
        term.takes(&frame(text), meaning)
    }

    /// The forms of `candump`.
    #[test]
    fn identifier_and_mask_take_the_frames_that_candump_takes() {
        for (term, taken, others) in [
            ("181", &["181#", "181#0102"][..], &["182#", "00000181#"][..]),
            ("00000181", &["00000181#"], &["181#"]),
            ("80", &["080#"], &["180#", "00000080#"]),
            ("0", &["000#"], &["080#"]),
            ("181:7F0", &["181#", "18F#"], &["191#", "00000181#"]),
            ("181~7F0", &["191#", "00000181#"], &["181#", "18F#"]),
            ("0:0", &["000#", "7FF#"], &["00000000#"]),
            ("18EEFF80:1FFFFF00", &["18EEFF21#"], &["18EAFF21#"]),
        ] {
            for text in taken {
                assert!(takes(term, text, ""), "{term} {text}");
            }
            for text in others {
                assert!(!takes(term, text, ""), "{term} {text}");
            }
        }
    }

    #[test]
    fn words_are_not_a_part_of_others() {
        let meaning = "canopen 10 jn2101: sdo read 1018h:1 vendor-id";
        for words in ["SDO", "canopen 10", "JN2101", "sdo read", "vendor-id"] {
            assert!(takes(words, "58A#", meaning), "{words}");
        }
        for words in ["canopen 1", "JN210", "sd", "heartbeat"] {
            assert!(!takes(words, "58A#", meaning), "{words}");
        }
    }

    #[test]
    fn wrong_identifier_is_refused() {
        for text in [
            "800",
            "20000000",
            "181:",
            ":7FF",
            "18G:7FF",
            "181:7FG",
            "181~",
            "",
            " ",
            "1234:7FF5555555",
        ] {
            assert!(text.parse::<Term>().is_err(), "{text}");
        }
    }
}
