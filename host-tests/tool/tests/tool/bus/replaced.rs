//! `replace`: a new sensor gets what the old one was, and both are compared.

use super::rig::{Rig, broken, file};
use bench::motion::Motion;
use bench::script::LEVEL;
use serde_json::Value;
use std::fs;

/// An old sensor with this setting; the path of its file, which has the name of the test in it.
fn kept(test: &str, product: &str, set: &str) -> String {
    let mut old = Rig::with(product);
    old.done(&format!("set {set} --save"));
    let path = file(&format!("replaced-{test}-{product}.toml"));
    let path = path.display().to_string();
    old.witnessed();
    let document = old.json(&format!("replace read {path}"));
    assert_eq!(document["file"], path.as_str());
    path
}

/// A new sensor.
fn fresh(product: &str) -> Rig {
    let mut rig = Rig::new(bench::BusRate::Follow);
    rig.rate = Some("250");
    rig.says_yes = true;
    rig.attach(product, 2);
    rig.run(3000);
    rig
}

/// Gives a sensor another motion, and waits until its filters have settled.
fn put(rig: &mut Rig, motion: Box<dyn Motion>) {
    let id = rig.first();
    rig.bus.borrow_mut().device_mut(id).set_motion(motion);
    rig.run(3000);
}

fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key].as_str().unwrap_or("-")
}

#[test]
fn new_sensor_of_the_same_product_gets_the_settings_of_the_old_one() {
    for (product, set) in [
        ("is2", "cyclic-time=100ms"),
        ("jn2101", "heartbeat-interval-time=500"),
        ("ims360", "zero-x=1.5deg"),
        ("tiltix080", "differential-slope-long16-offset=1deg"),
    ] {
        let path = kept("same", product, set);
        let mut rig = Rig::with(product);
        let report = file(&format!("replaced-{product}.txt"));
        let shown = report.display();
        let document = rig.json(&format!("replace write {path} --report {shown}"));
        let (name, _) = set.split_once('=').expect("a name");
        let mut rows = document["settings"].as_array().expect("rows").iter();
        let row = rows.find(|row| row["name"] == name).expect("the setting");
        assert_eq!(text(row, "old"), text(row, "new"), "{product}");
        assert_eq!(document["not_carried"], serde_json::json!([]), "{product}");
        assert!(!document["replies"].as_array().unwrap().is_empty());
        let difference = document["angles"][0]["difference"].as_f64().unwrap();
        assert!(difference.abs() < 0.06, "{product}: {document}");
        let signed = fs::read_to_string(report).expect("a report");
        for part in ["no differences", "signature", name, product] {
            assert!(signed.contains(part), "{product} {part}: {signed}");
        }
        // It is stored.
        rig.run(1500);
        rig.power_cycle(rig.first());
        assert_eq!(rig.tool(&format!("diff {path} --exit-code")).code, 0);
    }
}

#[test]
fn file_of_the_old_sensor_has_its_identity_for_the_store_of_the_new_one() {
    let path = kept(
        "identity",
        "tiltix080",
        "differential-slope-long16-offset=1deg",
    );
    // Each value that the sensor tells is in the file.
    let kept = fs::read_to_string(&path).expect("a file");
    let identity = kept.split("[identity]").nth(1).expect("a section");
    let told = Rig::with("tiltix080").json("identity");
    for name in told["identity"].as_object().expect("values").keys() {
        assert!(identity.contains(&format!("\n{name} = ")), "{name}: {kept}");
    }
    let store = file("replaced.bin");
    let mut rig = fresh("tiltix080");
    let arguments = format!("replace write {path} --store {}", store.display());
    let ended = rig.tool(&arguments);
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("identity of a unit"), "{ended:?}");
    assert!(store.is_file());
}

#[test]
fn settings_are_carried_to_another_generation_and_not_to_other_angles() {
    let path = kept("generation", "is2d", "cyclic-time=100ms cut-off=5000mHz");
    let mut rig = Rig::with("is2");
    let document = rig.json(&format!("replace write {path}"));
    let old = text(&document, "old");
    assert!(old.starts_with("is2d, article"), "{document}");
    assert_eq!(rig.json("get cyclic-time")["cyclic-time"]["raw"], 100);
    for product in ["is1", "jn2101"] {
        let mut rig = Rig::with(product);
        let refused = rig.fails(&format!("replace write {path}"));
        assert_eq!(refused, (2, "wrong-file".to_owned()));
    }
}

#[test]
fn angle_that_differs_is_a_difference() {
    let path = kept("angle", "is2", "cyclic-time=100ms");
    let mut rig = Rig::with("is2");
    put(&mut rig, Box::new(LEVEL));
    let ended = rig.tool(&format!("replace write {path}"));
    assert_eq!(ended.code, 1, "{ended:?}");
    for part in ["difference -10.00 deg", "DIFFERENT"] {
        assert!(ended.out.contains(part), "{part}: {ended:?}");
    }
}

