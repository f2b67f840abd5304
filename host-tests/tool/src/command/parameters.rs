//! The commands `parameters` and `get`.

use crate::failure::Failure;
use crate::output::Terminal;
use crate::resolve;
use crate::session::Session;
use crate::sheet::{Entry, Origin, Sheet};
use plumbline::param::DataType;
use serde_json::{Map, Value, json};

/// Lists the names of a product with range, unit and factory value.
pub(super) fn list(sheet: &Sheet, terminal: &mut Terminal) -> Result<(), Failure> {
    let mut document = Map::new();
    terminal.line(format!("{} ({})", sheet.product.name, sheet.product.maker))?;
    let width = sheet
        .entries
        .iter()
        .map(|entry| entry.name.len())
        .max()
        .unwrap_or(0);
    for entry in &sheet.entries {
        let access = match (entry.readable, entry.writable) {
            (true, true) => "rw",
            (false, _) => "wo",
            _ => "ro",
        };
        let factory = entry.factory.map(|factory| match entry.node_relative {
            true => format!("{} + node-ID", entry.text(factory)),
            false => entry.text(factory),
        });
        let range = if entry.writable {
            entry.range()
        } else {
            String::new()
        };
        let range = match &range[..] {
            "" => entry.scale.unit.to_owned(),
            _ => range,
        };
        let range = match sheet.follows_resolution(entry) {
            true => format!("{range}, in steps of the resolution"),
            false => range,
        };
        let end = factory
            .as_ref()
            .map_or(String::new(), |factory| format!(" [factory: {factory}]"));
        terminal.line(format!("  {:width$}  {access}  {range}{end}", entry.name))?;
        let groups = sheet.product.guide.groups.iter();
        let mut groups =
            groups.filter(|(_, ids)| ids.iter().any(|id| entry.origin == Origin::Parameter(*id)));
        document.insert(
            entry.name.clone(),
            json!({
                "title": entry.title,
                "access": access,
                "range": range,
                "unit": entry.scale.unit,
                "factory": entry.factory.map(|factory| entry.json(factory)),
                "stored": entry.stored,
                "group": groups.next().map(|(name, _)| *name),
            }),
        );
    }
    for (name, ids) in sheet.product.guide.groups {
        let names = ids.iter().filter_map(|id| sheet.parameter(*id));
        let names: Vec<&str> = names.map(|entry| entry.name.as_str()).collect();
        terminal.line(format!("  {name:width$}  together: {}", names.join(", ")))?;
    }
    terminal.document(&Value::Object(document))
}

/// The name of a serial number ends with this in the sheets of all products.
const SERIAL_NUMBER: &str = "serial-number";

/// An entry that has been read.
pub(super) struct Shown {
    pub text: String,
    pub json: Value,
}

pub(super) fn show(session: &mut Session, entry: &Entry) -> Result<Shown, Failure> {
    if entry.data_type == DataType::Text {
        let bytes = session.read_bytes(entry)?;
        return Ok(shown_text(&entry.name, &bytes));
    }
    let scaled = Entry {
        scale: session.scale_of(entry)?,
        ..entry.clone()
    };
    let raw = session.read(entry)?;
    Ok(Shown {
        text: scaled.text(raw),
        json: scaled.json(raw),
    })
}

/// A text of a device. A terminal executes control characters, so a text with them is shown with their codes. A serial number of digits is a
/// number in the document, as that of the devices that report it as one.
fn shown_text(name: &str, bytes: &[u8]) -> Shown {
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
    Shown { text, json }
}

/// Reads entries and prints them; without names all that can be read.
pub(super) fn get(
    session: &mut Session,
    names: &[String],
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut entries: Vec<Entry> = Vec::new();
    for name in names {
        entries.extend(resolve::entries(&session.sheet, name)?.into_iter().cloned());
    }
    if names.is_empty() {
        let readable = session.sheet.entries.iter().filter(|entry| entry.readable);
        entries = readable.cloned().collect();
    }
    let width = entries
        .iter()
        .map(|entry| entry.name.len())
        .max()
        .unwrap_or(0);
    let mut document = Map::new();
    for entry in entries {
        let shown = match show(session, &entry) {
            // A value that is not measured yet must not hide the others.
            Err(failure) if names.is_empty() && failure.code == "refused" => Shown {
                text: format!("- ({failure})"),
                json: Value::Null,
            },
            other => other?,
        };
        terminal.line(format!("{:width$}  {}", entry.name, shown.text))?;
        document.insert(entry.name, shown.json);
    }
    terminal.document(&Value::Object(document))
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
