//! `backup`, `restore`, `diff` and `set --file`.

pub use super::rig::file;

use super::rig::{PRODUCTS, Rig};
use plumbline::can::Frame;
use serde_json::json;
use std::path::PathBuf;

/// Changes of several kinds for each family, and the options that address the sensor afterwards.
fn changes(product: &str) -> (&'static str, &'static str) {
    match product {
        "jn2101" => (
            "heartbeat-interval-time=500ms filter=10Hz resolution=1deg quadrant=off tpdo1-event-timer=20ms node-id=11",
            "--node 11",
        ),
        "ims360" => (
            "filter=20Hz,butterworth zero-x=1.25deg tpdo2-cob-id=2B3h tpdo2-mapping-entry-1=raw:1628438560 tpdo2-number-of=raw:1 node-id=51 baud-rate=250kbit/s",
            "--node 51",
        ),
        "tiltix080" | "tiltix360" => (
            "resolution=0.1deg slope-long16-preset-value=12.3deg terminal-resistor=on size-of=50 baud-rate=250 mac-id=7",
            "--mac 7",
        ),
        "is1" | "is1d" | "is1dm" | "is1tk" => (
            "cyclic-time=100ms filter=8.5Hz,butterworth zero=1.25deg bus-off=recovers baud-rate=500 set-id=00000361h",
            "--id 00000361",
        ),
        _ => (
            "cyclic-time=100ms filter=8.5Hz,butterworth zero-x=-1.25deg bus-off=recovers baud-rate=500 set-id=00000361h",
            "--id 00000361",
        ),
    }
}

#[test]
fn backup_factory_restore_gives_the_same_file_for_every_product() {
    for product in PRODUCTS {
        let (one, two) = (
            file(&format!("{product}-1.toml")),
            file(&format!("{product}-2.toml")),
        );
        let restarted = file(&format!("{product}-3.toml"));
        let mut rig = Rig::with(product);
        let (changes, address) = changes(product);
        let mut last = "";
        for change in changes.split(' ') {
            rig.done(&format!("set {change}"));
            last = change;
        }
        // The MAC ID is in force at once.
        let now = if last.starts_with("mac-id") {
            address
        } else {
            ""
        };
        let factory = file(&format!("{product}-0.toml"));
        Rig::with(product).done(&format!("backup {}", factory.display()));
        let with = |address: &str, command: &str, path: &PathBuf| {
            let line = format!("{address} {command} {}", path.display());
            line.trim_start().to_owned()
        };
        rig.done(&with(now, "backup", &one));
        rig.done(&with(now, "save", &PathBuf::new()));
        rig.run(1500);
        let id = rig.first();
        rig.power_cycle(id);
        rig.done(&with(address, "backup", &restarted));
        let mut other = Rig::with(product);
        let differences = other.json(&with("", "diff", &restarted));
        assert!(
            differences.as_object().unwrap().len() >= 4,
            "{product} {differences}"
        );
        other.done(&with("", "restore", &restarted));
        other.run(1500);
        let id = other.first();
        other.power_cycle(id);
        other.done(&with(address, "backup", &two));
        let read = |path: &PathBuf| std::fs::read_to_string(path).unwrap();
        assert_eq!(read(&one), read(&restarted), "{product}");
        assert_eq!(read(&one), read(&two), "{product}");
        assert_ne!(read(&one), read(&factory), "{product}");
        assert_eq!(
            other.json(&with(address, "diff", &one)),
            json!({}),
            "{product}"
        );
    }
}

