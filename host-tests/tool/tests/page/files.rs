//! Files in the page: the name of the sensor, a restore that was interrupted, and names of new files.

use crate::browser::Browser;
use crate::parts::OPEN;
use crate::server::Running;
use plumbline::model::catalog::find;
use std::io::Write;

/// Opens the question of a button when it can be pressed, and returns its texts.
#[track_caller]
fn question(browser: &Browser, id: &str) -> String {
    browser.wait(&format!("!document.getElementById('{id}').disabled"));
    browser.click(&format!("#{id}"));
    browser.wait(OPEN);
    browser.shown("#question-text") + &browser.shown("#question-field")
}

#[track_caller]
fn yes(browser: &Browser) {
    browser.click("#question-yes");
    browser.wait(&format!("!{OPEN}"));
}

/// Gives the sensor a name; an empty one takes it away.
#[track_caller]
fn label(browser: &Browser, name: &str) {
    question(browser, "label");
    browser.write("#question-input", name);
    yes(browser);
    browser.done(" label ");
}

#[test]
fn file_gives_its_name_to_a_sensor_and_an_interrupted_restore_is_finished() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'connected'");
    let found = "document.getElementById('found-empty').textContent";
    label(&browser, "boom");
    browser.wait(&format!("{found}.includes('boom')"));
    browser.wait("!document.getElementById('backup').disabled");
    browser.click("#backup");
    browser.done("backup FILE.toml");
    // Nothing differs: a restore that was interrupted before the values were stored is finished.
    let store = question(&browser, "restore");
    assert!(store.contains("serial number 1"), "{store}");
    assert_eq!(browser.shown("#question-yes"), "Store");
    yes(&browser);
    browser.done(" save");
    // The successor has no name yet.
    label(&browser, "");
    browser.wait(&format!("!{found}.includes('boom')"));
    let given = question(&browser, "restore");
    assert!(given.contains("name of the sensor: - → boom"), "{given}");
    yes(&browser);
    browser.done("label boom");
    browser.wait(&format!("{found}.includes('boom')"));
    // A sensor that has another name keeps it, unless its box is checked.
    label(&browser, "mast");
    browser.wait(&format!("{found}.includes('mast')"));
    browser.wait("!document.getElementById('file-cyclic-time').disabled");
    browser.write("#file-cyclic-time", "100 ms\u{E007}");
    browser.wait("document.querySelector('tr.differs')");
    let both = question(&browser, "restore");
    assert!(
        both.contains("cyclic-time: 250 ms → 100 ms") && both.contains("mast → boom"),
        "{both}"
    );
    yes(&browser);
    browser.done("restore is2-1.toml --only cyclic-time");
    browser.wait(&format!("{found}.includes('mast')"));
    browser.wait("!document.getElementById('file-cyclic-time').disabled");
    browser.write("#file-cyclic-time", "50 ms\u{E007}");
    browser.wait("document.querySelector('tr.differs')");
    question(&browser, "restore");
    browser.click("#question-check-1");
    yes(&browser);
    browser.done("label boom");
    browser.wait(&format!("{found}.includes('boom')"));
    assert!(
        browser
            .shown("#log-rows")
            .contains("restore is2-1.toml --only cyclic-time")
    );
}

#[test]
fn new_file_of_a_data_sheet_has_the_name_of_its_product() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('template').options.length > 10");
    let text = descriptors::describe(find("jn2101").expect("a product")).text;
    let at = text.find("ProductName=").expect("a name");
    let line = text[at..].lines().next().expect("a line");
    let mut file = tempfile::Builder::new()
        .suffix(".eds")
        .tempfile()
        .expect("a file");
    let other = text.replace(line, "ProductName=Encoder: 1/2 <b>");
    file.write_all(other.as_bytes()).expect("it is written");
    browser.keys("#eds", file.path().to_str().expect("a path"));
    browser.wait(
        "[...document.getElementById('template').options].some(({ value }) => value === 'eds:1')",
    );
    browser.choose("#template", "eds:1");
    browser.click("#new-file");
    let state = "document.getElementById('file-state').textContent";
    browser.wait(&format!("{state}.startsWith('File: ')"));
    let name = browser.text(state);
    let name = name
        .trim_start_matches("File: ")
        .split(" (")
        .next()
        .expect("a name");
    let is_valid = |letter: char| letter.is_alphanumeric() || "._-".contains(letter);
    assert!(
        name.ends_with(".toml")
            && name.chars().all(is_valid)
            && name.to_lowercase().contains("encoder"),
        "{name}"
    );
}
