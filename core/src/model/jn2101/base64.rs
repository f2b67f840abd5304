//! Base64 (RFC 4648, section 4) for a text of known length. It needs 150 bytes of code; the available crates need more than 1
//! KiB.

type Text = heapless::Vec<u8, { super::NAME }>;

const PADDING: u8 = b'=';

/// The text of `bytes`, padded.
pub(super) fn encode(bytes: &[u8]) -> Text {
    let mut text = Text::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().chain(&[0, 0]).take(3);
        let bits = bits.fold(0, |bits, &byte| bits << 8 | u32::from(byte));
        for place in 0..4 {
            let digit = (bits >> (18 - 6 * place) & 63) as u8;
            let character = if place <= group.len() {
                character(digit)
            } else {
                PADDING
            };
            let _ = text.push(character);
        }
    }
    text
}

/// The `N` bytes of a text; None unless the text is exactly the result of [`encode`].
pub(super) fn decode<const N: usize>(text: &[u8]) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    for (group, place) in text.chunks(4).zip(bytes.chunks_mut(3)) {
        let bits = group.iter().try_fold(0, |bits, &character| {
            Some(bits << 6 | u32::from(digit(character)?))
        })?;
        let [_, decoded @ ..] = bits.to_be_bytes();
        for (to, from) in place.iter_mut().zip(decoded) {
            *to = from;
        }
    }
    (encode(&bytes) == text).then_some(bytes)
}

fn character(digit: u8) -> u8 {
    match digit {
        0..=25 => b'A' + digit,
        26..=51 => b'a' + (digit - 26),
        52..=61 => b'0' + (digit - 52),
        62 => b'+',
        _ => b'/',
    }
}

/// The value of a character; padding has the value 0.
fn digit(character: u8) -> Option<u8> {
    match character {
        b'A'..=b'Z' => Some(character - b'A'),
        b'a'..=b'z' => Some(character - b'a' + 26),
        b'0'..=b'9' => Some(character - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        PADDING => Some(0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encode_and_decode_match_vectors_of_rfc() {
        for (plain, text) in [
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(encode(plain.as_bytes()), text.as_bytes());
        }
        assert_eq!(decode(b"Zm9vYmE="), Some(*b"fooba"));
        assert_eq!(encode(&[0xFB, 0xFF, 0xFE]), *b"+//+");
        assert_eq!(decode(b"+//+"), Some([0xFB, 0xFF, 0xFE]));
    }

    #[test]
    fn non_canonical_text_is_refused() {
        // Padding in the wrong place, unused bits that are not 0, wrong lengths and characters.
        for text in [
            "Zm9vYm==",
            "Zm9vYmF=",
            "Zm9vYm",
            "Zm9vYmE=AAAA",
            "Zm9vYmE ",
            "=m9vYmE=",
            "",
        ] {
            assert_eq!(decode::<5>(text.as_bytes()), None, "{text}");
        }
    }
}
