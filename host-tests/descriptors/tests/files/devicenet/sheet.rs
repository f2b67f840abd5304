//! A data sheet of a DeviceNet product as ODVA defines it: sections with entries of fields.

/// The fields of an entry.
pub type Fields = Vec<String>;

/// The sections of a data sheet, each with its entries in their order.
pub struct Sheet(pub Vec<(String, Vec<(String, Fields)>)>);

impl Sheet {
    /// Reads a data sheet: comments begin with `$`, an entry ends with `;`.
    pub fn parse(text: &str) -> Self {
        let mut sections: Vec<(String, Vec<(String, Fields)>)> = Vec::new();
        for line in text.lines() {
            let line = line.split('$').next().unwrap_or("").trim();
            if line.is_empty() {
                continue;
            }
            if let Some(name) = line
                .strip_prefix('[')
                .and_then(|line| line.strip_suffix(']'))
            {
                sections.push((name.to_owned(), Vec::new()));
                continue;
            }
            let entry = line.strip_suffix(';').expect("an entry ends with ;");
            let (key, value) = entry.split_once('=').expect("an entry has a key");
            let (_, entries) = sections.last_mut().expect("an entry is in a section");
            entries.push((key.trim().to_owned(), fields(value)));
        }
        Self(sections)
    }

    pub fn section(&self, name: &str) -> &[(String, Fields)] {
        let found = self.0.iter().find(|(section, _)| section == name);
        let (_, entries) = found.unwrap_or_else(|| panic!("no section {name}"));
        entries
    }

    pub fn get(&self, section: &str, key: &str) -> &Fields {
        let mut entries = self.section(section).iter();
        let found = entries.find(|(name, _)| name == key);
        let (_, fields) = found.unwrap_or_else(|| panic!("no {key} in {section}"));
        fields
    }

    pub fn number(&self, section: &str, key: &str) -> i64 {
        number(&self.get(section, key)[0])
    }

    pub fn text(&self, section: &str, key: &str) -> &str {
        &self.get(section, key)[0]
    }
}

/// The fields between commas outside of quotes; quotes are removed.
pub fn fields(value: &str) -> Fields {
    let (mut fields, mut quoted) = (vec![String::new()], false);
    for letter in value.trim().chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            ' ' if !quoted => {}
            _ => fields.last_mut().expect("a field").push(letter),
        }
    }
    assert!(!quoted, "{value}");
    fields
}

pub fn number(text: &str) -> i64 {
    let number = match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The types with their sizes and whether they are signed.
pub const TYPES: [(i64, usize, bool); 4] = [
    (0xC3, 2, true),
    (0xC4, 4, true),
    (0xC6, 1, false),
    (0xC7, 2, false),
];

/// Bits of the descriptor of a parameter.
pub const ENUMERATED: i64 = 1 << 1;
pub const READ_ONLY: i64 = 1 << 4;
pub const MONITOR: i64 = 1 << 5;

/// The named values of a parameter.
pub fn enumerated(sheet: &Sheet, place: usize, low: i64) -> Vec<i64> {
    let mut params = sheet.section("Params").iter();
    if let Some((_, fields)) = params.find(|(name, _)| *name == format!("Enum{place}")) {
        assert!(fields.len().is_multiple_of(2));
        return fields
            .iter()
            .step_by(2)
            .map(|field| number(field))
            .collect();
    }
    let names = sheet.get("EnumPar", &format!("Param{place}"));
    (low..).take(names.len()).collect()
}
