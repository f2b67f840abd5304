//! The words of a command line.

use super::Cli;
use super::options::command;
use crate::question::Name;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{FromArgMatches, ValueEnum};
use std::ffi::OsString;

/// Parses the words of a command line. The names of questions can also follow `--yes` without `=`, where they are no other argument: in
/// `--yes zero` the word is the command.
///
/// # Errors
/// The words are no command line.
pub fn parse(words: &[OsString]) -> Result<Cli, clap::Error> {
    let parsed = |words: &[OsString]| {
        let matches = command().try_get_matches_from(words);
        matches.and_then(|matches| Cli::from_arg_matches(&matches))
    };
    parsed(words).or_else(|error| {
        // A word that is no argument and no name of a question: the error of its value lists the names.
        let wrong = match error.get(ContextKind::InvalidArg) {
            Some(ContextValue::String(wrong)) if !wrong.starts_with('-') => Some(&**wrong),
            _ => None,
        };
        parsed(&joined(words, wrong)).map_err(|named| match named.kind() {
            ErrorKind::InvalidValue => named,
            _ => error,
        })
    })
}

/// The same words, with `=` between `--yes` and names of questions, or this word.
fn joined(words: &[OsString], wrong: Option<&str>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = Vec::new();
    for word in words {
        let text = word.to_str().unwrap_or_default();
        let mut names = text.split(',');
        let is_named = names.all(|name| Name::from_str(name, false).is_ok());
        match joined.last_mut() {
            Some(last) if (is_named || wrong == Some(text)) && last == "--yes" => {
                last.push("=");
                last.push(word);
            }
            _ => joined.push(word.clone()),
        }
    }
    joined
}
