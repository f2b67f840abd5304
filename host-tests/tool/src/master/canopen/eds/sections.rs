//! The sections of a CANopen data sheet, with names in small letters, because they are compared without capitals.

use super::address;
use crate::eds::{MOST, number, too_many};
use crate::error::Fault;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use texts::shown;

/// The longest line in bytes. One of CiA 306 has 255.
const LONGEST: usize = 1024;

/// The maximum number of sections: one for each entry, for each object with sub-indices, and for its names.
const MOST_SECTIONS: usize = 3 * MOST;

/// Keys with their values. It cannot be cloned: the section of a hostile file can be as long as the file.
#[derive(Debug, Default)]
pub struct Section(HashMap<String, String>);

impl Section {
    /// The value of a key, without the comment behind it; None if it is empty.
    pub fn get(&self, key: &str) -> Option<&str> {
        let value = self.0.get(key)?;
        let value = value.split(';').next().unwrap_or_default().trim();
        Some(value).filter(|value| !value.is_empty())
    }

    /// The integer of a key.
    pub fn number(&self, key: &str) -> Option<i64> {
        self.get(key).and_then(number)
    }
}

/// The sections by name.
pub type Sections = HashMap<String, Section>;

/// The sections, and the lines that are neither a section, a new key nor a comment. Such a line changes no entry: a key that is there twice
/// has its first value, because the name of the next section can be missing before it.
///
/// # Errors
/// One sentence with the line that cannot be read. The keys behind a damaged name of a section would belong to the section before, and those
/// behind the name of an object that was there already would change this object.
pub fn sections(text: &str) -> Result<(Sections, Vec<usize>), Fault> {
    if let Some(place) = text.lines().position(|line| line.len() > LONGEST) {
        return Err(Fault::LongLine(place + 1));
    }
    let is_section = |line: &&str| line.trim_start().starts_with('[');
    if text.lines().filter(is_section).count() > MOST_SECTIONS {
        return Err(too_many());
    }
    let small = |text: &str| text.trim().to_ascii_lowercase();
    let mut sections = Sections::new();
    let mut ignored = Vec::new();
    let mut current = String::new();
    for (place, line) in text.lines().enumerate() {
        let line = line.trim();
        let damaged = || Fault::BadLine(place + 1);
        let is_nameless = |line: &str| line.trim_matches(['[', ']', ' ']).is_empty();
        if line.is_empty() || line.starts_with([';', '#']) {
        } else if line.starts_with('=') || (line.len() > 1 && is_nameless(line)) {
            ignored.push(place + 1);
        } else if let Some(rest) = line.strip_prefix('[') {
            let name = rest.split_once(']').map(|(name, _)| name);
            let name = name.filter(|name| !name.contains('['));
            let name = name.ok_or_else(damaged)?;
            current = small(name);
            if address(&current).is_some() && sections.contains_key(&current) {
                return Err(Fault::SectionTwice(place + 1, shown(&current)));
            }
            sections.entry(current.clone()).or_default();
        } else if let Some((key, value)) = line.split_once('=') {
            let section = sections.entry(current.clone()).or_default();
            match section.0.entry(small(key)) {
                Entry::Occupied(_) => ignored.push(place + 1),
                Entry::Vacant(own) => {
                    own.insert(value.trim().to_owned());
                }
            }
        } else if line.contains(['[', ']']) {
            return Err(damaged());
        } else {
            ignored.push(place + 1);
        }
    }
    Ok((sections, ignored))
}
