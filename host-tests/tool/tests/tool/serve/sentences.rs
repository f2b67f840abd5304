//! The texts of the page: each question has one in both languages, and the German steps belong to the texts of the program.

use crate::serve::client::Running;
use plumbline_tool::question::Question;
use serde_json::json;

const TEXTS: &str = include_str!("../../../assets/sentences-de.js");

/// Where the program tells its steps.
const SOURCES: [&str; 7] = [
    include_str!("../../../src/error/page.rs"),
    include_str!("../../../src/error/sensor.rs"),
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
    assert!(texts.len() > 12, "{texts:?}");
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

/// The texts of the page.
const LANGUAGES: [&str; 2] = [
    include_str!("../../../assets/texts-en.js"),
    include_str!("../../../assets/texts-de.js"),
];

#[test]
fn each_question_has_a_text_in_both_languages() {
    // The error of serde names all ids.
    let error = serde_json::from_str::<Question>(r#"{"id":""}"#).unwrap_err();
    let error = error.to_string();
    let ids: Vec<&str> = error.split('`').skip(3).step_by(2).collect();
    assert_eq!(ids.len(), 10, "{error}");
    for id in ids {
        for texts in LANGUAGES {
            assert!(texts.contains(&format!("\"question-{id}\": \"")), "{id}");
        }
    }
}

#[test]
fn error_and_its_action_have_both_texts_of_the_page_instead_of_a_command() {
    let server = Running::new();
    let mut tab = server.tab();
    let wanted = json!({
        "port": "demo:jn2101", "mode": "active", "protocol": "canopen", "address": "77", "rate": 125,
    });
    let refused = server.post("/api/connect", &wanted.to_string());
    let texts = refused.json()["texts"].clone();
    for (language, [start, next]) in [
        (
            "en",
            [
                "nobody answers at node-ID 77 at 125 kbit/s: check power",
                "press Find sensors.",
            ],
        ),
        (
            "de",
            [
                "niemand antwortet auf node-ID 77 bei 125 kbit/s: Prüfen",
                "drücken Sie Sensoren suchen.",
            ],
        ),
    ] {
        let text = texts[language].as_str().unwrap_or_default();
        assert!(text.starts_with(start) && text.ends_with(next), "{texts}");
    }
    let action = tab.wait("action", |action| action["state"] == "failed");
    assert_eq!(action["texts"], texts);
}
