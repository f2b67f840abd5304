//! The texts of the page: each question has one in both languages, and the program sends its own texts in both.

use crate::serve::client::Running;
use plumbline_tool::question::Question;
use serde_json::json;

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

#[test]
fn notes_and_result_of_an_action_have_the_texts_of_the_page() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    for (request, expected) in [
        (
            json!({"set": {"assignments": ["cyclic-time=100"]}}),
            [
                "not stored yet: press Save in sensor",
                "noch nicht gespeichert: Drücken Sie Im Sensor speichern",
            ],
        ),
        (json!("save"), ["stored", "gespeichert"]),
    ] {
        assert_eq!(server.post("/api/run", &request.to_string()).status, 200);
        let [en, de] = expected;
        let texts = json!({"en": en, "de": de});
        assert_eq!(tab.wait("note", |_| true)["texts"], texts);
        tab.wait("action", |action| action["notes"] == json!([texts]));
    }
}
