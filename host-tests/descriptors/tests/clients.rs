//! Readers of CAN databases and data sheets against the descriptors: cantools, python-canopen and others.

use host_tests::python;

const DESCRIPTORS: &str = env!("CARGO_BIN_EXE_descriptors");

#[test]
fn the_databases_say_what_the_manual_says() {
    python::run(
        "dbc_check.py",
        &["cantools"],
        &["--descriptors", DESCRIPTORS],
    );
}

#[test]
fn other_tools_accept_the_data_sheet() {
    python::run(
        "eds_check.py",
        &["dcf", "eds_utils", "canopen"],
        &["--descriptors", DESCRIPTORS],
    );
}
