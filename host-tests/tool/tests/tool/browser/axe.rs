//! What axe finds on the page: the rules of WCAG that a program can check, and good practice.
//!
//! The first test that uses it installs this version with npm into the target directory. Without npm or a registry it is skipped; with `CI`
//! set it fails.

use crate::browser::chromium::{Browser, CONNECTED, OPEN};
use crate::serve::client::Running;
use serde_json::json;
use std::io::{Write, stderr};
use std::path::Path;
use std::process::{Command, Stdio};

const VERSION: &str = "4.14.1";

/// The program, or the reason why there is none.
fn program() -> Result<String, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("axe-{VERSION}"));
    let file = folder.join("node_modules/axe-core/axe.min.js");
    if !file.exists() {
        let mut npm = Command::new("npm");
        npm.args(["install", "--silent", "--no-audit", "--no-fund"])
            .args(["--no-package-lock", "--ignore-scripts", "--prefix"])
            .arg(&folder)
            .arg(format!("axe-core@{VERSION}"));
        let status = npm.stdin(Stdio::null()).status();
        let status = status.map_err(|error| format!("npm: {error}"))?;
        if !status.success() {
            return Err("npm cannot install axe-core".to_owned());
        }
    }
    std::fs::read_to_string(file).map_err(|error| error.to_string())
}

#[track_caller]
fn check(browser: &Browser, state: &str) {
    browser.script("axe.run(document).then((found) => { window.axeFound = found; })");
    browser.wait("window.axeFound");
    let found = browser.script(
        "const { violations, passes } = window.axeFound;
        delete window.axeFound;
        return [passes.length, violations.flatMap(({ id, nodes }) => nodes.map(({ html }) => `${id}: ${html}`))]",
    );
    assert_eq!(found[1], json!([]), "{state}");
    assert!(found[0].as_u64() > Some(10), "{state}: {found}");
}

/// The page with a sensor, and a question, in both languages.
pub fn axe_finds_nothing_in_both_languages(browser: &Browser) {
    let program = match program() {
        Ok(program) => program,
        Err(reason) => {
            assert!(std::env::var_os("CI").is_none(), "axe: {reason}");
            let _ = writeln!(stderr(), "skipped: axe: {reason}");
            return;
        }
    };
    let server = Running::demonstration();
    browser.open(&server.url());
    browser.wait(CONNECTED);
    browser.wait("document.querySelectorAll('#rows tr').length > 10");
    browser.wait("document.querySelectorAll('#frame-rows tr').length > 0");
    browser.script(&program);
    browser.script("for (const part of document.querySelectorAll('details')) part.open = true");
    for language in ["de", "en"] {
        browser.choose("#language", language);
        check(browser, language);
    }
    browser.click("[aria-label=\"Set cut-off\"]");
    browser.wait(OPEN);
    check(browser, "question");
    browser.click("#question-no");
}
