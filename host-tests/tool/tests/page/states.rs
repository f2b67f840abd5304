//! What the page shows when a sensor, the server or samples are missing, and what is inside of a small window.

use crate::browser::Browser;
use crate::foreign::{opener, unknown};
use crate::server::Running;
use serde_json::json;
use std::sync::atomic::Ordering;

const CONNECTED: &str = "document.getElementById('state').textContent === 'connected'";
const CONDITION: &str = "document.getElementById('condition').textContent";

/// Gives the window this width, and a height of 900 px.
fn resize(browser: &Browser, width: u32) {
    let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
    browser.devtools("Emulation.setDeviceMetricsOverride", size);
}

/// Whether the sides of an element are inside of its box that scrolls and of the window.
fn inside(selector: &str, of: &str) -> String {
    format!(
        "(() => {{
            const [own, box] = ['{selector}', '{of}'].map((one) => document.querySelector(one).getBoundingClientRect());
            return own.width > 0 && own.left >= Math.max(box.left, 0) && own.right <= Math.min(box.right, innerWidth);
        }})()"
    )
}

#[test]
fn found_sensor_can_be_connected_in_a_small_window() {
    let server = Running::new("");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.getElementById('rate').options.length > 10");
    browser.write("#port", "demo:jn2101");
    browser.click("#find");
    browser.click("#question-yes");
    browser.wait("document.querySelector('#found button')");
    for width in [1280, 400] {
        resize(&browser, width);
        browser.wait(&format!("innerWidth === {width}"));
        assert_eq!(
            browser.value(&inside("#found button", "#found-scroll")),
            true,
            "{width}"
        );
    }
}

#[test]
fn page_without_its_server_says_so_and_offers_no_action() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(CONNECTED);
    browser.wait(&format!("{CONDITION}.includes('no error')"));
    drop(server);
    browser.wait(
        "document.getElementById('state').textContent.includes('start `plumbline serve` again')",
    );
    browser.wait("document.getElementById('frames-per-second').textContent === '-'");
    browser.wait(&format!("{CONDITION} === 'Status: unknown'"));
    for id in [
        "connect",
        "disconnect",
        "find",
        "stop",
        "zero",
        "save",
        "restart",
        "read",
        "backup",
        "send",
        "samples",
        "calibrate-start",
        "new-file",
    ] {
        browser.wait(&format!("document.getElementById('{id}').disabled"));
    }
}

#[test]
fn status_of_a_sensor_that_does_not_answer_or_is_not_asked_is_unknown() {
    let (opener, witness) = opener(unknown(), true);
    let server = Running::with("can0", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.choose("#rate", "250");
    browser.choose("#protocol", "fsc");
    browser.write("#address", "300");
    browser.click("#connect");
    browser.wait(CONNECTED);
    browser.wait(&format!("{CONDITION}.includes('no error')"));
    witness.is_cut.store(true, Ordering::Relaxed);
    browser.wait(&format!("{CONDITION} === 'Status: unknown'"));
    witness.is_cut.store(false, Ordering::Relaxed);
    browser.wait(&format!("{CONDITION}.includes('no error')"));
    browser.choose("#samples", "0");
    browser.wait(&format!("{CONDITION} === 'Status: unknown'"));
}

#[test]
fn refused_value_is_told_where_the_user_looks() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(CONNECTED);
    resize(&browser, 1280);
    let button = "[aria-label=\"Set cyclic-time\"]";
    browser.wait(&format!("document.querySelector('{button}')"));
    resize(&browser, 400);
    browser.wait(&inside(button, "#parameters-scroll"));
    resize(&browser, 1280);
    browser.script(&format!(
        "document.querySelector('{button}').scrollIntoView({{ block: 'center' }})"
    ));
    assert!(browser.value("scrollY").as_f64() > Some(200.0));
    browser.click(button);
    browser.write("#question-input", "0");
    browser.click("#question-yes");
    browser.wait("document.getElementById('message').textContent.includes('1..65535 ms')");
    let shown = browser.value(
        "(() => {
            const { left, top, bottom } = document.getElementById('message').getBoundingClientRect();
            return top >= 0 && bottom <= innerHeight && document.elementFromPoint(left + 30, top + 10)?.id === 'message';
        })()",
    );
    assert_eq!(shown, true);
    // It stays until the next action of this user; what another tab reads does not take it away.
    let status = browser.script(
        "return fetch('/api/run', {
            method: 'POST', body: '{\"get\":{\"names\":[\"cut-off\"]}}',
            headers: {
                'Content-Type': 'application/json', 'X-Plumbline-Sensor': '1',
                'X-Plumbline-Token': sessionStorage.getItem('plumbline-token'),
            },
        }).then(({ status }) => status)",
    );
    assert_eq!(status, 200);
    browser.wait("document.querySelector('#log-rows li').textContent.includes('get cut-off')");
    assert!(browser.shown("#message").contains("1..65535 ms"));
}

#[test]
fn samples_can_be_saved_after_the_end_of_the_connection() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("plumbline.got > 20");
    browser.click("#disconnect");
    browser.wait("document.getElementById('state').textContent === 'not connected'");
    browser.choose("#theme", "dark");
    browser.wait("document.querySelector('#chart canvas')");
    browser.click("#csv");
    let table = browser.saved("angles.csv");
    assert!(
        table.starts_with("time_s,angle-x_deg,angle-y_deg\n"),
        "{table}"
    );
    assert!(table.lines().count() > 20, "{table}");
    // Without samples there is nothing to save, and the page says why.
    browser.click("#clear");
    browser.wait("!document.getElementById('chart-empty').hidden");
    browser.wait("document.getElementById('chart-empty').textContent.includes('No samples yet')");
    browser.wait("document.getElementById('csv').disabled");
}

#[test]
fn angles_in_the_table_of_parameters_are_those_of_now() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait(CONNECTED);
    let angle = "[...document.querySelectorAll('#rows tr')].find((row) => row.firstChild.textContent === 'angle-x')?.children[1].textContent";
    browser.wait(&format!("/^-?[0-9.]+ deg$/.test({angle})"));
    let first = browser.text(angle);
    browser.wait(&format!(
        "/^-?[0-9.]+ deg$/.test({angle}) && {angle} !== '{first}'"
    ));
    browser.choose("#samples", "0");
    browser.wait(&format!("{angle} === '-'"));
}

#[test]
fn page_that_hears_nothing_says_what_to_check() {
    // The frames of an earlier connection are not heard now.
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.wait("document.querySelector('#frame-rows tr')");
    browser.wait(CONNECTED);
    browser.choose("#mode", "listen");
    browser.choose("#rate", "125");
    browser.click("#connect");
    browser.wait("document.getElementById('state').textContent === 'listening'");
    let empty = "document.getElementById('frames-empty')";
    browser.wait(&format!(
        "!{empty}.hidden && {empty}.textContent.startsWith('Listening, nothing heard')"
    ));
}
