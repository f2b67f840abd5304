//! The questions of the page: what they preselect, their language, and what the page says while it waits.

use crate::browser::Browser;
use crate::foreign::{opener, unknown};
use crate::parts::OPEN;
use crate::server::Running;

const CONNECTED: &str = "document.getElementById('state').textContent === 'connected'";
const EMPTY: &str = "document.getElementById('found-empty').textContent";
const CHOSEN: &str = "document.getElementById('question-input').value";

#[test]
fn choice_has_its_unit_once_and_is_preselected() {
    let server = Running::new("demo:tiltix080");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(CONNECTED);
    let shown = "document.getElementById('file-resolution')?.closest('tr').children[1].textContent";
    browser.wait(&format!("{shown} === '0.01 deg'"));
    browser.click("[aria-label=\"Set resolution\"]");
    browser.wait(OPEN);
    assert_eq!(browser.text(CHOSEN), "0.01 deg");
    browser.choose("#question-input", "0.1 deg");
    browser.click("#question-yes");
    browser.wait(&format!("{shown} === '0.1 deg'"));
    browser.click("[aria-label=\"Set resolution\"]");
    browser.wait(OPEN);
    assert_eq!(browser.text(CHOSEN), "0.1 deg");
    browser.click("#question-no");
}

#[test]
fn stored_bit_rate_is_preselected() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(CONNECTED);
    let code = "document.getElementById('file-baud-rate')?.closest('tr').children[1].textContent";
    for (code_shown, chosen) in [
        ("62.5 kbit/s", "62.5"),
        ("1 Mbit/s", "1000"),
        ("automatic detection", "auto"),
    ] {
        browser.wait(&format!("{code}?.length > 1"));
        browser.click("[aria-label=\"Set baud-rate\"]");
        browser.wait(OPEN);
        browser.choose("#question-input", code_shown);
        browser.click("#question-yes");
        browser.wait(&format!("{code} === '{code_shown}'"));
        browser.click("#bit-rate");
        browser.wait(OPEN);
        assert_eq!(browser.text(CHOSEN), chosen);
        assert_eq!(browser.shown("#question-title"), "Bit rate");
        browser.click("#question-no");
    }
}

#[test]
fn page_says_that_it_connects_and_that_it_was_stopped() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.write("#port", "demo:is2");
    browser.click("#find");
    browser.click("#question-yes");
    browser.wait("document.getElementById('progress').textContent.includes('listened at')");
    browser.click("#stop");
    browser.wait(&format!("{EMPTY}.startsWith('Stopped')"));
    // Nobody has this address.
    browser.choose("#rate", "250");
    browser.choose("#protocol", "canopen");
    browser.write("#address", "77");
    browser.click("#connect");
    browser.wait(&format!("{EMPTY}.startsWith('Connecting')"));
    browser.wait(&format!("{EMPTY}.startsWith('No sensor yet')"));
}

#[test]
fn question_before_requests_on_a_bus_with_traffic_is_in_the_language_of_the_page() {
    let (opener, _witness) = opener(unknown(), true);
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.choose("#language", "de");
    browser.write("#port", "can0");
    browser.choose("#rate", "250");
    browser.click("#connect");
    browser.wait(OPEN);
    let question = browser.shown("#question-text");
    assert!(
        question.contains("Es gibt Verkehr, aber kein Sensor wurde erkannt."),
        "{question}"
    );
    // It is a question and no failure.
    let newest = "document.querySelector('#log-rows li')";
    browser.wait(&format!("{newest}.textContent.includes('eine Frage')"));
    assert_eq!(
        browser.value(&format!("{newest}.querySelector('.failed')")),
        serde_json::Value::Null
    );
    assert_eq!(browser.shown("#message"), "");
    browser.click("#question-yes");
    browser.wait("document.getElementById('state').textContent === 'verbunden'");
}

#[test]
fn failure_names_the_controls_of_the_page() {
    let (opener, _witness) = opener(unknown(), true);
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.write("#port", "can0");
    browser.choose("#rate", "250");
    browser.choose("#protocol", "fsc");
    browser.write("#address", "310");
    browser.click("#connect");
    let message = "document.getElementById('message').textContent";
    browser.wait(&format!("{message}.includes('press Find sensors')"));
    let told = browser.text(message);
    assert!(
        told.starts_with("nobody answers")
            && told.contains("Bit rate: automatic")
            && !told.contains("plumbline"),
        "{told}"
    );
    browser.choose("#rate", "125");
    browser.click("#find");
    browser.wait(OPEN);
    browser.click("#question-yes");
    // The bus is silent at this rate: the page asks. After a no it names the box.
    browser.wait(&format!("{OPEN} && document.getElementById('question-text').textContent.includes('There is no traffic')"));
    browser.click("#question-no");
    browser.wait(&format!("{EMPTY}.includes('Send requests as well')"));
    browser.choose("#rate", "250");
    browser.click("#find");
    browser.wait(OPEN);
    browser.click("#question-yes");
    browser.wait(&format!("{message}.includes('Send requests as well')"));
}
