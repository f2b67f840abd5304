//! From what a user types to entries of a sheet: full names, names of groups, abbreviations.

use crate::error::{Error, NumberError, RequestError};
use crate::known::meant;
use crate::meaning::Named;
use crate::sheet::{Entry, Sheet, kebab};

/// The entries that a name means: one entry, or the entries of a group.
///
/// A name is the full name, or the beginnings of some of its words in their order: `zero-x`, `cyclic-t`.
///
/// # Errors
/// No entry has this name, or several have.
pub fn entries<'a>(sheet: &'a Sheet, name: &str) -> Result<Vec<&'a Entry>, Error> {
    let wanted = kebab(name);
    if let Some(entry) = sheet.entries.iter().find(|entry| entry.name == wanted) {
        return Ok(vec![entry]);
    }
    let groups = sheet.product.guide.groups;
    if let Some((_, ids)) = groups.iter().find(|(group, _)| *group == wanted) {
        return Ok(ids.iter().filter_map(|id| sheet.parameter(*id)).collect());
    }
    let matches: Vec<&Entry> = sheet
        .entries
        .iter()
        .filter(|entry| {
            abbreviates(&wanted, &entry.name) || abbreviates(&wanted, &kebab(&entry.title))
        })
        .collect();
    match matches[..] {
        [only] => Ok(vec![only]),
        [] => {
            let names = sheet.entries.iter().map(|entry| entry.name.as_str());
            let groups = groups.iter().map(|(group, _)| *group);
            Err(RequestError::UnknownName(
                sheet.product.name,
                name.to_owned(),
                meant(&wanted, names.chain(groups)),
            )
            .into())
        }
        _ => {
            let names: Vec<&str> = matches.iter().map(|entry| entry.name.as_str()).collect();
            Err(RequestError::AmbiguousName(name.to_owned(), names.join(", ")).into())
        }
    }
}

/// Whether each word of `short` is the beginning of a word of `name`, in the same order.
fn abbreviates(short: &str, name: &str) -> bool {
    let mut words = name.split('-');
    !short.is_empty()
        && short
            .split('-')
            .all(|part| words.any(|word| word.starts_with(part)))
}

/// An assignment that has been checked: an entry and the text of its value.
pub type Assignment<'a> = (&'a Entry, String);

/// The assignments of `NAME=VALUE`; a group takes its values in any order, separated by commas: `filter=2.5Hz,butterworth`.
///
/// # Errors
/// A name or a value is wrong.
pub fn assignments<'a>(sheet: &'a Sheet, text: &str) -> Result<Vec<Assignment<'a>>, Error> {
    let Some((name, value)) = text.split_once('=') else {
        return Err(RequestError::NoAssignment(text.to_owned()).into());
    };
    let found = entries(sheet, name)?;
    let group = match found[..] {
        [_] if value.contains(',') => with_group(sheet, name, found),
        _ => found,
    };
    if let [only] = group[..] {
        return Ok(vec![(only, value.to_owned())]);
    }
    let mut left: Vec<&Entry> = group.clone();
    let mut taken = Vec::new();
    for part in parts(value) {
        let fits = |entry: &&Entry| entry.parse(part).is_ok();
        let Some(place) = left.iter().position(fits) else {
            let mut wrong = left.iter().filter_map(|entry| entry.parse(part).err());
            let wrong = wrong.find(NumberError::is_out_of_range);
            if let Some(wrong) = wrong {
                return Err(wrong.into());
            }
            let names = Named::of(|language| {
                let names = group.iter();
                let names =
                    names.map(|entry| format!("{} ({})", entry.name, entry.range_in(language)));
                names.collect::<Vec<_>>().join("; ")
            });
            return Err(NumberError::FitsNone(name.to_owned(), part.to_owned(), names).into());
        };
        taken.push((left.remove(place), part.trim().to_owned()));
    }
    Ok(taken)
}

/// The values of a group. A comma between two digits is a decimal comma.
fn parts(value: &str) -> Vec<&str> {
    let is_digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_digit);
    let bytes = value.as_bytes();
    let (mut parts, mut start) = (Vec::new(), 0);
    for (place, _) in value.match_indices(',') {
        let is_decimal =
            place > start && is_digit(bytes.get(place - 1)) && is_digit(bytes.get(place + 1));
        if !is_decimal {
            parts.push(&value[start..place]);
            start = place + 1;
        }
    }
    parts.push(&value[start..]);
    parts
}

/// The group that contains an entry, if there is one.
fn with_group<'a>(sheet: &'a Sheet, name: &str, found: Vec<&'a Entry>) -> Vec<&'a Entry> {
    // A name with a comma that is no group: the value is wrong, and its entry says so.
    let wanted = kebab(name);
    let mut groups = sheet.product.guide.groups.iter();
    match groups.find(|(group, _)| group.starts_with(wanted.as_str())) {
        Some((_, ids)) => ids.iter().filter_map(|id| sheet.parameter(*id)).collect(),
        None => found,
    }
}

#[cfg(test)]
mod tests;