/// The old sensor is broken: everything else is carried.
#[test]
fn angles_of_a_broken_sensor_are_neither_kept_nor_compared() {
    for (product, setting, raw, angles) in [
        ("is2", "cyclic-time", 100, ["angle-x", "angle-y"]),
        (
            "jn2101",
            "heartbeat-interval-time",
            500,
            ["slope-long32", "slope-lateral32"],
        ),
        ("ims360", "zero-x", 150, ["slope-long32", "slope-lateral32"]),
        (
            "tiltix080",
            "differential-slope-long16-offset",
            100,
            ["slope-long16", "slope-lateral16"],
        ),
    ] {
        let mut old = Rig::with(product);
        old.done(&format!("set {setting}=raw:{raw} --save"));
        put(&mut old, broken(product, "axis-z"));
        let path = file(&format!("replaced-broken-{product}.toml"));
        let path = path.display().to_string();
        let ended = old.tool(&format!("replace read {path}"));
        assert_eq!(ended.code, 0, "{ended:?}");
        let told = "reports an error, so its angles are not valid: its angles are not compared";
        assert!(ended.notes.contains(told), "{ended:?}");
        let kept = fs::read_to_string(&path).expect("a file");
        assert!(kept.ends_with("[angles]\n"), "{kept}");
        let mut rig = Rig::with(product);
        let ended = rig.tool(&format!("replace write {path}"));
        assert_eq!(ended.code, 1, "{ended:?}");
        for part in angles {
            let mut lines = ended.out.lines();
            let row = lines.find(|line| line.contains("not compared") && line.contains(part));
            assert!(row.is_some(), "{product} {part}: {ended:?}");
        }
        assert!(ended.out.contains("Result: differences: 2"), "{ended:?}");
        assert_eq!(rig.json(&format!("get {setting}"))[setting]["raw"], raw);
    }
}

/// 7.6.1: a code of 10xxh in the list (1003h) is that of the measuring element, if an error is active (1001h). Its end is not in the list.
#[test]
fn angles_of_a_jn2101_are_not_kept_while_its_element_can_be_defective() {
    let supplied = |volts: u16| -> Box<dyn Motion> { Box::new((LEVEL, 1000 * volts)) };
    for (case, motions, clears, is_kept) in [
        ("works", vec![supplied(24)], false, true),
        ("another error", vec![supplied(40)], false, true),
        (
            "ended",
            vec![broken("jn2101", "zero"), supplied(24)],
            false,
            true,
        ),
        // 3100h is the last one in the list.
        (
            "both",
            vec![broken("jn2101", "zero"), supplied(40)],
            false,
            false,
        ),
        ("not in the list", vec![supplied(40)], true, false),
        ("no values", vec![broken("jn2101", "silent")], false, false),
    ] {
        let mut rig = Rig::with("jn2101");
        for motion in motions {
            put(&mut rig, motion);
        }
        if clears {
            rig.done("raw 1003:0=00");
        }
        let path = file("replaced-element.toml").display().to_string();
        rig.done(&format!("replace read {path}"));
        let kept = fs::read_to_string(&path).expect("a file");
        assert_eq!(kept.contains("slope-long32 = { angle"), is_kept, "{case}");
    }
}

#[test]
fn missing_file_of_the_old_sensor_names_the_command_that_writes_it() {
    let mut rig = fresh("is2");
    let ended = rig.tool("replace write no-such.toml");
    let advice = "`plumbline replace read` writes such a file";
    assert!(ended.code == 4 && ended.notes.contains(advice), "{ended:?}");
}

#[test]
fn damaged_file_and_unplugged_adapter_are_errors() {
    let path = kept("damaged", "is2", "cyclic-time=100ms");
    let good = fs::read_to_string(&path).expect("a file");
    for (from, to) in [
        ("[angles]", "[other]"),
        ("[identity]", "[identity]\ncolour = 1"),
        ("spread = ", "width = "),
        ("[replies]\n", "[replies]\nx = 1\n"),
    ] {
        assert!(good.contains(from), "{from}: {good}");
        fs::write(&path, good.replace(from, to)).expect("a file");
        let mut rig = Rig::with("is2");
        let refused = rig.fails(&format!("replace write {path}"));
        assert_eq!(refused, (2, "bad-file".to_owned()), "{from}");
        assert_eq!(rig.json("get cyclic-time")["cyclic-time"]["raw"], 250);
    }
    fs::write(&path, good).expect("a file");
    let mut rig = Rig::with("is2");
    rig.cut = Some(30);
    assert_eq!(rig.fails(&format!("replace write {path}")).0, 4);
}
