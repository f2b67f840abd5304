//! Which sensor the page shows and changes, and how old its angles can be.

use crate::browser::Browser;
use crate::server::Running;

const ANGLE: &str = "document.getElementById('angle-0')?.textContent";

fn has_angles(browser: &Browser) {
    browser.wait(&format!("/^-?[0-9]/.test({ANGLE} ?? '')"));
    browser.wait("!document.getElementById('box').classList.contains('old')");
}

fn has_none(browser: &Browser) {
    browser.wait(&format!("{ANGLE} === '-'"));
    browser.wait("document.getElementById('box').classList.contains('old')");
    browser.wait("document.getElementById('box-title').textContent.includes('angle-x - deg')");
}

#[test]
fn old_angles_are_not_shown_and_a_question_shows_new_angles() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    has_angles(&browser);
    browser.choose("#samples", "0");
    has_none(&browser);
    browser.click("#zero");
    browser.wait("document.getElementById('question').open");
    let question = browser.shown("#question-text");
    let angle = question.split("angle-x ").nth(1).unwrap_or_default();
    assert!(
        angle.starts_with(|first: char| first == '-' || first.is_ascii_digit())
            && !angle.starts_with("- "),
        "{question}"
    );
    browser.click("#question-no");
    browser.choose("#samples", "1");
    has_angles(&browser);
    browser.choose("#samples", "50");
    drop(server);
    has_none(&browser);
}

#[test]
fn yes_to_a_question_about_another_sensor_changes_nothing() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    has_angles(&browser);
    browser.click("#zero");
    browser.wait("document.getElementById('question').open");
    assert!(
        browser
            .shown("#question-text")
            .contains("serial number 1, address 300")
    );
    // Another tab connects to another sensor.
    let status = browser.script(
        "return fetch('/api/connect', {
            method: 'POST', body: '{\"port\":\"demo:jn2101\",\"mode\":\"active\"}',
            headers: {'Content-Type': 'application/json', 'X-Plumbline-Token': sessionStorage.getItem('plumbline-token')},
        }).then(({ status }) => status)",
    );
    assert_eq!(status, 200);
    browser.wait("document.getElementById('found-empty').textContent.includes('jn2101')");
    browser.click("#question-yes");
    browser.wait(
        "document.getElementById('message').textContent.includes('Another sensor is connected')",
    );
    assert_eq!(
        browser.value("[...document.querySelectorAll('#log-rows code')].filter((line) => line.textContent.includes(' zero')).length"),
        0
    );
}

#[test]
fn address_of_a_new_server_in_an_open_tab_is_taken() {
    let server = Running::new("");
    let (url, token) = server.url.split_once('#').expect("a secret");
    let Some(browser) = Browser::open(&format!("{url}#{}", "0".repeat(32))) else {
        return;
    };
    browser.wait("document.getElementById('message').textContent.includes('open the address that `plumbline serve` has printed')");
    browser.script(&format!("location.hash = '{token}'"));
    browser.wait("document.getElementById('state').textContent === 'not connected'");
    assert_eq!(browser.value("location.hash"), "");
}
