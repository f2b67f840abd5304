//! `label`: the name of a sensor on this computer, and in files.

use super::files::file;
use super::rig::{PRODUCTS, Rig};
use super::talking::cyclic;
use plumbline::can::BitRate;
use serde_json::{Value, json};
use std::path::PathBuf;

fn folder(name: &str) -> PathBuf {
    let folder = file(&format!("labels-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

#[test]
fn name_of_every_product_is_kept_by_maker_and_serial_number() {
    let config = folder("products");
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        rig.config = Some(config.clone());
        let name = format!("boom {product}");
        let ended = rig.tool_with(&["label", &name]);
        assert_eq!((ended.code, ended.out.trim()), (0, &*name), "{ended:?}");
        assert!(ended.notes.contains("labels.toml"), "{ended:?}");
        let ended = rig.tool("get serial-number");
        assert!(ended.notes.contains(&format!("{name:?}")), "{ended:?}");
        // Another unit has no name.
        let mut rig = Rig::new(bench::BusRate::Follow);
        (rig.rate, rig.says_yes, rig.config) = (Some("250"), true, Some(config.clone()));
        rig.attach(product, 2);
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, None, false);
        rig.run(3000);
        rig.bus.borrow_mut().remove(other);
        assert_eq!(rig.json("label"), json!({"label": null}), "{product}");
    }
    let names = std::fs::read_to_string(config.join("labels.toml")).unwrap();
    for line in [
        "[GEMAC]",
        "[\"ifm electronic\"]",
        "[SIKO]",
        "[\"FRABA Posital GmbH\"]",
        "1 = \"boom jn2101\"",
    ] {
        assert!(names.lines().any(|own| own == line), "{line}: {names}");
    }
}

#[test]
fn name_is_shown_by_scan_and_can_be_removed() {
    let mut rig = Rig::with("jn2101");
    rig.config = Some(folder("scan"));
    rig.done("--node 10 label boom");
    assert_eq!(rig.json("scan --active")[0]["label"], "boom");
    assert!(rig.done("scan --active").contains("\"boom\""));
    let removed = rig.done("--node 10 label --remove");
    assert_eq!(removed, "the name boom was removed\n");
    let removed = rig.done("--node 10 label --remove");
    assert_eq!(removed, "the sensor has no name\n");
    assert_eq!(rig.json("scan --active")[0].get("label"), None);
    assert_eq!(rig.json("--node 10 label"), json!({"label": Value::Null}));
}

#[test]
fn name_in_a_file_goes_to_the_successor_that_has_none() {
    let path = file("label.toml");
    let _ = std::fs::remove_file(&path);
    let mut rig = Rig::with("is2");
    rig.config = Some(folder("file"));
    rig.done("label boom");
    rig.done(&format!("backup {}", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("label = \"boom\"\n"), "{text}");
    rig.done(&format!("set filter=1Hz --file {}", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("label = \"boom\"\n"), "{text}");
    // The same computer forgets the name.
    rig.config = Some(folder("successor"));
    rig.done(&format!("restore {} --only filter", path.display()));
    assert_eq!(rig.json("label")["label"], Value::Null);
    rig.done(&format!("restore {}", path.display()));
    assert_eq!(rig.json("label")["label"], "boom");
    // A label that is no name is told from the name of the sensor.
    let bad = file("bad-label.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&bad, text.replace("\"boom\"", "\"a\\nb\"")).unwrap();
    rig.config = Some(folder("bad-label"));
    let ended = rig.tool(&format!("restore {}", bad.display()));
    let told = "the label in the file was not taken over: the name \"a\\nb\"";
    assert!(ended.notes.contains(told), "{ended:?}");
    rig.config = Some(folder("successor"));
    rig.done(&format!("restore {}", path.display()));
    // A name that the sensor has stays.
    rig.done("label other");
    rig.done(&format!("restore {}", path.display()));
    assert_eq!(rig.json("label")["label"], "other");
}

#[test]
fn bad_name_and_broken_file_change_nothing() {
    let config = folder("bad");
    let mut rig = Rig::with("is2");
    rig.config = Some(config.clone());
    for name in ["", "  ", "two\nlines", &"x".repeat(61)] {
        let ended = rig.tool_with(&["label", name]);
        assert_eq!(ended.code, 2, "{name:?} {ended:?}");
        let told = format!("the name {:?} is not permitted: choose", name.trim());
        assert!(ended.notes.contains(&told), "{name:?} {ended:?}");
    }
    assert!(!config.exists());
    std::fs::create_dir_all(&config).unwrap();
    let path = config.join("labels.toml");
    for text in ["nonsense", "GEMAC = 1", "[GEMAC]\n1 = 2\n[GEMAC]"] {
        std::fs::write(&path, text).unwrap();
        rig.done("get serial-number");
        assert_eq!(rig.fails("label boom"), (4, "no-file".to_owned()), "{text}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}

#[test]
fn place_of_the_last_command_is_used_and_another_sensor_is_searched() {
    let folder = std::env::temp_dir().join(format!("plumbline-{}-last", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut rig = Rig::with("is2");
    rig.config = Some(folder.clone());
    rig.done("--rate 250 --id 300 get");
    // Without the rate the tool would listen, and ask.
    rig.says_yes = false;
    rig.rate = None;
    let ended = rig.tool("get cyclic-time");
    assert_eq!(ended.code, 0, "{ended:?}");
    let note = "as in the last command: --rate 250 --id 300";
    assert!(ended.notes.contains(note), "{ended:?}");
    assert!(rig.questions.is_empty());
    let mut other = Rig::with("jn2101");
    other.config = Some(folder.clone());
    let ended = other.tool("get node-id");
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("no answer there"), "{ended:?}");
    let ended = other.tool("get node-id");
    assert!(ended.notes.contains("--node 10"), "{ended:?}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn only_sensor_of_a_scan_is_that_of_the_next_command() {
    for (others, code, note) in [
        (&[][..], 0, "as in the last command: --rate 125 --node 10"),
        (&["ims360"], 2, ""),
    ] {
        let config = folder("only-one");
        std::fs::create_dir_all(&config).unwrap();
        let mut rig = Rig::with("jn2101");
        rig.config = Some(config);
        for other in others {
            rig.attach(other, 2);
        }
        let scanned = rig.json("--rate 125 scan --active");
        let count = scanned.as_array().map(Vec::len);
        assert_eq!(count, Some(1 + others.len()), "{scanned}");
        // Without the rate the tool would listen, and ask.
        (rig.rate, rig.says_yes) = (None, false);
        let ended = rig.tool("get node-id");
        assert_eq!(ended.code, code, "{ended:?}");
        assert!(ended.notes.contains(note), "{ended:?}");
    }
}

#[test]
fn bit_rate_of_the_last_command_disturbs_no_bus_with_another_one() {
    for command in ["get cyclic-time", "raw 17"] {
        let config = folder("rate");
        std::fs::create_dir_all(&config).unwrap();
        let mut rig = Rig::with("is2");
        rig.config = Some(config.clone());
        rig.done("--rate 250 --id 300 get");
        let mut rig = cyclic("is2", BitRate::K500, "");
        (rig.config, rig.rate) = (Some(config), None);
        let ended = rig.tool(command);
        let note = "as in the last command: --rate 250 --id 300";
        assert!(ended.code == 0 && ended.notes.contains(note), "{ended:?}");
        let id = rig.first();
        let errors = rig.bus.borrow().device(id).error_counters();
        assert_eq!(errors, Some((0, 0)), "{command}");
    }
}