#[test]
fn numbers_of_a_file_keep_their_value_when_the_resolution_changes() {
    let path = file("resolution.toml");
    let mut rig = Rig::with("tiltix080");
    rig.done("set slope-long16-preset-value=12.3deg");
    rig.done(&format!("backup {}", path.display()));
    rig.done(&format!("set resolution=0.1deg --file {}", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains("slope-long16-preset-value = \"12.3 deg\""),
        "{text}"
    );
    rig.done(&format!("restore {}", path.display()));
    let read = rig.json("get slope-long16-preset-value");
    assert_eq!(
        read["slope-long16-preset-value"],
        json!({"value": 12.3, "unit": "deg", "raw": 123})
    );
    rig.done(&format!(
        "set resolution=0.01deg slope-long16-preset-value=12.34deg --file {}",
        path.display()
    ));
    assert_eq!(
        rig.fails(&format!("set resolution=0.1deg --file {}", path.display())),
        (2, "out-of-range".to_owned())
    );
}

/// The writes and saves of the tool at a GEMAC sensor as delivered.
pub fn writes(rig: &mut Rig) -> Vec<String> {
    let frames = rig.witnessed();
    let frames = frames.iter().map(|frame| format!("{frame:?}"));
    frames
        .filter(|frame| frame.starts_with("300#2") || frame.starts_with("300#5"))
        .collect()
}

#[test]
fn restore_stores_and_writes_only_differences() {
    let path = file("stored.toml");
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-time=100ms");
    rig.done(&format!("backup {}", path.display()));
    let mut other = Rig::with("is2");
    other.witnessed();
    other.done(&format!("restore {}", path.display()));
    assert_eq!(writes(&mut other), ["300#256400", "300#5053415645"]);
    let id = other.first();
    other.power_cycle(id);
    assert_eq!(other.json("get cyclic-time")["cyclic-time"]["raw"], 100);
    other.witnessed();
    other.done(&format!("restore {}", path.display()));
    // Without differences only SAVE: an earlier restore can have been interrupted before it.
    assert_eq!(writes(&mut other), ["300#5053415645"]);
}

#[test]
fn exchanged_identifiers_are_never_equal_during_the_writes() {
    let path = file("swapped.toml");
    let mut rig = Rig::with("is2");
    rig.done(&format!("backup {}", path.display()));
    rig.done(&format!(
        "set set-id=301h reply-id=100h sync-id=300h --file {}",
        path.display()
    ));
    let before = rig.done("get set-id reply-id sync-id");
    assert!(before.contains("300h"));
    rig.done(&format!("restore {}", path.display()));
    let read = rig.json("get set-id reply-id sync-id");
    let raw = |name: &str| read[name]["raw"].as_u64().unwrap();
    assert_eq!(
        [raw("set-id"), raw("reply-id"), raw("sync-id")],
        [0x301, 0x100, 0x300]
    );
}

#[test]
fn only_restores_the_named_parameters() {
    let path = file("only.toml");
    let mut rig = Rig::with("is2");
    rig.done(&format!("backup {}", path.display()));
    rig.done("set cyclic-time=100ms filter=1Hz,butterworth");
    rig.done(&format!("restore {} --only filter", path.display()));
    let read = rig.json("get cyclic-time filter");
    assert_eq!(
        (
            read["cyclic-time"]["raw"].as_u64(),
            read["cut-off"]["raw"].as_u64()
        ),
        (Some(100), Some(2000))
    );
}

/// A file of a sensor with a resolution of 0.1 degrees, and a sensor with 0.01 degrees.
fn resolutions(name: &str) -> (PathBuf, Rig) {
    let path = file(name);
    let mut rig = Rig::with("tiltix080");
    rig.done("set resolution=0.1deg slope-long16-preset-value=12.3deg");
    rig.done(&format!("backup {}", path.display()));
    let mut other = Rig::with("tiltix080");
    other.done("set resolution=0.01deg");
    (path, other)
}

/// The preset value in a sensor with a resolution of 0.01 degrees.
fn is_preset(rig: &mut Rig) {
    let read = rig.json("get resolution slope-long16-preset-value");
    let expected = json!({"value": 12.3, "unit": "deg", "raw": 1230});
    assert_eq!(read["slope-long16-preset-value"], expected);
    assert_eq!(read["resolution"]["raw"], 10, "{read}");
}

#[test]
fn only_keeps_the_resolution_of_the_sensor() {
    let (path, mut rig) = resolutions("only-preset.toml");
    rig.done(&format!(
        "restore {} --only slope-long16-preset-value",
        path.display()
    ));
    is_preset(&mut rig);
}

#[test]
fn value_not_named_by_only_is_not_checked_against_the_resolution() {
    let path = file("finer.toml");
    let mut rig = Rig::with("tiltix080");
    rig.done("set resolution=0.01deg slope-long16-preset-value=12.34deg size-of=50");
    rig.done(&format!("backup {}", path.display()));
    let mut other = Rig::with("tiltix080");
    other.done("set resolution=0.1deg");
    other.done(&format!("restore {} --only size-of", path.display()));
    let differences = other.json(&format!("diff {}", path.display()));
    let names: Vec<&String> = differences.as_object().unwrap().keys().collect();
    assert_eq!(names, ["resolution", "slope-long16-preset-value"]);
}

#[test]
fn file_without_resolution_uses_the_resolution_of_the_sensor() {
    let (path, mut rig) = resolutions("without-resolution.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with("resolution"));
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n")).unwrap();
    let difference = rig.json(&format!("diff {}", path.display()));
    assert_eq!(difference["slope-long16-preset-value"]["file"]["raw"], 1230);
    rig.done(&format!("restore {}", path.display()));
    is_preset(&mut rig);
    assert_eq!(rig.json(&format!("diff {}", path.display())), json!({}));
}

#[test]
fn wrong_or_damaged_file_changes_nothing() {
    let path = file("wrong.toml");
    Rig::with("jn2101").done(&format!("backup {}", path.display()));
    let mut rig = Rig::with("is2");
    assert_eq!(
        rig.fails(&format!("restore {}", path.display())),
        (2, "wrong-file".to_owned())
    );
    let damaged = std::fs::read_to_string(&path)
        .unwrap()
        .replace("[parameters]", "[parameters");
    std::fs::write(&path, damaged).unwrap();
    assert_eq!(
        rig.fails(&format!("restore {}", path.display())),
        (2, "bad-file".to_owned())
    );
    assert_eq!(
        rig.fails("restore /nonexistent/file.toml"),
        (4, "no-file".to_owned())
    );
    let writes = rig
        .witnessed()
        .iter()
        .filter(|frame| format!("{frame:?}").starts_with("300#2"))
        .count();
    assert_eq!(writes, 0);
}

#[test]
fn existing_file_is_replaced_only_after_a_yes() {
    let path = file("existing.toml");
    std::fs::write(&path, "mine").unwrap();
    let mut rig = Rig::with("is2");
    for command in [
        "backup FILE",
        "record FILE --seconds 1",
        "log FILE --seconds 1",
    ] {
        let command = command.replace("FILE", path.to_str().unwrap());
        std::fs::write(&path, "mine").unwrap();
        rig.says_yes = false;
        assert_eq!(rig.fails(&command), (2, "file-exists".to_owned()));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        rig.says_yes = true;
        let failed = rig.fails(&format!("record {} --seconds=-1", path.display()));
        assert_eq!(failed, (2, "bad-value".to_owned()));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        rig.done(&command);
        assert_ne!(std::fs::read_to_string(&path).unwrap(), "mine", "{command}");
    }
}

#[test]
fn file_is_changed_without_a_sensor() {
    let path = file("offline.toml");
    Rig::with("is2").done(&format!("backup {}", path.display()));
    let mut nobody = Rig::new(bench::BusRate::Follow);
    nobody.done(&format!(
        "set filter=2.5Hz,butterworth --file {}",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains("cut-off = \"2500 mHz\"\nfilter-type = \"Butterworth\""),
        "{text}"
    );
    assert_eq!(
        nobody.fails(&format!("set cut-off=99Hz --file {}", path.display())),
        (2, "out-of-range".to_owned())
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    // The document is the same as the document of `get`.
    let changed = nobody.json(&format!(
        "set cyclic-time=0.1s filter-type=off --file {}",
        path.display()
    ));
    let cyclic_time = json!({"value": 100, "unit": "ms", "raw": 100});
    assert_eq!(changed["cyclic-time"], cyclic_time);
    let mut rig = Rig::with("is2");
    rig.done(&format!("restore {}", path.display()));
    let read = rig.json("get cyclic-time filter-type");
    assert_eq!(read, changed);
}

#[test]
fn text_or_value_not_allowed_in_a_file_is_refused_with_the_next_step() {
    let path = file("no-setting.toml");
    Rig::with("jn2101").done(&format!("backup {}", path.display()));
    let mut nobody = Rig::new(bench::BusRate::Follow);
    for (assignment, step) in [
        (
            "programming-key=D0UfZEgRKHAI5Ag0",
            "`plumbline set programming-key=...` writes it",
        ),
        ("slope-long32=1", "`plumbline get slope-long32`"),
    ] {
        let ended = nobody.tool(&format!("set {assignment} --file {}", path.display()));
        assert_eq!(ended.code, 2, "{ended:?}");
        assert!(ended.notes.contains(step), "{ended:?}");
    }
}

#[test]
fn value_that_the_sensor_did_not_take_is_refused_and_not_stored() {
    let path = file("not-written.toml");
    let mut rig = Rig::with("is2");
    rig.done("set cyclic-time=100ms");
    rig.done(&format!("backup {}", path.display()));
    // The sensor confirms 100 ms, but reads 250 ms.
    let kept = |frame: Frame| match frame.bytes() {
        [code, status, 100, 0, rest @ ..] if *code != 0x25 => {
            let bytes = [&[*code, *status, 250, 0], rest].concat();
            Frame::data(frame.can_id().into(), &bytes).unwrap()
        }
        _ => frame,
    };
    for command in [
        "set cyclic-time=100ms --save".to_owned(),
        format!("restore {}", path.display()),
    ] {
        let mut rig = Rig::with("is2");
        rig.altered = Some((rig.later(0), rig.later(60_000), kept));
        assert_eq!(rig.fails(&command), (1, "not-written".to_owned()));
        assert_eq!(writes(&mut rig), ["300#256400"], "{command}");
    }
}

#[test]
fn restore_writes_bit_rate_and_identifiers_last() {
    let path = file("order.toml");
    let mut rig = Rig::with("is2");
    rig.done(
        "set set-id=361h baud-rate=500 cyclic-time=100ms zero-x=1.25deg filter=2.5Hz,butterworth",
    );
    rig.done(&format!("backup {}", path.display()));
    let mut rig = Rig::with("is2");
    rig.witnessed();
    rig.done(&format!("restore {}", path.display()));
    let writes = writes(&mut rig);
    // Bit rate (23h), then Set-Parameter-ID (20h), then SAVE.
    let (first, last) = writes.split_at(3);
    assert_eq!(first, ["300#256400", "300#27C40901", "300#287D00"]);
    assert_eq!(last, ["300#2307", "300#2061030000", "300#5053415645"]);
}
