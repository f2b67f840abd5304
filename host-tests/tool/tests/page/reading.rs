//! What a person reads, or hears from a screen reader: names of all controls, texts of empty states, both languages.

use crate::browser::Browser;
use crate::server::Running;
use plumbline::model::catalog::PRODUCTS;
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

/// Every node that needs a name has one, in both languages. The page is in English afterwards.
#[track_caller]
pub fn everything_is_named(browser: &Browser) {
    for language in ["de", "en"] {
        browser.choose("#language", language);
        assert_eq!(unnamed(browser), Vec::<String>::new(), "{language}");
    }
}

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
    let inputs = nodes
        .iter()
        .filter(|node| NAMED.contains(&role(node).as_str()))
        .count();
    assert!(inputs > 30, "{inputs}");
    let without = nodes.iter().filter(|node| {
        let name = node["name"]["value"].as_str().unwrap_or_default();
        node["ignored"] == false && NAMED.contains(&role(node).as_str()) && name.trim().is_empty()
    });
    without.map(Value::to_string).collect()
}

#[test]
fn every_control_has_a_name_in_both_languages() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'connected'");
    browser.wait("document.querySelectorAll('#rows tr').length > 10");
    browser.wait("document.querySelectorAll('#log-rows li').length > 0");
    everything_is_named(&browser);
    browser.choose("#language", "de");
    browser.click("[aria-label=\"cut-off setzen\"]");
    browser.wait("document.getElementById('question').open");
    assert_eq!(unnamed_in_dialog(&browser), Vec::<String>::new());
    browser.click("#question-no");
    assert_eq!(browser.console(), Vec::<String>::new());
}

#[test]
fn form_of_each_product_has_names_in_both_languages() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('template').options.length > 10");
    for product in PRODUCTS {
        browser.choose("#template", product.name);
        browser.click("#new-file");
        let state = "document.getElementById('file-state').textContent";
        let ready = format!("{state}.includes({:?})", format!("({})", product.name));
        let question = "document.getElementById('question').open";
        browser.wait(&format!("{question} || {ready}"));
        if browser.value(question) == true {
            browser.click("#question-yes");
        }
        browser.wait(&ready);
        browser.wait("document.querySelectorAll('#rows input:not(:disabled)').length > 0");
        everything_is_named(&browser);
    }
}

fn unnamed_in_dialog(browser: &Browser) -> Vec<String> {
    let tree = browser.devtools("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().expect("a tree").clone();
    let without = nodes.iter().filter(|node| {
        let role = node["role"]["value"].as_str().unwrap_or_default();
        let name = node["name"]["value"].as_str().unwrap_or_default();
        node["ignored"] == false && NAMED.contains(&role) && name.is_empty()
    });
    without.map(Value::to_string).collect()
}

#[test]
fn languages_have_the_same_texts_with_the_same_places() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    let differences = browser.script(
        "return import('/texts.js').then(({ texts: { en, de } }) => {
            const places = (text) => (text.match(/\\{\\d\\}/g) ?? []).sort().join();
            const keys = new Set([...Object.keys(en), ...Object.keys(de)]);
            return [...keys].filter((key) => !en[key] || !de[key] || places(en[key]) !== places(de[key]));
        })",
    );
    assert_eq!(differences, json!([]));
    let missing = browser.script(
        "return import('/texts.js').then(({ texts: { en } }) => {
            const used = [...document.querySelectorAll('[data-t], [data-t-label]')];
            return used.flatMap(({ dataset: { t, tLabel } }) => [t, tLabel]).filter((key) => key && !en[key]);
        })",
    );
    assert_eq!(missing, json!([]));
}

#[test]
fn empty_and_failed_states_name_the_next_step() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'not connected'");
    for (id, step) in [
        ("found-empty", "Find sensors"),
        ("angles-empty", "connect to a sensor"),
        ("parameters-empty", "open a file"),
        ("frames-empty", "connect"),
        ("file-state", "open a file"),
    ] {
        let text = browser.shown(&format!("#{id}"));
        assert!(text.contains(step), "{id}: {text}");
    }
    let is_off = browser.value("['zero', 'save', 'restart', 'load-factory', 'read', 'backup', 'restore', 'send'].every((id) => document.getElementById(id).disabled)");
    assert_eq!(is_off, true);
    for (port, step) in [
        ("demo:is3", "the products are"),
        ("slcan:/dev/nonexistent", "serial port"),
        ("slcan://127.0.0.1:9", "running there?"),
    ] {
        browser.write("#port", port);
        browser.click("#connect");
        browser.wait(&format!(
            "document.getElementById('message').textContent.includes({step:?})"
        ));
    }
    drop(server);
    browser.wait(
        "document.getElementById('message').textContent.includes('start `plumbline serve` again')",
    );
}

#[test]
fn page_without_the_secret_says_what_to_open() {
    let server = Running::new("");
    let url = server.url.split('#').next().expect("an address").to_owned();
    let Some(browser) = Browser::open(&url) else {
        return;
    };
    browser.wait("document.getElementById('message').textContent.includes('open the address that `plumbline serve` has printed')");
    // The address with the secret helps in the same tab.
    browser.go("about:blank");
    browser.go(&server.url);
    browser.wait("document.getElementById('state').textContent === 'not connected'");
    browser.go(&url);
    browser.wait("document.getElementById('state').textContent === 'not connected'");
}

#[test]
fn sixth_tab_says_what_to_close_and_connects_then() {
    let server = Running::new("");
    let mut tabs: Vec<_> = (0..5).map(|_| server.tab()).collect();
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    let message = "document.getElementById('message').textContent";
    browser.wait(&format!("{message}.includes('Close one of them')"));
    browser.wait("document.getElementById('state').textContent.includes('five tabs are open')");
    browser.wait("document.getElementById('disconnect').disabled");
    browser.choose("#language", "de");
    browser.wait(&format!("{message}.includes('Schließen Sie einen davon')"));
    tabs.pop();
    browser.wait("document.getElementById('state').textContent === 'nicht verbunden'");
    browser.wait(&format!("{message} === ''"));
}
