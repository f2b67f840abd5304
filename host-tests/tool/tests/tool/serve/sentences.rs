//! The German texts of the questions and steps: they belong to the texts of the program.

const TEXTS: &str = include_str!("../../../assets/sentences-de.js");

/// Where the program asks before it sends, and tells its steps.
const SOURCES: [&str; 5] = [
    include_str!("../../../src/connect.rs"),
    include_str!("../../../src/scan/mod.rs"),
    include_str!("../../../src/scan/listen.rs"),
    include_str!("../../../src/scan/active.rs"),
    include_str!("../../../src/serve/worker/which.rs"),
];

/// The parts of a text between what changes.
fn parts(text: &str) -> Vec<&str> {
    let parts = text.split(['{', '}']).step_by(2);
    parts.filter(|part| part.len() > 4).collect()
}

/// The English texts of the table.
fn english() -> Vec<&'static str> {
    let rows = TEXTS.lines().filter_map(|line| line.strip_prefix("  [\""));
    rows.filter_map(|row| row.split('"').next()).collect()
}

#[test]
fn each_german_sentence_has_the_text_of_the_program() {
    let texts = english();
    assert!(texts.len() > 20, "{texts:?}");
    for text in texts {
        for part in parts(text) {
            // The program puts some texts together.
            let part = part
                .trim_end_matches([' ', '(', ','])
                .trim_end_matches(" at");
            let is_said = SOURCES.iter().any(|source| source.contains(part));
            assert!(is_said, "{part}");
        }
    }
}

#[test]
fn each_question_of_a_scan_and_a_connection_has_a_german_text() {
    let mut questions = 0;
    for source in SOURCES {
        let program = source.split("#[cfg(test)]").next().unwrap_or_default();
        for text in program.split('"').skip(1).step_by(2) {
            if text.contains("? ") || text.ends_with('?') {
                questions += 1;
                let own = parts(text);
                assert!(english().iter().any(|known| parts(known) == own), "{text}");
            }
        }
    }
    assert!(questions >= 7, "{questions}");
}
