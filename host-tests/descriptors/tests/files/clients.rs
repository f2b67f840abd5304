//! Tests the descriptors with readers of CAN databases and data sheets: cantools, python-canopen and others.

use host_tests::python;

const DESCRIPTORS: &str = env!("CARGO_BIN_EXE_descriptors");

#[test]
fn databases_match_manual() {
    python::run(
        "dbc_check.py",
        &["cantools"],
        &["--descriptors", DESCRIPTORS],
    );
}

#[test]
fn database_of_j1939_decodes_recorded_traffic() {
    let traces = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces");
    python::run(
        "j1939_dbc_check.py",
        &["cantools"],
        &["--descriptors", DESCRIPTORS, "--traces", traces],
    );
}

#[test]
fn data_sheet_is_accepted_by_other_tools() {
    python::run(
        "eds_check.py",
        &["dcf", "eds_utils", "canopen"],
        &["--descriptors", DESCRIPTORS],
    );
}
