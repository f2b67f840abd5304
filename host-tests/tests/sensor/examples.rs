//! The examples of core send the documented frames. `host-tests/tests/mistakes` has an example that does not compile.

use std::path::Path;
use std::process::Command;
use std::{env, fs};

const CORE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../core");

/// The output of an example, which is short.
fn run_short(name: &str) -> String {
    let path = Path::new(CORE).join("examples").join(name);
    let program = fs::read_to_string(path.with_extension("rs")).expect("an example");
    assert!(
        program.lines().count() < 90,
        "{name}: the example is too long"
    );
    run(name)
}

/// The output of an example.
fn run(name: &str) -> String {
    // Without a selection of packages, as `cargo test` has built it.
    let output = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--offline", "--example", name])
        .current_dir(Path::new(CORE).join(".."))
        .output()
        .expect("cargo runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    assert!(output.status.success(), "{}", text(output.stderr));
    text(output.stdout)
}

#[test]
fn new_article_reports_a_sensor_error_beyond_its_own_range() {
    let output = run_short("new_article");
    assert_eq!(
        output,
        "FSC 00h at 31 deg: [00, 13, E4, F3, 00, 00]\n\
         FSC 03h, article number and revision: [03, 13, B9, 0B, 00, 00, 02, 00]\n"
    );
}

#[test]
fn new_canopen_model_sends_the_slope_without_the_mounting_angle() {
    let output = run_short("new_canopen_model");
    // Boot-up, the reply to the download of 2100h, the TPDO with 5.00 deg.
    assert_eq!(output, "714#00\n594#6000210000000000\n194#F401\n");
}

#[test]
fn driver_of_the_mcp2515_answers_and_changes_the_bit_rate() {
    let output = run("driver_mcp2515");
    // The device type, the reply to the bit rate, the boot-up message after the reset.
    let frames = "58A#430010009A010400\n58A#6001200000000000\n70A#00\n";
    assert!(output.contains(frames), "{output}");
}
