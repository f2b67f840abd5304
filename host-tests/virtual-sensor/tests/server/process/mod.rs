//! Shared by tests of the virtual sensor: the program as a process, a raw slcan client, and one that controls the sensors.

pub mod client;
pub mod control;
pub mod sensor;

use sensor::fails;
use std::fs;
use std::path::{Path, PathBuf};

/// A path for a file of this test, which does not exist yet.
pub fn new_path(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The removal fails if the file does not exist.
    let _ = fs::remove_file(&path);
    path
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Asserts that the program exits with this code and one sentence that contains these words.
#[track_caller]
pub fn assert_fails(arguments: &[&str], code: i32, words: &[&str]) {
    let output = fails(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    for word in words {
        assert!(
            error.contains(word),
            "{arguments:?}: {error:?} lacks {word:?}"
        );
    }
    assert!(
        !error.contains("panicked") && !error.contains("RUST_BACKTRACE"),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{arguments:?}");
}
