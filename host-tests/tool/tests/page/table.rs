//! What the table of the parameters says of a parameter.

use crate::browser::Browser;
use crate::server::Running;

/// Waits until the row of this parameter has these texts in the columns of the sensor, the factory value and the range.
#[track_caller]
fn has_row(browser: &Browser, name: &str, texts: [&str; 3]) {
    let row = format!("document.getElementById('file-{name}')?.closest('tr')");
    let cells = format!("[1, 4, 5].map((column) => {row}?.children[column].textContent)");
    browser.wait(&format!("{cells}[0] === {:?}", texts[0]));
    assert_eq!(browser.value(&cells), serde_json::json!(texts), "{name}");
}

#[test]
fn table_shows_factory_value_and_range() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    has_row(&browser, "cyclic-time", ["250 ms", "250 ms", "1..65535 ms"]);
}

#[test]
fn table_shows_factory_value_that_contains_the_node_id() {
    let server = Running::new("demo:jn2101");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    let row = "[...document.querySelectorAll('#rows tr')].find((row) => row.firstChild.textContent === 'cob-id-emcy')";
    browser.wait(row);
    let factory = format!("{row}.children[4]");
    assert_eq!(
        browser.text(&format!("{factory}.textContent")),
        "80h + node-ID"
    );
    browser.choose("#language", "de");
    browser.wait(&format!("{factory}.textContent === '80h + Node-ID'"));
}
