//! The entries of a DeviceNet file and their fields. What is no part of an entry never changes a field of it.

use crate::error::Fault;
use std::collections::HashMap;
use texts::shown;

/// Entries by section and key, both in small letters.
pub(super) type Fields = HashMap<(String, String), Vec<String>>;

/// The entries of a file, and the lines between entries that are none.
///
/// # Errors
/// One sentence with the line that cannot be read. A missing semicolon would give the next entry to the one before, and a line in an entry
/// that is no part of it would change one of its values.
pub(super) fn fields(text: &str) -> Result<(Fields, Vec<usize>), Fault> {
    let mut all = Fields::new();
    let mut ignored = Vec::new();
    let (mut section, mut key) = (String::new(), None);
    let (mut done, mut field) = (Vec::new(), String::new());
    let (mut is_quoted, mut is_comment, mut is_name) = (false, false, false);
    // The lines of the last letter, of the last one on a line before, and of the key.
    let (mut line, mut last, mut before, mut begin) = (1, 1, 1, 1);
    // The lines of the last `;`, of the last letter of the value, and of its last letter that is not quoted.
    let (mut ended, mut filled, mut bare) = (0, None, None);
    // Whether the line has only commas so far, and the first line of the entry that has nothing else.
    let (mut is_commas, mut commas) = (false, None);
    let small = |text: &str| text.trim().to_ascii_lowercase();
    let mut letters = text.char_indices();
    while let Some((place, letter)) = letters.next() {
        if letter == '\n' {
            if is_quoted {
                return Err(Fault::OpenQuote(line));
            }
            if key.is_none() && !(field.is_empty() && done.is_empty()) {
                ignored.push(line);
                field.clear();
                done.clear();
            }
            if is_commas && last == line {
                commas = commas.or(Some(line));
            }
            is_comment = false;
            line += 1;
            continue;
        }
        if is_comment || (letter.is_whitespace() && !is_quoted) {
            continue;
        }
        if letter == '$' && !is_quoted {
            is_comment = true;
            continue;
        }
        let is_first = last != line;
        if is_first {
            (before, last) = (last, line);
        }
        is_commas = letter == ',' && !is_quoted && (is_first || is_commas);
        let is_bare = !is_quoted && !"\"=[,;".contains(letter);
        if key.is_some() && !is_quoted && (is_bare || letter == '"') {
            // Two texts without a comma between them are one, but not a word and what is on another line.
            if let Some(own) = filled.filter(|own| *own != line && (is_bare || bare.is_some())) {
                return Err(match rest(text, place).contains('=') {
                    true => Fault::NoSemicolon(own),
                    false => Fault::NoPart(bare.unwrap_or(line)),
                });
            }
            filled = Some(line);
            bare = bare.or(is_bare.then_some(line));
        }
        if matches!(letter, '=' | ',' | ';') && !is_quoted {
            (filled, bare) = (None, None);
        }
        match letter {
            '"' => is_quoted = !is_quoted,
            '\\' if is_quoted && is_escape(&text[place + 1..]) => {
                letters.next();
                field.push('"');
            }
            _ if is_quoted => field.push(letter),
            '=' if is_first => return Err(Fault::NoEntryLine(line)),
            '[' if !has_name(rest(text, place)) => return Err(Fault::OpenBracket(line)),
            '=' | '[' if key.is_some() => {
                let line = before.max(begin);
                return Err(Fault::NoSemicolon(line));
            }
            '[' => {
                field.clear();
                is_name = true;
            }
            ']' if is_name => {
                section = small(&std::mem::take(&mut field));
                is_name = false;
                ended = 0;
            }
            '=' => {
                key = Some(small(&std::mem::take(&mut field)));
                begin = line;
                commas = None;
            }
            ',' => done.push(std::mem::take(&mut field).trim().to_owned()),
            ';' => {
                done.push(std::mem::take(&mut field).trim().to_owned());
                let value = std::mem::take(&mut done);
                let own = key.take().filter(|key: &String| !key.is_empty());
                let own = own.ok_or_else(|| {
                    // The lines since the last entry are the beginning of what is none.
                    let first = ignored.iter().find(|line| **line > ended);
                    let first = first.copied().unwrap_or(line);
                    match ended {
                        0 => Fault::NoEntryLine(first),
                        ended => Fault::EndsBefore(ended, first),
                    }
                })?;
                if let Some(line) = commas.filter(|_| !is_complete(&section, &own, value.len())) {
                    return Err(Fault::OnlyCommas(line, value.len()));
                }
                ended = line;
                all.insert((section.clone(), own), value);
            }
            // Two texts without a comma between them are one.
            letter => field.push(letter),
        }
    }
    match key {
        Some(key) => Err(Fault::NoEnd(last, shown(&key))),
        None => Ok((all, ignored)),
    }
}

/// Whether an entry has all its fields, so that a line of commas in it stands for empty ones: a parameter has 21, or 24 with the names in
/// other languages.
fn is_complete(section: &str, key: &str, count: usize) -> bool {
    match section {
        "params" if key.starts_with("param") => matches!(count, 21 | 24),
        "params" if key.starts_with("enum") => count.is_multiple_of(2),
        "device" => count == 1,
        _ => true,
    }
}

/// What is on the same line.
fn rest(text: &str, place: usize) -> &str {
    text[place..].lines().next().unwrap_or_default()
}

/// Whether this is the name of a section in brackets.
fn has_name(line: &str) -> bool {
    let name = line.strip_prefix('[').and_then(|line| line.split_once(']'));
    name.is_some_and(|(name, _)| !name.trim().is_empty() && !name.contains(['[', '$', '=', ';']))
}

/// Whether a backslash in a text is before a quotation mark of the text. One at the end of the text is a letter: `"C:\"`.
fn is_escape(rest: &str) -> bool {
    let behind = rest.strip_prefix('"').map(str::trim_start);
    behind.is_some_and(|behind| !behind.is_empty() && !behind.starts_with([',', ';']))
}
