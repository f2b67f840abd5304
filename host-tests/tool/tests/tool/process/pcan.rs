//! PCAN: a library of the tests with the entry points of PCAN-Basic (`pcan_basic.rs`), which the program loads as that of PEAK.

use super::sensor::{Sensor, command, document};
use bench::BusRate;
use plumbline::can::BitRate;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use virtual_sensor::server::Clock;

/// The file of the library on Linux.
const LIBRARY: &str = "libpcanbasic.so";

/// The folder with the library, which is compiled once.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let parent = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let folder = parent.join("pcan");
        std::fs::create_dir_all(&folder).expect("a folder");
        // Another run of the tests can use the library now: the new one takes its place in one step.
        let own = tempfile::tempdir_in(parent).expect("a folder");
        let source = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/tool/process/pcan_basic.rs"
        );
        let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let output = Command::new(compiler)
            .args(["--edition", "2024", "--crate-type", "cdylib", "-o"])
            .arg(own.path().join(LIBRARY))
            .arg(source)
            .output()
            .expect("rustc starts");
        assert!(output.status.success(), "{output:?}");
        std::fs::rename(own.path().join(LIBRARY), folder.join(LIBRARY)).expect("the same disk");
        folder
    })
}

/// Runs the program with the library, whose adapter is on the bus of this sensor and has this fault.
fn run(sensor: &Sensor, port: &str, fault: &str, arguments: &str) -> Output {
    let address = sensor.port.trim_start_matches("slcan://");
    command(port, "computer", arguments)
        .env("LD_LIBRARY_PATH", folder())
        .env("PCAN_TEST_BUS", address)
        .env("PCAN_TEST_FAULT", fault)
        .output()
        .expect("the program starts")
}

#[test]
fn sensors_are_read_and_set_through_pcan() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    let output = run(
        &sensor,
        "pcan:USBBUS1",
        "",
        "--rate 250 set cyclic-time=20ms --save",
    );
    assert!(output.status.success(), "{output:?}");
    let output = run(&sensor, "pcan", "", "--json --rate 250 get cyclic-time");
    assert_eq!(document(&output)["cyclic-time"]["raw"], 20);
    // It listens first.
    let sensor = Sensor::start("jn2101", BusRate::Fixed(BitRate::K125), Clock::Client);
    let rows = document(&run(&sensor, "pcan", "", "--json --rate 125 scan"));
    assert_eq!(rows[0]["product"], "jn2101");
}

/// What the technician reads when the adapter is not usable: one sentence with the next step.
#[test]
fn adapter_that_cannot_be_used_is_told_with_the_next_step() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    for (fault, expected, lines) in [
        (
            "missing",
            "there is no adapter pcan:USBBUS1 (A channel is invalid): plug it in",
            1,
        ),
        ("in-use", "another program uses pcan:USBBUS1: close it", 1),
        (
            "unplugged",
            "the adapter pcan:USBBUS1 has failed (A channel is invalid): plug it in again",
            1,
        ),
        // The other line names the chapter with all causes.
        ("not-acknowledged", "no answer at identifier 300h", 2),
    ] {
        let output = run(
            &sensor,
            "pcan",
            fault,
            "--rate 250 --id 300 get cyclic-time",
        );
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(expected), "{fault}: {output:?}");
        assert_eq!(text.lines().count(), lines, "{fault}: {output:?}");
    }
    let output = run(
        &sensor,
        "pcan",
        "no-listen-only",
        "--rate 250 log - --seconds 0.1",
    );
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("no listen-only mode"), "{output:?}");
}

/// The adapter is pulled out while frames come and go.
#[test]
fn adapter_that_is_pulled_out_ends_log_and_send_with_one_sentence() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    for (arguments, lines) in [
        ("log - --seconds 60", 1),
        // It also tells the frame, and how many were sent.
        ("send 123#01 --every 10 --seconds 60", 3),
    ] {
        let output = run(
            &sensor,
            "pcan",
            "unplugged",
            &format!("--rate 250 {arguments}"),
        );
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments}: {output:?}");
        assert!(
            text.contains(
                "the adapter pcan:USBBUS1 has failed (A channel is invalid): plug it in again"
            ),
            "{arguments}: {text}"
        );
        // A slow computer leaves frames out, and tells it.
        let own = text.lines().filter(|line| !line.contains("skipped"));
        assert_eq!(own.count(), lines, "{arguments}: {text}");
    }
}

#[test]
fn controller_in_bus_off_is_opened_again() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    let arguments = "--json --rate 250 --id 300 get cyclic-time";
    let output = run(&sensor, "pcan", "bus-off", arguments);
    assert_eq!(document(&output)["cyclic-time"]["raw"], 250);
}

#[test]
fn log_says_how_many_frames_the_library_has_lost() {
    let sensor = Sensor::start("jn2101", BusRate::Fixed(BitRate::K125), Clock::Client);
    for (fault, expected) in [("", false), ("overrun", true)] {
        let output = run(&sensor, "pcan", fault, "--rate 125 log - --seconds 0.2");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(text.contains("lost"), expected, "{fault}: {output:?}");
    }
}

#[test]
fn missing_library_is_told() {
    let output = command("pcan", "computer", "--rate 250 get")
        .env("LD_LIBRARY_PATH", "")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        text.contains("libpcanbasic.so was not found: install"),
        "{text}"
    );
}

#[test]
fn ports_have_the_channels_that_are_there() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    for (fault, kind) in [("", "PCAN"), ("in-use", "PCAN, used by another program")] {
        let ports = document(&run(&sensor, "", fault, "--json ports"));
        let ports = ports.as_array().expect("a list").iter();
        let mut pcan = ports.filter(|port| {
            port["port"]
                .as_str()
                .is_some_and(|port| port.starts_with("pcan"))
        });
        let first = pcan.next().expect("a channel");
        assert_eq!(
            (&first["port"], &first["kind"]),
            (&"pcan:USBBUS1".into(), &kind.into())
        );
        assert_eq!(pcan.next(), None);
    }
}
