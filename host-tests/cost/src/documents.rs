//! The tables in the documents, which `cost --record` writes.

use super::{Report, tables};
use std::io;
use std::path::Path;

/// The end of the line before a table.
const BEGIN: &str = "written by cargo run --release --bin cost -- --record -->\n";
/// The line after a table.
const END: &str = "<!-- end -->";

/// The model whose figures are in the README of the project.
const SUMMARY: &str = "is2";

/// Writes the figures of all products into the documents.
///
/// # Errors
/// A document cannot be read or written, or has no place for its table.
pub fn write(reports: &[Report]) -> io::Result<()> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    replace(&own.join("README.md"), &tables::markdown(reports))?;
    match reports.iter().find(|report| report.model == SUMMARY) {
        Some(report) => replace(&own.join("../../README.md"), &tables::summary(report)),
        None => Ok(()),
    }
}

fn replace(document: &Path, table: &str) -> io::Result<()> {
    let text = std::fs::read_to_string(document)?;
    let text = replaced(&text, table).ok_or_else(|| {
        let document = document.display();
        io::Error::other(format!("{document} has no place for the table"))
    })?;
    std::fs::write(document, text)
}

/// The text with another table; None if it has none.
fn replaced(text: &str, table: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some([before, BEGIN, table, END, after].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_between_the_marks_is_replaced() {
        let text = format!("a\n<!-- b: {BEGIN}| old |\n{END}\nc\n");
        let expected = format!("a\n<!-- b: {BEGIN}| new |\n{END}\nc\n");
        assert_eq!(replaced(&text, "| new |\n"), Some(expected));
        assert_eq!(replaced("a\nc\n", "| new |\n"), None);
    }
}
