//! Real clients against the virtual sensor and the descriptors: python-can, python-canopen, tshark and cantools, with checks
//! written from the manuals.

#[path = "process/python.rs"]
mod python;

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

#[test]
fn the_canopen_sensor_is_the_manuals() {
    let _alone = alone();
    python::run(
        "canopen_check.py",
        &["can", "canopen", "serial"],
        &["--virtual-sensor", VIRTUAL_SENSOR],
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

#[test]
fn the_databases_say_what_the_manual_says() {
    let _alone = alone();
    let descriptors = env!("CARGO_BIN_EXE_descriptors");
    python::run(
        "dbc_check.py",
        &["cantools"],
        &["--descriptors", descriptors],
    );
}
