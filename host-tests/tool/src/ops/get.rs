//! `get`: reads parameters and values.

use super::report::{Shown, Values};
use crate::error::Error;
use crate::number::Scale;
use crate::resolve;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::param::DataType;
use serde_json::{Value, json};

/// The name of a serial number ends with this in the sheets of all products.
const SERIAL_NUMBER: &str = "serial-number";

/// Reads entries; without names all that can be read.
///
/// # Errors
/// A name is not known, the sensor refuses, nobody answers, or the adapter fails.
pub fn get(session: &mut Session, names: &[String]) -> Result<Values, Error> {
    let mut entries: Vec<Entry> = Vec::new();
    for name in names {
        entries.extend(resolve::entries(&session.sheet, name)?.into_iter().cloned());
    }
    if names.is_empty() {
        let readable = session.sheet.entries.iter().filter(|entry| entry.readable);
        entries = readable.cloned().collect();
    }
    let mut values = Vec::new();
    for entry in entries {
        values.push(match show(session, &entry) {
            // A value that is not measured yet must not hide the others.
            Err(failure @ Error::Refused(_)) if names.is_empty() => Shown {
                text: format!("- ({failure})"),
                json: Value::Null,
                name: entry.name,
            },
            other => other?,
        });
    }
    Ok(Values(values))
}

/// Reads an entry.
///
/// # Errors
/// The sensor refuses, nobody answers, or the adapter fails.
pub fn show(session: &mut Session, entry: &Entry) -> Result<Shown, Error> {
    if entry.data_type == DataType::Text {
        let bytes = session.read_bytes(entry)?;
        return Ok(shown_text(&entry.name, &bytes));
    }
    let scale = session.scale_of(entry)?;
    let raw = session.read(entry)?;
    Ok(shown(entry, scale, raw))
}

/// An entry with this raw number.
pub fn shown(entry: &Entry, scale: Scale, raw: u32) -> Shown {
    let scaled = Entry {
        scale,
        ..entry.clone()
    };
    Shown {
        name: entry.name.clone(),
        text: scaled.text(raw),
        json: scaled.json(raw),
    }
}

/// A text of a device. A terminal executes control characters, so a text with them is shown with their codes. A serial number of digits is a
/// number in the document, as that of the devices that report it as one.
pub(crate) fn shown_text(name: &str, bytes: &[u8]) -> Shown {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_end_matches('\0');
    let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
    let number = text.parse::<u64>().ok();
    let value = match number.filter(|_| name.ends_with(SERIAL_NUMBER) && is_digits) {
        Some(number) => Value::from(number),
        None => Value::from(text),
    };
    let json = json!({"value": value, "unit": ""});
    let text = match text.chars().any(char::is_control) {
        true => format!("{text:?}"),
        false => text.to_owned(),
    };
    let name = name.to_owned();
    Shown { name, text, json }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_with_control_characters_is_shown_with_their_codes() {
        let shown = shown_text("product-name", b"a\x1B]0;x\x07\0");
        assert_eq!(shown.text, "\"a\\u{1b}]0;x\\u{7}\"");
        assert_eq!(shown.json["value"], "a\u{1b}]0;x\u{7}");
        assert_eq!(shown_text("product-name", b"a \"b\"\0\0").text, "a \"b\"");
    }

    #[test]
    fn serial_number_of_digits_is_a_number_in_a_document() {
        let value =
            |name: &str, text: &str| shown_text(name, text.as_bytes()).json["value"].clone();
        assert_eq!(value(SERIAL_NUMBER, "0017"), 17);
        for text in ["", "17a", "+17", "99999999999999999999999"] {
            assert_eq!(value(SERIAL_NUMBER, text), text);
        }
        assert_eq!(value("software-version", "17"), "17");
        assert_eq!(shown_text(SERIAL_NUMBER, b"0017").text, "0017");
    }
}
