//! A sensor is found, shown, set and saved as a user does it.

use crate::browser::chromium::{Browser, CONNECTED, OPEN};
use crate::serve::client::Running;
use plumbline::model::catalog::find;
use serde_json::json;
use std::io::Write;

const MESSAGE: &str = "document.getElementById('message').textContent";

/// Whether the sides of an element are inside of its box that scrolls and of the window.
fn inside(selector: &str, of: &str) -> String {
    format!(
        "(() => {{
            const [own, box] = ['{selector}', '{of}'].map((one) => document.querySelector(one).getBoundingClientRect());
            return own.width > 0 && own.left >= Math.max(box.left, 0) && own.right <= Math.min(box.right, innerWidth);
        }})()"
    )
}

/// From the address that `serve` prints to the angles of a sensor, also in a small window; then the server ends.
pub fn page_finds_a_sensor_and_shows_its_angles(browser: &Browser) {
    let server = Running::new();
    browser.open(&server.url());
    assert_eq!(browser.value("location.hash"), "", "the secret is kept");
    browser.write("#port", "demo:jn2101");
    browser.choose("#rate", "125");
    browser.click("#find");
    browser.wait(OPEN);
    browser.click("#question-yes");
    browser.wait("document.querySelector('#found button')");
    for width in [1280, 400] {
        browser.resize(width);
        let is_inside = browser.value(&inside("#found button", "#found-scroll"));
        assert_eq!(is_inside, true, "{width}");
    }
    browser.click("#found button");
    browser.done("watch");
    browser.wait("/^-?[0-9]+[.][0-9]{2}$/.test(document.getElementById('angle-0')?.textContent)");
    browser.wait("document.querySelectorAll('#box polygon[points]').length === 6");
    assert_eq!(browser.console(), Vec::<String>::new());
    // The page reads the secret from the tab when it is loaded again.
    browser.script("window.old = 1; location.reload()");
    browser.wait(&format!("!window.old && {CONNECTED}"));
    drop(server);
    browser.wait(&format!(
        "{MESSAGE}.includes('start `plumbline serve` again')"
    ));
    // The browser reports the end of the stream.
    browser.console();
}

/// A value is set by its button in the table; one that is not permitted is refused in its question, which keeps it.
pub fn refused_value_is_told_where_the_user_looks(browser: &Browser) {
    let server = Running::connected("is2");
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.resize(400);
    let button = "[aria-label=\"Set cyclic-time\"]";
    browser.wait(&format!("document.querySelector('{button}')"));
    browser.wait(&inside(button, "#parameters-scroll"));
    browser.resize(1280);
    let set = |value: &str| {
        browser.script(&format!(
            "document.querySelector('{button}').scrollIntoView({{ block: 'center' }})"
        ));
        browser.click(button);
        browser.wait(OPEN);
        browser.write("#question-input", value);
        browser.click("#question-yes");
    };
    set("100");
    browser.wait(&format!("!{OPEN}"));
    browser.wait("document.getElementById('file-cyclic-time').closest('tr').children[1].textContent === '100 ms'");
    browser.wait("document.getElementById('unsaved').textContent === 'cyclic-time'");
    set("0");
    browser.wait("document.getElementById('question-wrong').textContent.includes('1..65535 ms')");
    let state = browser.value(
        "(() => {
            const [input, wrong] = ['question-input', 'question-wrong'].map((id) => document.getElementById(id));
            const { left, top, bottom } = wrong.getBoundingClientRect();
            const isShown = top >= 0 && bottom <= innerHeight && document.elementFromPoint(left + 3, top + 3) === wrong;
            return [isShown, input.value, document.activeElement === input];
        })()",
    );
    assert_eq!(state, json!([true, "0", true]));
    // A click on No ends the question.
    browser.click("#question-no");
    browser.wait(&format!("!{OPEN}"));
}

/// The chart by the library that draws it. With `UPDATE` set, the picture of README.md is written.
pub fn chart_is_drawn_paused_and_saved(browser: &Browser) {
    let server = Running::connected("is2");
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.script(
        "const { uPlot } = window;
        window.uPlot = function (...parts) { return window.plot = new uPlot(...parts); };",
    );
    // Other colours need another chart.
    browser.choose("#theme", "light");
    browser.choose("#window", "5");
    browser.choose("#samples", "200");
    browser.wait("window.plot && plumbline.got > 100");
    browser.wait("Math.abs(plot.scales.x.max - plot.scales.x.min - 5) < 1e-6");
    let inked = "(() => {
        const canvas = document.querySelector('#chart canvas');
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        return data.some((part, place) => place % 4 === 3 && part > 0);
    })()";
    browser.wait(inked);
    browser.keys("#chart", " ");
    browser.wait("document.getElementById('pause').getAttribute('aria-pressed') === 'true'");
    browser.keys("#chart", "\u{E014}");
    browser
        .wait("/^-?[0-9.]+$/.test(document.querySelectorAll('.u-legend .u-value')[1].textContent)");
    // The chart is drawn once more when it pauses.
    let wait_for_samples = || {
        let got = browser.value("plumbline.got");
        browser.wait(&format!("plumbline.got > {got} + 20"));
    };
    wait_for_samples();
    browser.value("window.shown = plot.data, 0");
    wait_for_samples();
    assert_eq!(browser.value("plot.data === shown"), json!(true));
    browser.keys("#chart", " ");
    browser.wait("plot.data !== shown");
    browser.click("#csv");
    let table = browser.saved("angles.csv");
    assert!(
        table.starts_with("time_s,angle-x_deg,angle-y_deg\n") && table.lines().count() > 100,
        "{table}"
    );
    assert_eq!(browser.value("plumbline.count"), json!(0));
    if std::env::var_os("UPDATE").is_some() {
        browser.wait("plumbline.got > 1100");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/page.png");
        std::fs::write(path, browser.picture()).expect("a picture");
    }
}

/// A file of settings is saved and opened again, and a data sheet is opened.
pub fn files_are_saved_and_opened(browser: &Browser) {
    let server = Running::connected("is2");
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.click("#backup");
    browser.done("backup FILE.toml");
    browser.wait("!document.getElementById('download').disabled");
    browser.click("#download");
    let text = browser.saved("is2-1.toml");
    assert!(text.contains("cyclic-time = \"250 ms\""), "{text}");
    let open = |selector: &str, suffix: &str, text: &str| {
        let mut file = tempfile::Builder::new()
            .suffix(suffix)
            .tempfile()
            .expect("a file");
        file.write_all(text.as_bytes()).expect("it is written");
        browser.keys(selector, file.path().to_str().expect("a path"));
        file
    };
    let _file = open("#file", ".toml", &text.replace("\"250 ms\"", "\"100 ms\""));
    browser.wait("document.getElementById('file-cyclic-time').value === '100 ms'");
    browser.wait("document.querySelectorAll('tr.differs').length === 1");
    let sheet = descriptors::describe(find("jn2101").expect("a product")).text;
    let _sheet = open("#eds", ".eds", &sheet);
    browser.wait("document.getElementById('product').value === 'eds:1'");
    browser.wait("document.activeElement.id === 'address'");
    assert_eq!(browser.console(), Vec::<String>::new());
}
