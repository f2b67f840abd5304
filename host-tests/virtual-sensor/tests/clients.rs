//! Other people's CAN stacks: python-canopen, devicenet-py and can-j1939 with the virtual sensor, also with the Python package of the
//! project; the dissectors of Wireshark with the recorded traces, and eds-pie with the data sheets of DeviceNet.

use host_tests::python;
use plumbline::model::catalog;
use std::fs;
use std::io::{Write, stderr};
use std::path::Path;
use std::process::Command;

/// Runs a check with the virtual sensor.
#[track_caller]
fn check(script: &str, modules: &[&str], arguments: &[&str]) {
    let sensor = ["--virtual-sensor", env!("CARGO_BIN_EXE_virtual-sensor")];
    python::run(script, modules, &[&sensor, arguments].concat());
}

/// Runs a check of the recorded traces with tshark, if it is installed, and always in a continuous integration run.
#[track_caller]
fn check_traces(script: &str) {
    let installed = Command::new("tshark").arg("--version").output().is_ok();
    if installed || std::env::var_os("CI").is_some() {
        let traces = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces");
        python::run(script, &["sys"], &["--traces", traces]);
    } else {
        // Written directly to standard error, which the test harness does not capture.
        let _ = writeln!(stderr(), "skipped: {script}: no tshark");
    }
}

/// The folder with the data sheets of these products.
fn data_sheets(folder: &str, products: &[&str]) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    fs::create_dir_all(&folder).expect("a folder");
    for name in products {
        let file = descriptors::describe(catalog::find(name).expect("a product"));
        fs::write(folder.join(file.name), file.text).expect("a file");
    }
    folder.to_str().expect("a path in UTF-8").to_owned()
}

#[test]
fn python_canopen_uses_jn2101_and_ims360() {
    let sheets = data_sheets("canopen-data-sheets", &["jn2101", "ims360"]);
    check(
        "canopen_client.py",
        &["can", "canopen", "serial"],
        &["--sheets", &sheets],
    );
}

#[test]
fn can_j1939_uses_ims360() {
    check("j1939_peers.py", &["can", "j1939"], &[]);
}

#[test]
fn python_package_starts_moves_and_breaks_sensors() {
    let modules = ["pytest", "can", "canopen", "j1939", "serial"];
    check("python_package.py", &modules, &[]);
}

#[test]
fn devicenet_py_uses_tiltix080_and_tiltix360() {
    check("devicenet_client.py", &["can", "devicenet"], &[]);
}

#[test]
fn eds_pie_reads_data_sheets_of_devicenet() {
    let sheets = data_sheets("devicenet-data-sheets", &["tiltix080", "tiltix360"]);
    let arguments = ["--sheets", &sheets];
    python::run("devicenet_eds_check.py", &["eds_pie"], &arguments);
}

#[test]
fn wireshark_decodes_traces_of_canopen() {
    check_traces("canopen_tshark.py");
}

#[test]
fn wireshark_decodes_traces_of_j1939() {
    check_traces("j1939_tshark.py");
}

#[test]
fn wireshark_decodes_traces_of_devicenet() {
    check_traces("devicenet_tshark.py");
}
