//! The texts that the program sends to the page, in both languages.

use crate::serve::client::Running;
use plumbline_tool::question::Question;
use serde_json::json;
use texts::Text;

#[test]
fn question_has_its_texts_and_the_object_of_a_yes() {
    let server = Running::new();
    let asked = server.post("/api/scan", r#"{"port":"demo:is2"}"#).json();
    let texts = json!({
        "en": "There is no traffic. Send requests to all addresses at all bit rates?",
        "de": "Es gibt keinen Verkehr. Auf allen Adressen und Bitraten fragen?",
    });
    let question = json!({"id": "silent"});
    assert_eq!(asked["error"]["questions"], json!([question]));
    assert_eq!(
        asked["asks"],
        json!([{"question": question, "texts": texts}])
    );
}

#[test]
fn questions_with_optional_data_have_the_same_objects_as_before() {
    let doubt = json!({"what": "vendor", "wanted": "1h", "own": null});
    for (object, german) in [
        (
            json!({"id": "take-part", "rate": null}),
            "(die Bitrate der Schnittstelle)",
        ),
        (
            json!({"id": "take-part", "rate": "125 kbit/s"}),
            "(125 kbit/s)",
        ),
        (
            json!({"id": "other-product", "told": "is2", "article": "A", "version": null, "product": "is1"}),
            "(Artikel A)",
        ),
        (
            json!({"id": "other-product", "told": "is2", "article": "A", "version": "3.44", "product": "is1"}),
            "(Artikel A, Softwareversion 3.44)",
        ),
        (
            json!({"id": "data-sheet", "doubts": [doubt]}),
            "vendor 1h im Datenblatt, nicht lesbar im Gerät",
        ),
    ] {
        let question: Question = serde_json::from_value(object.clone()).expect("a question");
        assert!(question.german().contains(german), "{question:?}");
        assert_eq!(serde_json::to_value(question).expect("an object"), object);
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
                "no answer at node-ID 77 at 125 kbit/s: check power",
                "\"No answer\" of EXCHANGE.md",
            ],
        ),
        (
            "de",
            [
                "niemand antwortet auf node-ID 77 bei 125 kbit/s: Prüfen",
                "\"Niemand antwortet\" von AUSTAUSCH.md",
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
