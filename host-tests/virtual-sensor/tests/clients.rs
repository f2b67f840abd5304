//! Real clients against the virtual sensor: python-can, python-canopen, devicenet-py and tshark, with checks written from the manuals.

use host_tests::python;
use plumbline::model::catalog;
use std::fs;
use std::io::{Write, stderr};
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use stm32_sim::chip::Chip;
use stm32_sim::firmware;

/// Clients that know only the time of the computer must not run beside other checks.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

const VIRTUAL_SENSOR: &str = env!("CARGO_BIN_EXE_virtual-sensor");

#[test]
fn protocol_matches_manual() {
    let _alone = alone();
    python::run(
        "gemac_check.py",
        &["can", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
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
    let _alone = alone();
    let images = firmware::build(chip).unwrap_or_else(|error| panic!("{error}"));
    let folder = images["is2"].parent().expect("a folder");
    let folder = folder.to_str().expect("a path in UTF-8");
    let mut arguments = vec!["--virtual-sensor", VIRTUAL_SENSOR, "--images", folder];
    arguments.extend(IMAGES.iter().flat_map(|model| ["--model", model]));
    python::run("gemac_check.py", &["can", "serial"], &arguments);
}

#[test]
fn canopen_sensor_matches_manual() {
    let _alone = alone();
    python::run(
        "canopen_check.py",
        &["can", "canopen", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
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
    let _alone = alone();
    let images = firmware::build(chip).unwrap_or_else(|error| panic!("{error}"));
    let image = images[product].to_str().expect("a path in UTF-8");
    let arguments = ["--virtual-sensor", VIRTUAL_SENSOR, "--elf", image];
    python::run(script, &["can", "canopen", "serial"], &arguments);
}

#[test]
fn ims360_matches_manual() {
    let _alone = alone();
    python::run(
        "ims360_check.py",
        &["can", "canopen", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
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
fn devicenet_sensors_match_manual() {
    devicenet("devicenet_check.py", &["can", "serial"], &[]);
}

#[test]
fn wireshark_decodes_devicenet() {
    let installed = Command::new("tshark").arg("--version").output().is_ok();
    if !installed && std::env::var_os("CI").is_none() {
        // Written directly to standard error, which the test harness does not capture.
        let _ = writeln!(stderr(), "skipped: devicenet_tshark.py: no tshark");
        return;
    }
    devicenet("devicenet_tshark.py", &["can", "serial"], &[]);
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
    devicenet(
        "devicenet_eds_check.py",
        &["can", "eds_pie"],
        &["--sheets", folder],
    );
}

#[test]
fn devicenet_master_reads_and_polls() {
    devicenet("devicenet_client.py", &["can", "devicenet"], &[]);
}

#[test]
fn devicenet_images_match_manual() {
    let images = firmware::build(Chip::F103).unwrap_or_else(|error| panic!("{error}"));
    let folder = images["tiltix080"].parent().expect("a folder");
    let folder = folder.to_str().expect("a path in UTF-8");
    devicenet(
        "devicenet_check.py",
        &["can", "serial"],
        &["--images", folder],
    );
}

/// Runs a client of both TILTIX.
fn devicenet(script: &str, modules: &[&str], arguments: &[&str]) {
    let _alone = alone();
    let sensor = ["--virtual-sensor", VIRTUAL_SENSOR];
    python::run(script, modules, &[&sensor, arguments].concat());
}

#[test]
fn angles_match_scene() {
    let _alone = alone();
    python::run(
        "measure_check.py",
        &["can", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
}
