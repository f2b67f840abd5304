//! The questions of a scan on a bus that is in use: they go back to the page, and without a yes nothing is sent.

use crate::client::{Answer, Running};
use crate::foreign::{heartbeat, opener, unknown};
use serde_json::{Value, json};

fn scan(server: &Running, boxes: Value, yes: &[&str]) -> Answer {
    let mut body = json!({"port": "demo:is2", "rate": 250, "yes": yes});
    for (name, is_checked) in boxes.as_object().into_iter().flatten() {
        body[name] = is_checked.clone();
    }
    server.post("/api/scan", &body.to_string())
}

#[track_caller]
fn question(answer: &Answer) -> String {
    assert_eq!((answer.status, answer.code().as_str()), (400, "asks"));
    let message = answer.json()["error"]["message"].clone();
    message.as_str().unwrap_or_default().to_owned()
}

#[test]
fn bus_with_traffic_is_asked_only_after_the_yes_to_its_question() {
    let (opener, witness) = opener(unknown(), false);
    let server = Running::with(opener);
    for boxes in [json!({"active": true}), json!({"search": true})] {
        let text = question(&scan(&server, boxes.clone(), &[]));
        assert!(text.contains("There is traffic"), "{text}");
        // A yes to another question is no yes.
        let other = "There is no traffic. Ask at all addresses and bit rates?";
        assert_eq!(question(&scan(&server, boxes.clone(), &[other])), text);
        assert_eq!(witness.sent(), [0; 0]);
        let found = scan(&server, boxes, &[&text]);
        assert_eq!(found.status, 200, "{found:?}");
        assert_eq!(found.json()[0]["address"], "300");
        assert!(witness.sent().contains(&0x300));
    }
    // Without a checked box the answer is no.
    let silent = scan(&server, json!({}), &[]);
    assert_eq!(
        (silent.status, silent.code().as_str()),
        (504, "nothing-found")
    );
    assert_eq!(witness.sent(), [0; 0]);
}

#[test]
fn search_beside_a_node_that_was_heard_runs_after_the_yes() {
    let (opener, witness) = opener(heartbeat(), false);
    let server = Running::with(opener);
    let mut tab = server.tab();
    let boxes = json!({"active": true, "search": true});
    let text = question(&scan(&server, boxes.clone(), &[]));
    assert!(text.starts_with("Search for more sensors?"), "{text}");
    // The node whose heartbeat was heard is asked who it is. The page shows it behind the question.
    assert!(witness.sent().iter().all(|id| *id == 0x622));
    let found = tab.wait("found", |rows| rows != &json!([]));
    assert_eq!(found[0]["address"], "34");
    assert_eq!(scan(&server, boxes, &[&text]).status, 200);
    let sent = witness.sent();
    for id in [0x001, 0x305, 0x621, 0x7FF] {
        assert!(sent.contains(&id), "{id:X}");
    }
    // Identifiers of network management, and the identifier of the heartbeat.
    for id in [0x000, 0x080, 0x722] {
        assert!(!sent.contains(&id), "{id:X}");
    }
}
