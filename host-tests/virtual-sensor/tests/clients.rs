//! Real clients against the virtual sensor: python-can, python-canopen, devicenet-py, can-j1939 and tshark, with checks written from the manuals.

use host_tests::python;
use plumbline::model::catalog;
use std::fs;
use std::io::{Write, stderr};
use std::path::Path;
use std::process::Command;
use std::sync::{PoisonError, RwLock};
use stm32_sim::chip::Chip;
use stm32_sim::firmware;

const VIRTUAL_SENSOR: &str = env!("CARGO_BIN_EXE_virtual-sensor");

/// The checks whose clients know only the time of the computer. They must not run beside other checks. The others advance the time of
/// the sensor.
const REAL_TIME: &[&str] = &[
    "canopen_check.py",
    "devicenet_client.py",
    "ims360_check.py",
    "j1939_peers.py",
];

/// Runs a check with the virtual sensor.
#[track_caller]
fn check(script: &str, modules: &[&str], arguments: &[&str]) {
    static CHECKS: RwLock<()> = RwLock::new(());
    let real_time = REAL_TIME.contains(&script);
    let _alone = real_time.then(|| CHECKS.write().unwrap_or_else(PoisonError::into_inner));
    let _beside = (!real_time).then(|| CHECKS.read().unwrap_or_else(PoisonError::into_inner));
    let sensor = ["--virtual-sensor", VIRTUAL_SENSOR];
    python::run(script, modules, &[&sensor, arguments].concat());
}

#[test]
fn protocol_matches_manual() {
    check("gemac_check.py", &["can", "serial"], &[]);
}

/// The models whose images are checked.
const IMAGES: &[&str] = &["is1", "is2"];

#[test]
fn protocol_of_flashed_images_matches_manual() {
    flashed_images_match_manual(Chip::F103);
}

#[test]
fn protocol_of_images_for_the_nucleo_matches_manual() {
    flashed_images_match_manual(Chip::F446);
}

fn flashed_images_match_manual(chip: Chip) {
    let images = firmware::build(chip).unwrap_or_else(|error| panic!("{error}"));
    let folder = images["is2"].parent().expect("a folder");
    let folder = folder.to_str().expect("a path in UTF-8");
    let mut arguments = vec!["--images", folder];
    arguments.extend(IMAGES.iter().flat_map(|model| ["--model", model]));
    check("gemac_check.py", &["can", "serial"], &arguments);
}

#[test]
fn canopen_sensor_matches_manual() {
    check("canopen_check.py", &["can", "canopen", "serial"], &[]);
}

#[test]
fn canopen_of_flashed_image_matches_manual() {
    image_matches_manual(Chip::F103, "jn2101", "canopen_check.py");
}

#[test]
fn canopen_of_image_for_the_nucleo_matches_manual() {
    image_matches_manual(Chip::F446, "jn2101", "canopen_check.py");
}

/// Runs a check on an image.
fn image_matches_manual(chip: Chip, product: &str, script: &str) {
    let images = firmware::build(chip).unwrap_or_else(|error| panic!("{error}"));
    let image = images[product].to_str().expect("a path in UTF-8");
    let arguments = ["--elf", image];
    check(script, &["can", "canopen", "serial"], &arguments);
}

#[test]
fn ims360_matches_manual() {
    check("ims360_check.py", &["can", "canopen", "serial"], &[]);
}

#[test]
fn ims360_image_matches_manual() {
    image_matches_manual(Chip::F103, "ims360", "ims360_check.py");
}

#[test]
fn ims360_image_for_the_nucleo_matches_manual() {
    image_matches_manual(Chip::F446, "ims360", "ims360_check.py");
}

#[test]
fn ims360_on_j1939_matches_decisions() {
    check("j1939_check.py", &["can", "canopen", "serial"], &[]);
}

#[test]
fn ims360_image_on_j1939_matches_decisions() {
    image_matches_manual(Chip::F103, "ims360", "j1939_check.py");
}

#[test]
fn can_j1939_and_cantools_understand_ims360() {
    let product = catalog::find("ims360").expect("a product");
    let file = descriptors::describe_all(product)
        .into_iter()
        .find(|file| file.name == "ims360_j1939.dbc")
        .expect("a database");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(file.name);
    fs::write(&path, file.text).expect("a file");
    let path = path.to_str().expect("a path in UTF-8");
    check(
        "j1939_peers.py",
        &["can", "canopen", "serial", "j1939", "cantools"],
        &["--dbc", path],
    );
}

#[test]
fn wireshark_decodes_j1939() {
    if tshark("j1939_tshark.py") {
        check("j1939_tshark.py", &["can", "canopen", "serial"], &[]);
    }
}

#[test]
fn devicenet_sensors_match_manual() {
    check("devicenet_check.py", &["can", "serial"], &[]);
}

#[test]
fn wireshark_decodes_devicenet() {
    if tshark("devicenet_tshark.py") {
        check("devicenet_tshark.py", &["can", "serial"], &[]);
    }
}

/// Whether to run a script that needs tshark: if it is installed, and always in a continuous integration run.
fn tshark(script: &str) -> bool {
    let installed = Command::new("tshark").arg("--version").output().is_ok();
    let run = installed || std::env::var_os("CI").is_some();
    if !run {
        // Written directly to standard error, which the test harness does not capture.
        let _ = writeln!(stderr(), "skipped: {script}: no tshark");
    }
    run
}

#[test]
fn devicenet_data_sheets_match_sensors() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("devicenet-data-sheets");
    fs::create_dir_all(&folder).expect("a folder");
    for name in ["tiltix080", "tiltix360"] {
        let file = descriptors::describe(catalog::find(name).expect("a product"));
        fs::write(folder.join(file.name), file.text).expect("a file");
    }
    let folder = folder.to_str().expect("a path in UTF-8");
    check(
        "devicenet_eds_check.py",
        &["can", "eds_pie"],
        &["--sheets", folder],
    );
}

#[test]
fn devicenet_master_reads_and_polls() {
    check("devicenet_client.py", &["can", "devicenet"], &[]);
}

#[test]
fn devicenet_images_match_manual() {
    let images = firmware::build(Chip::F103).unwrap_or_else(|error| panic!("{error}"));
    let folder = images["tiltix080"].parent().expect("a folder");
    let folder = folder.to_str().expect("a path in UTF-8");
    check(
        "devicenet_check.py",
        &["can", "serial"],
        &["--images", folder],
    );
}

#[test]
fn angles_match_scene() {
    check("measure_check.py", &["can", "serial"], &[]);
}
