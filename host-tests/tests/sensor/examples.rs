//! Builds the examples of core outside the workspace: they compile with the public interface and send the documented frames.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

const CORE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../core");

/// Creates a package outside the workspace with this program.
fn package(name: &str, program: &str) -> PathBuf {
    let folder = env::temp_dir().join(format!("plumbline-{name}-{}", std::process::id()));
    fs::create_dir_all(folder.join("src")).expect("a folder");
    let manifest = format!(
        "[package]\nname = \"{name}\"\nedition = \"2024\"\n\n[dependencies]\nplumbline = {{ package = \"core\", path = {CORE:?} }}\n\n[workspace]\n"
    );
    fs::write(folder.join("Cargo.toml"), manifest).expect("a manifest");
    fs::write(folder.join("src/main.rs"), program).expect("a program");
    // The same versions as in the workspace, because they are available offline.
    let lock = Path::new(CORE).join("../Cargo.lock");
    fs::copy(lock, folder.join("Cargo.lock")).expect("a lock file");
    folder
}

/// Builds and runs a program outside the workspace. Returns its output, or the errors of the compiler.
fn run(name: &str, program: &str) -> Result<String, String> {
    let folder = package(name, program);
    let output = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--offline"])
        .current_dir(&folder)
        // One build of core for all programs.
        .env(
            "CARGO_TARGET_DIR",
            concat!(env!("CARGO_TARGET_TMPDIR"), "/outside"),
        )
        .output()
        .expect("cargo runs");
    fs::remove_dir_all(folder).expect("the folder is removed");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    if output.status.success() {
        Ok(text(output.stdout))
    } else {
        Err(text(output.stderr))
    }
}

fn example(name: &str) -> String {
    let path = Path::new(CORE).join("examples").join(name);
    let program = fs::read_to_string(path.with_extension("rs")).expect("an example");
    assert!(
        program.lines().count() < 90,
        "{name}: the example is too long"
    );
    program
}

#[test]
fn new_article_reports_a_sensor_error_beyond_its_own_range() {
    let output = run("new-article", &example("new_article")).unwrap();
    assert_eq!(
        output,
        "FSC 00h at 31 deg: [00, 13, E4, F3, 00, 00]\n\
         FSC 03h, article number and revision: [03, 13, B9, 0B, 00, 00, 02, 00]\n"
    );
}

#[test]
fn new_canopen_model_sends_the_slope_without_the_mounting_angle() {
    let output = run("new-canopen-model", &example("new_canopen_model")).unwrap();
    // Boot-up, the reply to the download of 2100h, the TPDO with 5.00 deg.
    assert_eq!(output, "714#00\n594#6000210000000000\n194#F401\n");
}

#[test]
fn article_number_with_small_letters_does_not_compile() {
    let program = example("new_article").replacen("XX-00030-01", "xx-00030-01", 1);
    let error = run("contradiction", &program).expect_err("it compiles");
    assert!(
        error.contains("an article number has capital letters, dashes and digits"),
        "{error}"
    );
}
