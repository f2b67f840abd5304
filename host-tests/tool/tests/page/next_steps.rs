//! States of the page in which something is missing or has failed: each one says what to do next.

use crate::browser::Browser;
use crate::foreign::{opener, unknown};
use crate::server::Running;
use std::io::Write;
use std::sync::atomic::Ordering;

const MESSAGE: &str = "document.getElementById('message').textContent";

fn text(id: &str) -> String {
    format!("document.getElementById('{id}').textContent")
}

#[track_caller]
fn says(browser: &Browser, id: &str, step: &str) {
    browser.wait(&format!("{}.includes({step:?})", text(id)));
    browser.wait(&format!("!document.getElementById('{id}').hidden"));
}

#[test]
fn page_without_a_port_asks_for_it() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    for button in ["#connect", "#find"] {
        browser.click(button);
        browser.wait("document.activeElement.id === 'port'");
        assert_eq!(
            browser.value("document.getElementById('port').validity.valueMissing"),
            true
        );
        assert_eq!(
            browser.value("document.getElementById('question').open"),
            false
        );
        browser.script("document.activeElement.blur()");
    }
    says(&browser, "found-empty", "Choose a port");
    says(&browser, "log-empty", "connect");
}

#[test]
fn sensor_that_does_not_answer_and_adapter_that_is_gone_name_the_next_step() {
    let (opener, witness) = opener(unknown(), true);
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.write("#port", "can0");
    browser.choose("#rate", "250");
    browser.choose("#protocol", "fsc");
    // Nobody has this identifier.
    browser.write("#address", "310");
    browser.click("#connect");
    browser.wait(&format!("{MESSAGE}.includes('check power')"));
    browser.write("#address", "300");
    browser.click("#connect");
    browser.wait(&format!("{} === 'connected'", text("state")));
    assert_eq!(browser.text(MESSAGE), "");
    // The sensor is gone, and comes back.
    witness.is_cut.store(true, Ordering::Relaxed);
    browser.wait(&format!(
        "{} === 'the sensor does not answer'",
        text("state")
    ));
    says(&browser, "angles-empty", "check power and wiring");
    witness.is_cut.store(false, Ordering::Relaxed);
    browser.wait(&format!("{} === 'connected'", text("state")));
    browser.wait("document.getElementById('angles-empty').hidden");
    // No parameter has this in its name.
    browser.write("#search", "zzz");
    says(&browser, "parameters-empty", "change Search");
    browser.write("#search", "x\u{E003}");
    browser.wait("document.getElementById('parameters-empty').hidden");
    // The adapter is unplugged.
    witness.is_out.store(true, Ordering::Relaxed);
    browser.wait(&format!("{} === 'not connected'", text("state")));
    browser.wait(&format!("{MESSAGE}.includes('plug it in again')"));
    browser.choose("#mode", "active");
    browser.click("#connect");
    browser.wait(&format!("{MESSAGE}.includes('plug it in again')"));
    says(&browser, "found-empty", "Choose a port");
    says(&browser, "angles-empty", "connect to a sensor");
}

#[test]
fn files_that_cannot_be_used_name_the_next_step() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(&format!("{} === 'connected'", text("state")));
    let open = |bytes: &[u8]| {
        let file = tempfile::Builder::new().suffix(".toml").tempfile();
        let mut file = file.expect("a file");
        file.write_all(bytes).expect("it is written");
        browser.keys("#file", file.path().to_str().expect("a path"));
        file
    };
    for bytes in [&b""[..], b"\xFF\0\x01", b"[sensor]\nproduct = \"is2\"\n"] {
        let _file = open(bytes);
        browser.wait(&format!(
            "{MESSAGE}.includes('`plumbline backup` writes a valid one')"
        ));
        says(&browser, "file-state", "Press Sensor to file");
        browser.click("#read");
        browser.wait(&format!("{MESSAGE} === ''"));
        browser.wait("!document.getElementById('read').disabled");
    }
    // A file of another product.
    browser.choose("#template", "jn2101");
    browser.click("#new-file");
    says(
        &browser,
        "file-state",
        "open a file of is2, or press Sensor to file",
    );
    assert_eq!(
        browser.value("document.getElementById('restore').disabled"),
        true
    );
    // A scan that finds nobody, without requests.
    browser.write("#port", "demo:is2");
    browser.choose("#rate", "125");
    browser.click("#find");
    browser.wait("document.getElementById('question').open");
    browser.click("#question-yes");
    browser.wait(&format!(
        "{}.includes('There is no traffic')",
        text("question-text")
    ));
    browser.click("#question-no");
    says(&browser, "found-empty", "Press Find sensors again");
}
