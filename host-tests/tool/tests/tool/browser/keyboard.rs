//! The page with the keyboard alone.

use crate::browser::chromium::{Browser, CONNECTED, OPEN};
use crate::serve::client::Running;
use std::collections::BTreeSet;

const TAB: &str = "\u{E004}";
const ENTER: &str = "\u{E007}";
const ESCAPE: &str = "\u{E00C}";
const SHIFT: &str = "\u{E008}";

/// The maximum number of presses of Tab in a walk.
const MOST: usize = 120;

fn focused(browser: &Browser) -> String {
    browser.text("document.activeElement.id || document.activeElement.tagName")
}

/// Presses Tab until the focus is on an element. Everywhere on the way the focus is visible.
#[track_caller]
fn walk(browser: &Browser, id: &str) -> BTreeSet<String> {
    let mut visited = BTreeSet::new();
    for _ in 0..MOST {
        browser.press("", TAB);
        let is_visible = browser.value(
            "(() => { const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement);
                return outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2; })()",
        );
        let now = focused(browser);
        assert_eq!(is_visible, true, "{now}");
        visited.insert(now.clone());
        if now == id {
            return visited;
        }
    }
    panic!("{id} is not reached: {visited:?}");
}

/// A zero point and a name, without a mouse.
pub fn sensor_is_set_with_the_keyboard_alone(browser: &Browser) {
    let server = Running::connected("is2");
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.wait("!document.getElementById('zero').disabled");
    let visited = walk(browser, "zero");
    for id in [
        "language",
        "theme",
        "port",
        "rate",
        "mode",
        "protocol",
        "product",
        "eds",
        "connect",
        "disconnect",
        "find",
    ] {
        assert!(visited.contains(id), "{id}: {visited:?}");
    }
    // A question, and no.
    browser.press("", ENTER);
    browser.wait(OPEN);
    assert_eq!(focused(browser), "question-no");
    browser.press("", ESCAPE);
    browser.wait(&format!("!{OPEN}"));
    browser.wait("document.activeElement.id === 'zero'");
    assert!(!browser.shown("#log-rows").contains(" zero"));
    // A button that is disabled for a time loses the focus, and gets it back.
    let lost = browser.script(
        "const button = document.getElementById('zero');
        return new Promise((resolve) => {
            const look = () => {
                if (document.activeElement === document.body) return resolve('BODY');
                button.disabled = true;
                return requestAnimationFrame(() => setTimeout(look));
            };
            look();
        });",
    );
    assert_eq!(lost, "BODY");
    browser.wait("document.activeElement.id === 'zero'");
    // The focus stays in the question: after the last element it goes to the first element, or to the browser.
    browser.press("", ENTER);
    browser.wait(OPEN);
    for _ in 0..8 {
        browser.press("", TAB);
        let is_inside = browser.value(
            "document.activeElement === document.body || document.getElementById('question').contains(document.activeElement)",
        );
        assert_eq!(is_inside, true, "{}", focused(browser));
    }
    // Yes.
    for _ in 0..MOST {
        if focused(browser) == "question-yes" {
            break;
        }
        browser.press("", TAB);
    }
    assert_eq!(focused(browser), "question-yes");
    browser.press("", ENTER);
    browser.wait(&format!("!{OPEN}"));
    browser.done("zero");
    browser.wait("document.activeElement.id === 'zero'");
    // Enter in the field of a question is its yes.
    walk(browser, "label");
    browser.press("", ENTER);
    browser.wait(OPEN);
    assert_eq!(focused(browser), "question-input");
    browser.press("", "boom");
    browser.press("", ENTER);
    browser.done("label boom");
    browser.wait("document.activeElement.id === 'label'");
    // A new action leaves the focus on a button of an earlier one.
    browser.script("document.querySelector('#log-rows button').focus()");
    let label = "document.activeElement.getAttribute('aria-label')";
    let copy = browser.text(label);
    assert!(copy.contains("label boom"), "{copy}");
    browser.script("document.getElementById('read').click()");
    browser.done("get");
    assert_eq!(browser.text(label), copy);
    browser.script("document.getElementById('label').focus()");
    // Backwards.
    browser.press(SHIFT, TAB);
    assert_eq!(focused(browser), "bit-rate");
}
