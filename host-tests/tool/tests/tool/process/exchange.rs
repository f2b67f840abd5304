//! The steps of the documents EXCHANGE.md and AUSTAUSCH.md: a new sensor gets the settings of the old one.

use super::sensor::{Sensor, command};
use bench::BusRate;
use std::path::{Path, PathBuf};
use virtual_sensor::server::Clock;

const DOCUMENTS: [&str; 2] = [
    include_str!("../../../EXCHANGE.md"),
    include_str!("../../../AUSTAUSCH.md"),
];

/// The command lines of a part of a document, without the port.
fn lines(part: &str) -> impl Iterator<Item = &str> {
    part.lines()
        .filter_map(|line| line.strip_prefix("plumbline --port PORT "))
        // It runs until it is stopped.
        .filter(|line| !line.starts_with("serve"))
}

/// Runs a command line in a folder, with a yes to its questions, and returns what it prints.
fn run(sensor: &Sensor, folder: &Path, line: &str) -> String {
    let more = if line.ends_with("watch") {
        " --seconds 1"
    } else {
        ""
    };
    let mut command = command(&sensor.port, "bus", &format!("{line}{more} --yes"));
    let output = command.current_dir(folder).output().expect("it starts");
    assert!(output.status.success(), "{line}: {output:?}");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn new_sensor_gets_the_settings_of_the_old_one_by_the_steps_of_the_document() {
    // The address of the old one, and that of the new one after this step.
    for (product, setting, raw, first, step, address) in [
        ("is2", "cyclic-time", 777, "", "", ""),
        ("jn2101", "heartbeat-interval-time", 500, "", "", ""),
        ("ims360", "node-id", 11, "", "restart", "--node 11 "),
        (
            "tiltix080",
            "mac-id",
            7,
            "--mac 7 ",
            "restore old.toml",
            "--mac 7 ",
        ),
    ] {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("exchange-{product}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        let (before, after) = DOCUMENTS[0]
            .split_once("## 4.")
            .expect("the old sensor, then the new one");
        let old = Sensor::start(product, BusRate::Follow, Clock::Client);
        old.done(&format!("set {setting}=raw:{raw} --save --yes"));
        for line in lines(before) {
            run(&old, &folder, &format!("{first}{line}"));
        }
        let new = Sensor::start(product, BusRate::Follow, Clock::Client);
        let mut options = "";
        for line in lines(after) {
            let printed = run(&new, &folder, &format!("{options}{line}"));
            if line == step {
                options = address;
            }
            if line.starts_with("diff") {
                assert_eq!(printed, "the sensor has the settings of old.toml\n");
            }
        }
        let read = new.json(&format!("{options}get {setting} --yes"));
        assert_eq!(read[setting]["raw"], raw, "{product}");
    }
}

#[test]
fn german_document_has_the_steps_of_the_english_one() {
    let [english, german] = DOCUMENTS.map(|text| lines(text).collect::<Vec<_>>());
    assert_eq!(english, german);
    assert!(english.len() > 7, "{english:?}");
}
