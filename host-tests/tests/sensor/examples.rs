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
        program.lines().count() < 80,
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
fn sizes_and_values_that_contradict_the_tables_do_not_compile() {
    let (article, model) = (example("new_article"), example("new_canopen_model"));
    let text = "[profile::text(0x1008, \"Name\", \"Mast\")],\n        profile::tpdo(";
    let contradictions = [
        (
            &model,
            "TpdoArray<1, 1>",
            "TpdoArray<2, 1>",
            "the number of TPDOs is not that of the dictionary",
        ),
        (
            &model,
            "TpdoArray<1, 1>",
            "TpdoArray<1, 0>",
            "more objects are mapped than the TPDO takes",
        ),
        (
            &model,
            "ErrorHistory<4>",
            "ErrorHistory<5>",
            "the capacity of the error history is not that of the dictionary",
        ),
        (
            &model,
            "profile::tpdo(",
            text,
            "a text is longer than its buffer",
        ),
        (
            &model,
            "Text<0>",
            "Text<256>",
            "the buffer for texts has more than 255 bytes",
        ),
        (
            &model,
            "0x6010_0010",
            "0x6010_0020",
            "a mapped object has another length",
        ),
        (
            &model,
            "0x6010_0010",
            "0x6020_0010",
            "a mapped object does not exist",
        ),
        (
            &model,
            "(TPDO, 0x180)",
            "(TPDO, 0x000)",
            "the default COB-ID is not free",
        ),
        (
            &model,
            "BIT_RATE, 250",
            "BIT_RATE, 251",
            "the factory value must be permitted",
        ),
        (
            &model,
            "NODE_ID, 20",
            "NODE_ID, 128",
            "the factory value must be permitted",
        ),
        (
            &article,
            "XX-00030-01",
            "xx-00030-01",
            "an article number has capital letters, dashes and digits",
        ),
    ];
    for (program, from, to, message) in contradictions {
        assert!(program.contains(from), "{from}");
        let error = run("contradiction", &program.replacen(from, to, 1));
        let error = error.expect_err(&format!("{from} -> {to} compiles"));
        assert!(error.contains(message), "{from} -> {to}: {error}");
    }
}
