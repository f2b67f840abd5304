//! What a screen reader says: the names of all controls.

use crate::browser::chromium::{Browser, CONNECTED, OPEN};
use crate::serve::client::Running;
use serde_json::{Value, json};

/// The roles of nodes that need a name.
const NAMED: [&str; 18] = [
    "button",
    "checkbox",
    "combobox",
    "dialog",
    "img",
    "image",
    "graphics-document",
    "link",
    "list",
    "region",
    "searchbox",
    "slider",
    "spinbutton",
    "switch",
    "textbox",
    "alertdialog",
    "progressbar",
    "ProgressIndicator",
];

/// The nodes without a name that need one.
#[track_caller]
fn unnamed(browser: &Browser) -> Vec<String> {
    let tree = browser.devtools("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().expect("a tree").clone();
    let role = |node: &Value| {
        node["role"]["value"]
            .as_str()
            .unwrap_or_default()
            .to_owned()
    };
    let named = nodes
        .iter()
        .filter(|node| NAMED.contains(&role(node).as_str()));
    assert!(named.count() > 3, "{nodes:?}");
    let without = nodes.iter().filter(|node| {
        let name = node["name"]["value"].as_str().unwrap_or_default();
        node["ignored"] == false && NAMED.contains(&role(node).as_str()) && name.trim().is_empty()
    });
    without.map(Value::to_string).collect()
}

/// What a screen reader needs: a name for each control, list, picture and region.
pub fn every_control_has_a_name_in_both_languages(browser: &Browser) {
    let server = Running::connected("is2");
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.wait("document.querySelectorAll('#rows tr').length > 10");
    browser.wait("document.querySelectorAll('#log-rows li').length > 0");
    for language in ["de", "en"] {
        browser.choose("#language", language);
        assert_eq!(unnamed(browser), Vec::<String>::new(), "{language}");
    }
    // Of a dialog that is open, the tree has nothing else.
    browser.click("[aria-label=\"Set cut-off\"]");
    browser.wait(OPEN);
    assert_eq!(unnamed(browser), Vec::<String>::new(), "question");
    browser.click("#question-no");
}
