//! Real clients against the virtual sensor: python-can, python-canopen and tshark, with checks written from the manuals.

use host_tests::python;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Checks in real time do not run beside each other.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

const VIRTUAL_SENSOR: &str = env!("CARGO_BIN_EXE_virtual-sensor");

#[test]
fn the_protocol_is_the_manuals() {
    let _alone = alone();
    python::run(
        "gemac_check.py",
        &["can", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
}

/// The models whose images are checked.
const IMAGES: &[&str] = &["is1", "is2"];

/// The groups that do not depend on the time of the day: a simulated microcontroller is not always as fast as a real one. `boot`
/// talks to a sensor at once, and an image waits for its accelerometer first.
const TIMELESS: &[&str] = &[
    "identity",
    "codes",
    "short",
    "extra",
    "framing",
    "sticky",
    "alive",
    "values",
    "clash",
    "default_param",
    "communication",
    "load",
    "power",
    "many_saves",
    "blank",
    "damaged",
    "other_model",
    "angles",
    "zero",
    "limits",
    "sync",
    "bit_rates",
    "burst",
];

#[test]
fn the_protocol_of_the_flashed_images_is_the_manuals() {
    let _alone = alone();
    let images = stm32_sim::firmware::build().unwrap_or_else(|error| panic!("{error}"));
    let folder = images["is2"].parent().expect("a folder");
    let folder = folder.to_str().expect("a path in UTF-8");
    let mut arguments = vec!["--virtual-sensor", VIRTUAL_SENSOR, "--images", folder];
    arguments.extend(IMAGES.iter().flat_map(|model| ["--model", model]));
    arguments.extend(TIMELESS.iter().flat_map(|group| ["--only", group]));
    python::run("gemac_check.py", &["can", "serial"], &arguments);
}

#[test]
fn the_canopen_sensor_is_the_manuals() {
    let _alone = alone();
    python::run(
        "canopen_check.py",
        &["can", "canopen", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
}

/// The groups for the JN2101's image: those that do not measure time. `error_passive` is not among them, because an image that nobody
/// has acknowledged sends the emergency before the boot-up message: of two mailboxes the one with the higher priority goes first.
const CANOPEN_IMAGE: &[&str] = &[
    "boot_up",
    "transitions",
    "states",
    "expedited",
    "segmented_upload",
    "segmented_download",
    "lengths",
    "unknown_commands",
    "malformed",
    "invalid_frames",
    "defaults",
    "access",
    "limits",
    "signatures",
    "node_id",
    "programming_key",
    "content",
    "synchronous",
    "remote",
    "guarding",
    "excavator",
    "resolution",
    "zero_point",
    "teach",
    "master",
];

#[test]
fn the_canopen_of_the_flashed_image_is_the_manuals() {
    let _alone = alone();
    let images = stm32_sim::firmware::build().unwrap_or_else(|error| panic!("{error}"));
    let image = images["jn2101"].to_str().expect("a path in UTF-8");
    let mut arguments = vec!["--virtual-sensor", VIRTUAL_SENSOR, "--jobs", "2"];
    arguments.extend(CANOPEN_IMAGE.iter().flat_map(|group| ["--only", group]));
    arguments.extend(["--elf", image]);
    python::run(
        "canopen_check.py",
        &["can", "canopen", "serial"],
        &arguments,
    );
}

#[test]
fn the_angles_are_those_of_the_scene() {
    let _alone = alone();
    python::run(
        "measure_check.py",
        &["can", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
    );
}
