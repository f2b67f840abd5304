//! The documents of `--json`: programs read them, so they do not change. A change that is wanted is recorded with `INSTA_UPDATE=always`.

use super::files::file;
use super::rig::Rig;
use insta::assert_snapshot;
use serde_json::{Map, Value};

/// Runs the commands on one sensor. The result has a line with each command, and then its documents.
fn documents(product: &str, before: &[&str], commands: &[&str]) -> String {
    let mut rig = Rig::with(product);
    let folder = tempfile::tempdir().expect("a folder");
    rig.config = Some(folder.path().to_owned());
    if !before.is_empty() {
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, None, false);
        for command in before {
            rig.done(command);
        }
        rig.run(1000);
    }
    let path = file(&format!("documents-{product}{}.toml", before.len()));
    let csv = path.with_extension("csv");
    let mut shown = String::new();
    for command in commands {
        let named = command.replace("FILE", &path.display().to_string());
        let _ = std::fs::remove_file(&csv);
        let named = named.replace("CSV", &csv.display().to_string());
        let ended = rig.tool(&format!("--json {named}"));
        shown.push_str(&format!("$ {command} => {}\n", ended.code));
        for line in ended.out.lines() {
            let dcf = path.with_extension("dcf");
            let files = [(&csv, "CSV"), (&path, "FILE"), (&dcf, "DCF")];
            let line = files.iter().fold(line.to_owned(), |line, (path, name)| {
                line.replace(&path.display().to_string(), name)
            });
            let document: Value =
                serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
            let rows = match document {
                Value::Object(rows) => rows,
                other => Map::from_iter([("".to_owned(), other)]),
            };
            // One line for each member, so that a difference is short.
            for (name, value) in rows {
                shown.push_str(&format!("  {name}: {value}\n"));
            }
        }
    }
    shown
}

#[test]
fn documents_of_a_sensor_with_fsc_are_those_recorded() {
    assert_snapshot!(documents(
        "is2",
        &[],
        &[
            "scan",
            "parameters",
            "get",
            "get filter",
            "get nothing",
            "set filter=2.5Hz,butterworth cyclic-time=100",
            "set cyclic-time=0",
            "set cyclic-time=101 --save",
            "save",
            "zero",
            "zero x --save",
            "teach",
            "label",
            "label boom",
            "label --remove",
            "raw 03",
            "raw 99",
            "identity",
            "backup FILE",
            "set cyclic-time=50",
            "diff FILE",
            "restore FILE",
            "watch --seconds 0.5",
            "record CSV --seconds 0.05",
            "node-id 5",
            "mac 5",
            "address",
            "load-factory",
            "restart",
            "rate 500",
            "--rate 500 rate 500",
            "--rate 500 --id 7F get",
        ]
    ));
}

#[test]
fn documents_of_a_canopen_sensor_are_those_recorded() {
    assert_snapshot!(documents(
        "jn2101",
        &[],
        &[
            "scan",
            "parameters",
            "get",
            "get filter",
            "set filter=1Hz",
            "set filter=77Hz",
            "set heartbeat=500 --save",
            "save",
            "zero",
            "zero x",
            "teach --save",
            "label",
            "label boom",
            "raw 1018:1",
            "raw 6000:0=0A000000",
            "raw 9999:0",
            "identity",
            "backup FILE",
            "set filter=5Hz",
            "diff FILE",
            "restore FILE",
            "watch --seconds 0.5",
            "watch --cyclic --seconds 1",
            "record CSV --seconds 0.05",
            "node-id 11",
            "node-id 0",
            "mac 5",
            "address 5",
            "restart",
            "load-factory",
            "rate 125",
        ]
    ));
}

#[test]
fn documents_of_a_devicenet_sensor_are_those_recorded() {
    assert_snapshot!(documents(
        "tiltix080",
        &[],
        &[
            "scan",
            "parameters",
            "get",
            "get cos-delta",
            "set cos-delta=0.5deg",
            "set cos-delta=900deg",
            "save",
            "zero",
            "zero y",
            "teach",
            "label boom",
            "raw 0E01",
            "raw 0E010101",
            "identity",
            "backup FILE",
            "set cos-delta=1deg",
            "diff FILE",
            "restore FILE",
            "watch --seconds 0.5",
            "mac 7",
            "--mac 7 node-id 7",
            "--mac 7 restart",
            "--mac 7 rate 500",
            "--mac 7 --rate 500 load-factory",
            "--mac 7 get",
        ]
    ));
}

#[test]
fn documents_of_a_j1939_sensor_are_those_recorded() {
    assert_snapshot!(documents(
        "ims360",
        &[
            "--node 50 raw 3100:1=01",
            "--node 50 save",
            "--node 50 restart"
        ],
        &[
            "scan",
            "get",
            "get cut-off",
            "set cut-off=2.5Hz filter-type=butterworth",
            "set cut-off=9999Hz",
            "save",
            "zero",
            "zero y --save",
            "teach",
            "label boom",
            "raw FEEB",
            "raw 1FFFF",
            "identity",
            "backup FILE",
            "set cut-off=3Hz",
            "diff FILE",
            "restore FILE",
            "watch --seconds 0.5",
            "address",
            "address 160",
            "--address 160 node-id 7",
            "--address 160 restart",
            "--address 160 rate 500",
        ]
    ));
}
