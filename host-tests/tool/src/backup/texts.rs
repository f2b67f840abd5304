//! What a backup says to people: the texts of the device, and the entries that it leaves out.
//!
//! ```toml
//! [texts]
//! programming-key = "..."
//!
//! [taken]
//! teach = "relative measurement"
//! ```

use crate::sheet::Sheet;
use toml::{Table, Value};

/// The keys of the section `[sensor]` that are no texts of the device.
const KEYS: [&str; 6] = ["product", "maker", "article", "serial", "firmware", "label"];

/// The texts in a file. Files of earlier versions have them in the section `[sensor]`.
pub(super) fn read(file: &Table, sheet: &Sheet) -> Vec<(String, String)> {
    let section = |name: &str| file.get(name).and_then(Value::as_table);
    let (texts, sensor) = (section("texts"), section("sensor"));
    let text = |name: &str| {
        let old = || sensor.filter(|_| !KEYS.contains(&name))?.get(name);
        let text = texts.and_then(|texts| texts.get(name)).or_else(old)?;
        Some((name.to_owned(), text.as_str()?.to_owned()))
    };
    let names = sheet.texts().map(|entry| entry.name.as_str());
    names.filter_map(text).collect()
}

/// What the section of the positions says to people.
pub(super) const TAKEN: &str = "# Taken from the position of this sensor. No other sensor can be given it: repeat it there, in the same position.\n";

/// What the sensor had taken from its position.
pub(super) fn taken(file: &Table, sheet: &Sheet) -> Vec<(String, String)> {
    let section = file.get("taken").and_then(Value::as_table);
    let text = |name: &str| Some((name.to_owned(), section?.get(name)?.as_str()?.to_owned()));
    let names = sheet.positions().map(|entry| entry.name.as_str());
    names.filter_map(text).collect()
}

/// A section with texts, and what it says to people; empty if there are none.
pub(super) fn section(name: &str, about: &str, texts: &[(String, String)]) -> String {
    let line = |(name, text): &(String, String)| format!("{name} = {}\n", Value::from(&text[..]));
    match texts {
        [] => String::new(),
        texts => {
            let lines: String = texts.iter().map(line).collect();
            format!("\n{about}[{name}]\n{lines}")
        }
    }
}

/// The names of the entries that are left out; empty if there are none.
pub(super) fn left_out(sheet: &Sheet) -> String {
    let names: Vec<&str> = sheet.commands().map(|entry| entry.name.as_str()).collect();
    match names[..] {
        [] => String::new(),
        _ => format!(
            "\n# Skipped, because a write is a command or changes process data: {}\n",
            names.join(", ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backup::Backup;
    use crate::eds;
    use crate::identify::product;

    /// A device with texts whose names are keys of the file, and with process data.
    const DEVICE: &str = "[DeviceInfo]\nProductName=Drive\n\
        [2000]\nParameterName=Label\nDataType=9\nAccessType=rw\n\
        [2001]\nParameterName=Product\nDataType=9\nAccessType=rw\n\
        [2002]\nParameterName=Serial\nDataType=9\nAccessType=rw\n\
        [2003]\nParameterName=Ramp\nDataType=6\nAccessType=rw\n\
        [6040]\nParameterName=Controlword\nDataType=6\nAccessType=rw\nPDOMapping=1\n";

    #[test]
    fn texts_with_names_of_the_file_are_read_again_and_are_not_its_name() {
        let sheet = eds::parse(DEVICE.as_bytes()).unwrap();
        let mut backup = Backup::of(&sheet);
        for name in ["label", "product", "serial"] {
            backup
                .texts
                .push((name.to_owned(), "a \"b\"\n\u{7}".to_owned()));
        }
        let text = backup.text();
        let read = Backup::parse_with(&text, Some(&sheet)).unwrap();
        assert_eq!((&read.label, read.serial), (&None, None), "{text}");
        assert_eq!(read.texts, backup.texts);
        assert_eq!(read.text(), text);
    }

    #[test]
    fn texts_of_an_earlier_file_are_kept() {
        let text = "[sensor]\nproduct = \"jn2101\"\nlabel = \"boom\"\nprogramming-key = \"k\"\nmaker = 5\n[parameters]\n";
        let read = Backup::parse(text).unwrap();
        let key = ("programming-key".to_owned(), "k".to_owned());
        assert_eq!(read.texts, [key]);
        assert_eq!(read.label.as_deref(), Some("boom"));
        let written = read.text();
        assert!(
            written.contains("\n[texts]\nprogramming-key = \"k\"\n"),
            "{written}"
        );
        assert_eq!(Backup::parse(&written).unwrap().texts, read.texts);
        // A text of the file that the device does not have.
        let unknown = text.replace("[parameters]", "[texts]\nnonsense = \"x\"\n[parameters]");
        assert_eq!(Backup::parse(&unknown).unwrap().texts, read.texts);
    }

    #[test]
    fn entries_that_are_left_out_are_named_in_the_file() {
        let sheet = eds::parse(DEVICE.as_bytes()).unwrap();
        let mut backup = Backup::of(&sheet);
        backup.set("ramp", "7").unwrap();
        let text = backup.text();
        assert!(text.ends_with("ramp = \"7\"\n\n# Skipped, because a write is a command or changes process data: controlword\n"), "{text}");
        let read = Backup::parse_with(&text, Some(&sheet)).unwrap();
        assert_eq!(read.text(), text);
        // It is no setting, so a file with it is refused.
        let changed = text.replace("ramp = ", "controlword = \"15\"\nramp = ");
        let why = Backup::parse_with(&changed, Some(&sheet)).unwrap_err();
        let why = why.to_string();
        assert!(why.contains("controlword cannot be stored"), "{why}");
        // All that is in the tables of a product is there for a purpose.
        let sheet = Sheet::of(product("jn2101").unwrap());
        assert_eq!(left_out(&sheet), "");
    }
}
