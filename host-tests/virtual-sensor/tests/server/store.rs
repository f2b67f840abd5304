//! The file of the nonvolatile memory.

use crate::process::client::{BEL, Client};
use crate::process::control::{Control, start};
use crate::process::sensor::Sensor;
use crate::process::{assert_fails, new_path, text};
use serde_json::{Value, json};
use std::fs;

#[test]
fn save_is_written_to_store_file() {
    let path = new_path("saved.store");
    let sensor = Sensor::start(&["--store", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.say("t300550534156" /* 50h 'S' 'A' 'V' */);
    client.find(BEL);
    client.say("t30055053415645" /* 50h 'S' 'A' 'V' 'E' */);
    client.find("t301250");
    let stored = fs::read(&path).expect("it is there");
    assert!(stored.iter().any(|byte| *byte != 0xFF));
    drop(sensor);
    // Starts again with the same file.
    let sensor = Sensor::start(&["--store", text(&path)]);
    Client::awake(&sensor).poll();
}

/// The store says that this unit has one axis.
#[test]
fn tilt_of_a_unit_with_one_axis_is_angle_and_cross_slope() {
    let path = new_path("one-axis.store");
    let arguments = ["--model", "ims360", "--store", text(&path)];
    let sensor = Sensor::start(&arguments);
    let mut client = Client::open(&sensor);
    for (request, answer) in [
        ("t63282F20310100000000", "t5B28602031"),
        ("t63282310100173617665", "t5B28601010"),
    ] {
        client.say(request);
        client.find(answer);
    }
    drop(sensor);
    let tilt = ["--scene", "tilt=123.45,10"];
    let sensor = Sensor::start(&[&arguments[..], &tilt].concat());
    let mut client = Client::open(&sensor);
    // 6110h until the filter has settled: 12345 = 3039h.
    let angle = || {
        client.say("t63284010610000000000");
        client.find("t5B2843106100")
    };
    assert!(
        std::iter::repeat_with(angle)
            .take(200)
            .any(|answer| answer.starts_with("t5B284310610039300000"))
    );
}

#[cfg(unix)]
#[test]
fn unusable_store_is_named_and_sensor_continues() {
    let nowhere = new_path("no").join("such");
    let foreign = new_path("foreign.store");
    fs::write(&foreign, [b'x'; 5000]).expect("a folder");
    for store in [&nowhere, &foreign] {
        let mut sensor = Sensor::start(&["--store", text(store)]);
        let mut client = Client::awake(&sensor);
        client.say("t30055053415645");
        // CmdParamError and EEPROMError, and factory values.
        assert_eq!(client.find("t301250"), "t3012500F");
        assert_eq!(sensor.interrupt(), Some(0));
        let expected = format!("virtual-sensor: cannot use the store {}: ", text(store));
        assert!(sensor.errors().starts_with(&expected));
    }
    assert_eq!(fs::read(&foreign).expect("it is there"), [b'x'; 5000]);
}

/// The events of a save, and the status byte of its answer.
#[cfg(unix)]
fn save(control: &mut Control) -> (Value, String) {
    control.ok(&json!({ "do": "send", "frame": "300#5053415645" }));
    let (events, _) = control.ask(r#"{"do":"advance","seconds":0.3}"#);
    let stored: Vec<&Value> = events
        .iter()
        .filter(|event| event["event"] == "stored")
        .collect();
    assert_eq!(stored.len(), 1, "{events:?}");
    let mut frames = events.iter().filter_map(|event| event["frame"].as_str());
    let answer = frames.find_map(|frame| frame.strip_prefix("301#50"));
    (stored[0].clone(), answer.expect("an answer").to_owned())
}

/// The file cannot be written because it has become a folder, and because the disk is full.
#[cfg(target_os = "linux")]
#[test]
fn save_into_a_file_that_cannot_be_written_reports_the_reason() {
    let store = new_path("unwritten.store");
    let name = text(&store);
    let (mut sensor, port) = start(&["--clock", "client", "--store", name]);
    let mut control = Control::connect(port);
    control.ok(&json!({ "do": "subscribe", "events": ["stored", "frames"] }));
    control.answer("300#00", "301#FF");
    let begin = "cannot write the store";
    let full = format!("{begin} {name}: No space left on device (os error 28)");
    let folder = format!("{begin} {name}: Is a directory (os error 21)");
    let (_, good) = save(&mut control);
    fs::remove_file(&store).expect("it is there");
    std::os::unix::fs::symlink("/dev/full", &store).expect("a folder");
    for _ in 0..2 {
        let (stored, answer) = save(&mut control);
        assert_eq!(
            (&stored["error"], &stored["programmed"]),
            (&json!(full), &json!(0))
        );
        assert_ne!(answer, good);
    }
    fs::remove_file(&store).expect("it is there");
    fs::create_dir(&store).expect("a folder");
    assert_eq!(save(&mut control).0["error"], json!(folder));
    fs::remove_dir(&store).expect("it is there");
    let (stored, _) = save(&mut control);
    assert_eq!(stored.get("error"), None);
    assert_eq!(fs::read(&store).expect("it is there").len(), 2048);
    assert_eq!(sensor.interrupt(), Some(0));
    // Once for each reason.
    let told = [full, folder].map(|why| format!("virtual-sensor: {why}\n"));
    assert_eq!(sensor.errors(), told.concat());
}

#[cfg(unix)]
#[test]
fn save_into_a_store_that_was_unusable_at_the_start_reports_the_reason() {
    let foreign = new_path("no-store");
    fs::write(&foreign, [b'x'; 5000]).expect("a folder");
    let (_sensor, port) = start(&["--clock", "client", "--store", text(&foreign)]);
    let mut control = Control::connect(port);
    control.ok(&json!({ "do": "subscribe", "events": ["stored", "frames"] }));
    control.answer("300#00", "301#FF");
    let (stored, _) = save(&mut control);
    let error = stored["error"].as_str().expect("a text");
    assert!(error.starts_with(&format!("cannot use the store {}: ", text(&foreign))));
}

#[test]
fn store_of_another_sensor_is_refused() {
    let store = new_path("shared.store");
    let first = Sensor::start(&["--store", text(&store)]);
    assert_fails(
        &["--store", text(&store)],
        1,
        &[text(&store), "another program uses it"],
    );
    drop(first);
    Client::awake(&Sensor::start(&["--store", text(&store)]));
}

#[cfg(unix)]
#[test]
fn file_that_is_not_regular_is_refused() {
    let pipe = new_path("pipe.csv");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo").success());
    let pipe = text(&pipe);
    for (option, path) in [
        ("--store", pipe),
        ("--store", "/dev/zero"),
        ("--store", "/"),
        ("--elf", pipe),
        ("--elf", "/dev/zero"),
    ] {
        assert_fails(&[option, path], 1, &[path, "it is not a regular file"]);
    }
}

#[test]
fn truncated_store_is_damaged_memory() {
    let store = new_path("short.store");
    fs::write(&store, "P").expect("a folder");
    let sensor = Sensor::start(&["--store", text(&store)]);
    let mut client = Client::awake(&sensor);
    client.say("t300102");
    // EEPROMError, and factory values.
    assert_eq!(client.find("t301202"), "t30120207");
}
