//! `zero` and `teach`: what they change, and the question before them.

use super::rig::{PRODUCTS, Rig, tilted};
use plumbline::measure::Reading;

#[test]
fn zero_of_every_product_makes_the_angles_zero() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        let zeroed = rig.json("zero");
        let angles = zeroed["zero"].as_object().unwrap();
        assert!(!angles.is_empty(), "{product}");
        // The JN2101 takes over the zero point with the next sample.
        rig.run(50);
        for name in angles.keys() {
            let read = rig.json(&format!("get {name}"));
            let value = read[name]["value"].as_f64().unwrap();
            assert!(value.abs() < 0.02, "{product} {name} {value}");
        }
    }
}

#[test]
fn zero_is_kept_at_power_off_only_with_save() {
    for (product, angle) in [("is2", "angle-x"), ("ims360", "slope-long32")] {
        for (command, is_kept) in [("zero", false), ("zero --save", true)] {
            let mut rig = Rig::with(product);
            rig.done(command);
            rig.run(1000);
            let id = rig.first();
            rig.power_cycle(id);
            let read = rig.json(&format!("get {angle}"));
            let value = read[angle]["value"].as_f64().unwrap();
            assert_eq!(value.abs() < 0.02, is_kept, "{product} {command} {value}");
        }
    }
}

#[test]
fn zero_of_one_axis_leaves_the_other() {
    for (product, x, y) in [
        ("is2", "angle-x", "angle-y"),
        ("ims360", "slope-long32", "slope-lateral32"),
        ("tiltix080", "slope-long16", "slope-lateral16"),
    ] {
        let mut rig = Rig::with(product);
        rig.done("zero y");
        let read = rig.json(&format!("get {x} {y}"));
        assert!(
            read[x]["value"].as_f64().unwrap().abs() > 4.0,
            "{product} {read}"
        );
        assert!(
            read[y]["value"].as_f64().unwrap().abs() < 0.02,
            "{product} {read}"
        );
    }
    assert_eq!(Rig::with("is1").fails("zero y"), (2, "no-axis".to_owned()));
    assert_eq!(
        Rig::with("jn2101").fails("zero x"),
        (2, "no-axis".to_owned())
    );
}

#[test]
fn one_axis_variant_of_ims360_has_no_second_axis_to_zero() {
    let mut rig = Rig::with("ims360");
    rig.done("set sensor-configuration=raw:0 --save");
    rig.done("restart");
    rig.run(500);
    rig.done("zero");
    assert_eq!(rig.fails("zero y"), (2, "no-axis".to_owned()));
}

#[test]
fn teach_is_offered_for_jn2101_only() {
    let mut rig = Rig::with("jn2101");
    rig.done("teach");
    assert_eq!(
        rig.json("get teach")["teach"]["value"],
        "relative measurement"
    );
    assert_eq!(
        Rig::with("is2").fails("teach"),
        (2, "not-offered".to_owned())
    );
}

#[test]
fn zero_teach_and_factory_values_need_a_yes_that_shows_the_sensor() {
    for (product, commands, angle) in [
        (
            "is2",
            &["zero", "zero x --save", "load-factory"][..],
            "angle-x  10.00 deg",
        ),
        ("jn2101", &["zero", "teach", "load-factory"], "slope-long"),
        ("tiltix080", &["zero", "load-factory"], "slope-long16"),
    ] {
        for command in commands {
            let mut rig = Rig::with(product);
            rig.says_yes = false;
            let before = rig.done("get");
            assert_eq!(
                rig.fails(command),
                (2, "not-confirmed".to_owned()),
                "{product} {command}"
            );
            let question = &rig.questions[0];
            for part in [product, "serial 1", "at 250 kbit/s", angle] {
                assert!(question.contains(part), "{part}: {question}");
            }
            let lines = |text: &str| -> Vec<String> {
                let is_steady = |line: &&str| !line.contains("status") && !line.contains("counter");
                text.lines().filter(is_steady).map(str::to_owned).collect()
            };
            assert_eq!(
                lines(&rig.done("get")),
                lines(&before),
                "{product} {command}"
            );
            rig.says_yes = true;
            rig.done(command);
        }
    }
}

#[test]
fn note_on_storage_is_true_after_zero() {
    for (product, is_kept) in [
        ("is2", false),
        ("ims360", false),
        ("jn2101", true),
        ("tiltix080", true),
    ] {
        let mut rig = Rig::with(product);
        let ended = rig.tool("zero");
        assert_eq!(
            ended.notes.contains("not stored yet"),
            !is_kept,
            "{product} {ended:?}"
        );
        rig.run(1500);
        rig.power_cycle(rig.first());
        let read = rig.json("get");
        let name = match product {
            "is2" => "angle-x",
            "tiltix080" => "slope-long16",
            _ => "slope-long32",
        };
        let value = read[name]["value"].as_f64().unwrap();
        assert_eq!(value.abs() < 0.02, is_kept, "{product} {value}");
    }
}

/// The refusal of each protocol as a sentence.
#[test]
fn position_without_a_valid_angle_is_not_taken() {
    let dead = Reading {
        temperature: 25_00,
        ..Reading::default()
    };
    for (product, commands, code, angle) in [
        ("is2", &["zero"][..], "CmdParamError", "angle-x"),
        ("jn2101", &["zero", "teach"], "08000022h", "slope-long32"),
        ("ims360", &["zero"], "08000022h", "slope-long32"),
        ("tiltix080", &["zero"], "0Ch", "slope-long16"),
    ] {
        for command in commands {
            let mut rig = Rig::with(product);
            let before = rig.json("get")[angle]["value"].clone();
            let sensor = rig.first();
            let set =
                |rig: &Rig, motion| rig.bus.borrow_mut().device_mut(sensor).set_motion(motion);
            set(&rig, Box::new(dead));
            rig.run(1000);
            let ended = rig.tool(command);
            assert_eq!(ended.code, 1, "{product} {ended:?}");
            for part in ["was not taken", "no valid angle", code] {
                assert!(ended.notes.contains(part), "{product}: {ended:?}");
            }
            set(&rig, tilted());
            rig.run(3000);
            assert_eq!(rig.json("get")[angle]["value"], before, "{product}");
            rig.done(command);
        }
    }
}
