//! The modules of the page, without a browser: `tests/page-modules/*.test.js`, run by node.
//!
//! They get what the real server answers and tells, so that both have the same format.

use crate::serve::api::run;
use crate::serve::client::Running;
use serde_json::{Map, Value, json};
use std::io::{Write, stderr};
use std::path::Path;
use std::process::Command;

/// The sensors, one of each protocol.
const SENSORS: [&str; 4] = ["is2", "jn2101", "tiltix080", "ims360/j1939"];

/// The processor time of a process of node in s: an endless loop ends, and the load of the computer has no influence.
const LIMIT: u32 = 60;

/// The modules have at least this number of tests.
const FEWEST: u32 = 60;

/// A sensor and its values as the server tells them.
fn sensor(name: &str) -> Value {
    let server = Running::connected(name);
    let mut tab = server.tab();
    let device = tab.wait("device", |device| !device.is_null());
    let values = tab.wait("values", |values| !values.is_null());
    json!({"device": device, "values": values})
}

/// The answers of a server without a sensor, and what it tells of each sensor.
fn answers() -> Value {
    let server = Running::new();
    let products = server.get("/api/products").json();
    let sheets = products.as_array().into_iter().flatten();
    let sheets = sheets.filter_map(|product| product["sheet"].as_str());
    let parameters: Map<String, Value> = sheets
        .map(|sheet| {
            let answer = server.get(&format!("/api/parameters/{sheet}"));
            (sheet.to_owned(), answer.json())
        })
        .collect();
    let identity = run(&Running::connected("tiltix080"), json!("identity"));
    let devices = SENSORS.map(|name| (name.to_owned(), sensor(name)));
    json!({
        "products": products,
        "ports": server.get("/api/ports").json(),
        "protocols": server.get("/api/protocols").json(),
        "parameters": parameters,
        "devices": Map::from_iter(devices),
        "identity": identity,
    })
}

#[test]
fn page_modules_pass_their_tests_in_node() {
    let node = Command::new("node").arg("--version").output();
    if !node.is_ok_and(|node| node.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "there is no node");
        let _ = writeln!(stderr(), "skipped: no node");
        return;
    }
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    let written = file.write_all(answers().to_string().as_bytes());
    written.expect("it is written");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page-modules");
    let files = std::fs::read_dir(&folder).expect("the folder of the tests");
    let files = files.map(|file| file.expect("a file").path());
    let mut tests: Vec<_> = files
        .filter(|path| path.to_string_lossy().ends_with(".test.js"))
        .collect();
    tests.sort();
    assert!(tests.len() >= 6, "{tests:?}");
    // One process runs all files: each test opens a page with modules of its own.
    let all = "for (const file of process.argv.slice(1)) await import(file);";
    let limited = format!("ulimit -t {LIMIT} && exec node \"$@\"");
    let run = Command::new("sh")
        .args(["-c", &limited, "node", "--test-reporter=tap"])
        .args(["--input-type=module", "--eval", all, "--"])
        .args(&tests)
        .env("PLUMBLINE_ANSWERS", file.path())
        .output()
        .expect("node starts");
    let out = String::from_utf8_lossy(&run.stdout);
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{out}\n{errors}");
    let passed = out.lines().find_map(|line| line.strip_prefix("# pass "));
    let passed: Option<u32> = passed.and_then(|number| number.parse().ok());
    assert!(passed >= Some(FEWEST), "{passed:?} {out}");
}
