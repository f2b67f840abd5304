//! `backup`, `restore`, `diff` and `set --file`.

use super::rig::{PRODUCTS, Rig};
use serde_json::json;
use std::path::PathBuf;

/// A file for a test; it does not exist.
fn file(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

/// Changes of several kinds for each family.
fn changes(product: &str) -> &'static str {
    match product {
        "jn2101" => {
            "heartbeat-interval-time=500ms filter=10Hz resolution=1deg quadrant=off tpdo1-event-timer=20ms nmt-start-up=autostart node-id=11"
        }
        "ims360" => {
            "filter=20Hz,butterworth zero-x=1.25deg tpdo2-cob-id=2B3h tpdo2-mapping-entry-1=raw:1628438560 tpdo2-number-of=raw:1 node-id=51 baud-rate=250kbit/s"
        }
        "tiltix080" | "tiltix360" => {
            "resolution=0.1deg slope-long16-preset-value=12.3deg terminal-resistor=on size-of=50 baud-rate=250"
        }
        "is1" | "is1d" | "is1dm" | "is1tk" => {
            "cyclic-time=100ms filter=8.5Hz,butterworth zero=1.25deg bus-off=recovers baud-rate=500 set-id=00000361h"
        }
        _ => {
            "cyclic-time=100ms filter=8.5Hz,butterworth zero-x=-1.25deg bus-off=recovers baud-rate=500 set-id=00000361h"
        }
    }
}

#[test]
fn backup_factory_restore_gives_the_same_file_for_every_product() {
    for product in PRODUCTS {
        let (one, two) = (
            file(&format!("{product}-1.toml")),
            file(&format!("{product}-2.toml")),
        );
        let mut rig = Rig::with(product);
        for change in changes(product).split(' ') {
            rig.done(&format!("set {change}"));
        }
        let factory = file(&format!("{product}-0.toml"));
        Rig::with(product).done(&format!("backup {}", factory.display()));
        rig.done(&format!("backup {}", one.display()));
        let mut other = Rig::with(product);
        let differences = other.json(&format!("diff {}", one.display()));
        assert!(
            differences.as_object().unwrap().len() >= 4,
            "{product} {differences}"
        );
        other.done(&format!("restore {}", one.display()));
        other.done(&format!("backup {}", two.display()));
        let read = |path: &PathBuf| std::fs::read_to_string(path).unwrap();
        assert_eq!(read(&one), read(&two), "{product}");
        assert_ne!(read(&one), read(&factory), "{product}");
        assert_eq!(
            other.json(&format!("diff {}", one.display())),
            json!({}),
            "{product}"
        );
    }
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
    let writes: Vec<String> = other
        .witnessed()
        .iter()
        .map(|frame| format!("{frame:?}"))
        .filter(|frame| frame.starts_with("300#2") || frame.starts_with("300#5"))
        .collect();
    assert_eq!(writes, ["300#256400", "300#5053415645"]);
    let id = other.first();
    other.power_cycle(id);
    assert_eq!(other.json("get cyclic-time")["cyclic-time"]["raw"], 100);
    other.witnessed();
    other.done(&format!("restore {}", path.display()));
    let none: Vec<String> = other
        .witnessed()
        .iter()
        .map(|frame| format!("{frame:?}"))
        .filter(|frame| frame.starts_with("300#5"))
        .collect();
    assert_eq!(none, [""; 0]);
}

#[test]
fn identifiers_that_change_places_never_collide() {
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
    assert_eq!(
        rig.fails(&format!("backup {}", path.display())),
        (2, "file-exists".to_owned())
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    rig.says_yes = true;
    rig.done(&format!("backup {}", path.display()));
    assert_ne!(std::fs::read_to_string(&path).unwrap(), "mine");
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
}
