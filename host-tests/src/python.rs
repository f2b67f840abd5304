//! Clients written in Python, which the tests run.
//!
//! They need the packages of `clients/requirements.txt`. They run with the first of these interpreters that has the packages: the
//! one in `PLUMBLINE_PYTHON`, the one of the virtual environment `clients-venv` in the target directory, the system's `python3`.
//! If none of them has the packages, a test that needs them reports that it was skipped. In a continuous integration run (`CI` is
//! set) it fails.
//!
//! ```sh
//! python3 -m venv target/clients-venv
//! target/clients-venv/bin/pip install -r host-tests/clients/requirements.txt
//! ```

use std::io::{Write, stderr};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Runs `clients/SCRIPT` with these arguments and panics if it fails. `modules` are the modules outside the standard library that
/// it imports.
#[track_caller]
pub fn run(script: &str, modules: &[&str], arguments: &[&str]) {
    let Some(python) = interpreter(modules) else {
        let what = format!("{script}: no Python with {}", modules.join(", "));
        assert!(std::env::var_os("CI").is_none(), "{what}");
        // Written directly to standard error, which the test harness does not capture.
        let _ = writeln!(stderr(), "skipped: {what}");
        return;
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("clients")
        .join(script);
    let output = Command::new(python)
        .arg(path)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the interpreter starts");
    assert!(
        output.status.success(),
        "{script} failed:\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

/// The first interpreter that has these modules.
fn interpreter(modules: &[&str]) -> Option<PathBuf> {
    let scripts = if cfg!(windows) { "Scripts" } else { "bin" };
    let environment = Path::new("clients-venv").join(scripts).join("python");
    // The test program is in a folder of the target directory.
    let test = std::env::current_exe().unwrap_or_default();
    let environments = test.ancestors().map(|folder| folder.join(&environment));
    let named = std::env::var_os("PLUMBLINE_PYTHON").map(PathBuf::from);
    named
        .into_iter()
        .chain(environments)
        .chain(["python3".into()])
        .find(|python| {
            Command::new(python)
                .arg("-c")
                .arg(format!("import {}", modules.join(", ")))
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status()
                .is_ok_and(|status| status.success())
        })
}
