//! A bus with another device: the questions of a scan, and what the connection bar says of the bus.

use crate::browser::Browser;
use crate::foreign::{heartbeat, opener, unknown};
use crate::parts::OPEN;
use crate::server::Running;
use std::sync::atomic::Ordering;

const MESSAGE: &str = "document.getElementById('message').textContent";

/// Presses `Find sensors` with the box of the search, and reads the question of the scan.
#[track_caller]
fn search(browser: &Browser) -> String {
    browser.click("#find");
    browser.wait(OPEN);
    browser.click("#question-check-1");
    browser.click("#question-yes");
    browser.wait(&format!(
        "{OPEN} && document.getElementById('question-yes').textContent === 'Yes'"
    ));
    browser.shown("#question-text")
}

#[test]
fn search_on_a_bus_in_use_starts_after_the_yes_to_its_question() {
    let (opener, witness) = opener(heartbeat(), false);
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.write("#port", "can0");
    browser.choose("#rate", "250");
    let question = search(&browser);
    assert!(question.contains("Search for more sensors?"), "{question}");
    browser.click("#question-no");
    browser.wait(&format!("!{OPEN}"));
    browser.wait("document.getElementById('found').textContent.includes('canopen 34')");
    // Only the node whose heartbeat was heard was asked.
    assert!(witness.sent().iter().all(|id| *id == 0x622));
    search(&browser);
    browser.click("#question-yes");
    browser.wait(&format!("!{OPEN}"));
    // Each of the two searches asks once; the second one goes on after the yes.
    let rows = "[...document.querySelectorAll('#log-rows li')].map((row) => row.textContent)";
    for (end, count) in [("a question", 2), ("done", 1)] {
        let is = format!("row.includes('scan --active --search') && row.includes('{end}')");
        browser.wait(&format!("{rows}.filter((row) => {is}).length === {count}"));
    }
    assert_eq!(browser.text(MESSAGE), "");
    let sent = witness.sent();
    assert!(sent.contains(&0x001) && sent.contains(&0x7FF));
}

#[test]
fn connection_bar_shows_rate_frames_per_second_and_errors() {
    let (opener, witness) = opener(unknown(), true);
    witness.errors.store(7, Ordering::Relaxed);
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    let text = |id: &str| format!("document.getElementById('{id}').textContent");
    browser.wait(&format!("{} === 'unknown'", text("errors")));
    browser.write("#port", "can0");
    browser.choose("#rate", "250");
    browser.choose("#protocol", "fsc");
    browser.write("#address", "300");
    browser.click("#connect");
    browser.wait(&format!("{} === 'connected'", text("state")));
    browser.wait(&format!("{} === 'can0 250 kbit/s'", text("bus")));
    browser.wait(&format!("{} === '7'", text("errors")));
    // 50 polls with their answers, and 10 frames of the other device.
    browser.wait(&format!("Number({}) >= 20", text("frames-per-second")));
    browser.wait("document.getElementById('frame-rows').textContent.includes('123h')");
    witness.errors.store(8, Ordering::Relaxed);
    browser.wait(&format!("{} === '8'", text("errors")));
    witness.errors.store(0, Ordering::Relaxed);
    browser.wait(&format!("{} === 'unknown'", text("errors")));
    browser.click("#disconnect");
    browser.wait(&format!("{} === 'not connected'", text("state")));
    browser.wait(&format!("{} === '0'", text("frames-per-second")));
    browser.wait(&format!("{} === '-'", text("bus")));
}
