//! `align`: the offset of the mounting by the reversal.

use super::j1939;
use super::rig::run::Ended;
use super::rig::{Rig, broken, tilt};
use bench::Bus;
use bench::motion::Motion;
use plumbline::measure::{I32x3, ONE_G, Reading};
use serde_json::Value;
use std::rc::Rc;

/// A sensor that is mounted with an offset of X = 1 deg and Y = -0.5 deg, on a surface with X = 2 deg and Y = 1.5 deg, or turned there.
fn mounted(is_turned: bool) -> Box<dyn Motion> {
    let sign = if is_turned { -1.0 } else { 1.0 };
    tilt(1.0 + sign * 2.0, -0.5 + sign * 1.5)
}

/// An angle of 0..360 deg about the Z axis of a sensor with one axis.
fn turned_about_z(degrees: f64) -> Box<dyn Motion> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let part = |part: f64| (part * f64::from(ONE_G)).round() as i32;
    Box::new(Reading {
        acceleration: I32x3 {
            x: part(sin),
            y: part(cos),
            z: 0,
        },
        temperature: 25_00,
        ..Reading::default()
    })
}

/// A sensor in its first position.
fn placed(product: &str, first: Box<dyn Motion>) -> Rig {
    let mut rig = Rig::with(product);
    let id = rig.first();
    rig.bus.borrow_mut().device_mut(id).set_motion(first);
    rig.run(3000);
    rig
}

/// Runs the tool, and turns the sensor in the second measurement: it begins about 4 s after the command.
fn turned(rig: &mut Rig, arguments: &str, motion: fn() -> Box<dyn Motion>) -> Ended {
    let (id, at) = (rig.first(), rig.later(6500));
    let turn = move |bus: &mut Bus| bus.device_mut(id).set_motion(motion());
    rig.events.push((at, Rc::new(turn)));
    rig.tool(arguments)
}

/// The same, which must succeed; its document.
#[track_caller]
fn aligned(rig: &mut Rig, motion: fn() -> Box<dyn Motion>) -> Value {
    let ended = turned(rig, "--json align --save", motion);
    assert_eq!(ended.code, 0, "{ended:?}");
    serde_json::from_str(&ended.out).expect("a document")
}

fn number(document: &Value, name: &str) -> f64 {
    document[name]["value"].as_f64().expect("a number")
}

/// GEMAC: SensorErrorX and SensorErrorY (table 12). IMS360: bit 1 of the status byte ST0 (7.2.27). TILTIX: a major fault in the status of
/// the identity object.
#[test]
fn angles_of_a_sensor_that_reports_an_error_are_not_taken() {
    for (product, axis) in [
        ("is1", "axis-y"),
        ("is2", "axis-z"),
        ("ims360", "axis-z"),
        ("tiltix080", "axis-z"),
        ("tiltix360", "axis-y"),
    ] {
        for fault in [axis, "silent"] {
            let mut rig = placed(product, broken(product, fault));
            let ended = rig.tool("align --save");
            assert_eq!(ended.code, 1, "{product} {fault}: {ended:?}");
            let is_told = ended.notes.contains("reports an error");
            assert!(is_told, "{product} {fault}: {ended:?}");
            let mut questions = rig.questions.iter();
            let is_asked = questions.any(|question| question.contains("Turn"));
            assert!(!is_asked, "{product} {fault}: {:?}", rig.questions);
        }
    }
}

/// J1939-71: a field with error indicators has no angle.
#[test]
fn angles_with_error_indicators_are_not_taken() {
    let mut rig = j1939::network("");
    let id = rig.first();
    let motion = broken("ims360", "axis-z");
    rig.bus.borrow_mut().device_mut(id).set_motion(motion);
    rig.run(3000);
    assert_eq!(rig.fails("align"), (1, "no-angle".to_owned()));
    assert!(rig.questions.is_empty());
}

#[test]
fn angles_are_not_taken_if_the_sensor_does_not_tell_its_status() {
    let mut rig = placed("ims360", mounted(false));
    rig.lost = |frame| frame.bytes().starts_with(&[0x40, 0x00, 0x30, 0x01]);
    assert_eq!(rig.fails("align"), (1, "no-angle".to_owned()));
    assert!(rig.questions.is_empty());
}

/// The list of errors has those that have ended too, and the status other faults: they do not make an angle wrong.
#[test]
fn errors_that_have_ended_and_other_errors_prevent_no_measurement() {
    for (product, setting) in [
        ("is2", "cyclic-time=100ms"),
        ("ims360", "filter-type=0"),
        ("tiltix080", "size-of-moving-average-filter=99"),
    ] {
        let mut rig = placed(product, broken(product, "zero"));
        let id = rig.first();
        let motion = mounted(false);
        rig.bus.borrow_mut().device_mut(id).set_motion(motion);
        rig.run(3000);
        // The memory fails: another error is active.
        rig.bus
            .borrow_mut()
            .device_mut(id)
            .flash()
            .fail_writes(true);
        rig.tool(&format!("set {setting} --save"));
        rig.run(2000);
        if product == "ims360" {
            let register = &rig.json("get error-register")["error-register"];
            assert_eq!(register["raw"], 0x81);
            let is_listed = |sub| rig.done(&format!("raw 1003:{sub}")) == "02 FF 00 00\n";
            assert!((1..=8).any(is_listed));
        }
        rig.yes_to = Some("Turn the sensor");
        let ended = turned(&mut rig, "align", || mounted(true));
        assert_eq!(ended.code, 2, "{product}: {ended:?}");
        let last = rig.questions.last().expect("a question");
        let mounting = last.split_once("; mounting ").map(|(_, rest)| rest);
        let mounting = mounting.and_then(|rest| rest.split_once(' ')?.0.parse::<f64>().ok());
        // The mean of both positions has noise.
        let is_right = mounting.is_some_and(|angle| (angle - 1.0).abs() < 0.03);
        assert!(is_right, "{product}: {last}");
    }
}

#[test]
fn align_of_every_product_makes_the_offset_of_the_mounting_zero() {
    for (product, [x, y]) in [
        ("is2", ["angle-x", "angle-y"]),
        ("is2dm", ["angle-x", "angle-y"]),
        ("ims360", ["slope-long32", "slope-lateral32"]),
        ("tiltix080", ["slope-long16", "slope-lateral16"]),
    ] {
        let mut rig = placed(product, mounted(false));
        let first = rig.json(&format!("get {x} {y}"));
        let report = aligned(&mut rig, || mounted(true));
        let angles = report["angles"].as_array().expect("angles");
        let [x_angle, y_angle] = &angles[..] else {
            panic!("{product}: {report}");
        };
        for (angle, name) in [(x_angle, x), (y_angle, y)] {
            assert_eq!(angle["name"], name);
            let first = number(&first, name);
            let wrong = (angle["first"].as_f64().unwrap() - first).abs();
            assert!(wrong < 0.06, "{product}: {report}");
            let spread = angle["spread"].as_f64().unwrap();
            assert!(spread < 0.1, "{product}: {report}");
        }
        // After the turn, without the offset, each angle is the negative inclination of the surface. It is kept at power-off.
        rig.run(3000);
        rig.power_cycle(rig.first());
        let now = rig.json(&format!("get {x} {y}"));
        for (angle, name) in [(x_angle, x), (y_angle, y)] {
            let surface = angle["surface"].as_f64().unwrap();
            assert!(surface.abs() > 1.4, "{product}: {report}");
            let sum = surface + number(&now, name);
            assert!(sum.abs() < 0.06, "{product} {name}: {now} {report}");
        }
    }
}

#[test]
fn align_in_j1939_makes_the_offset_of_the_mounting_zero() {
    let mut rig = placed("ims360", mounted(false));
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    rig.done("--node 50 raw 3100:1=01");
    rig.done("--node 50 save");
    rig.done("--node 50 restart");
    rig.run(1000);
    let report = aligned(&mut rig, || mounted(true));
    let angles = report["angles"].as_array().expect("angles");
    for (angle, [mounting, surface]) in angles.iter().zip([[1.0, 2.0], [-0.5, 1.5]]) {
        for (name, expected) in [("mounting", mounting), ("surface", surface)] {
            let wrong = angle[name].as_f64().unwrap() - expected;
            assert!(wrong.abs() < 0.06, "{name}: {report}");
        }
    }
    let offset = number(&rig.json("get zero-x"), "zero-x");
    assert!((offset + 1.0).abs() < 0.06, "{offset}: {report}");
}

#[test]
fn align_of_a_full_turn_counts_over_0_deg() {
    for (product, name) in [("is1", "angle"), ("tiltix360", "slope-long16")] {
        let mut rig = placed(product, turned_about_z(2.0));
        let report = aligned(&mut rig, || turned_about_z(359.0));
        let angle = &report["angles"][0];
        let mounting = angle["mounting"].as_f64().unwrap();
        assert!((mounting.abs() - 0.5).abs() < 0.06, "{product}: {report}");
        let surface = angle["surface"].as_f64().unwrap();
        assert!((surface.abs() - 1.5).abs() < 0.06, "{product}: {report}");
        let now = number(&rig.json(&format!("get {name}")), name);
        let wrong = (now + surface + 180.0).rem_euclid(360.0) - 180.0;
        assert!(wrong.abs() < 0.06, "{product}: {now}, {report}");
    }
}

#[test]
fn align_of_an_aligned_sensor_keeps_its_offset() {
    for (product, offset) in [
        ("is2", "zero-x"),
        ("ims360", "zero-x"),
        ("tiltix080", "differential-slope-long16-offset"),
    ] {
        let mut rig = placed(product, mounted(false));
        aligned(&mut rig, || mounted(true));
        let first = number(&rig.json(&format!("get {offset}")), offset);
        assert!(first.abs() > 0.9, "{product}: {first}");
        aligned(&mut rig, || mounted(false));
        let second = number(&rig.json(&format!("get {offset}")), offset);
        assert!((first - second).abs() < 0.06, "{product}: {first} {second}");
    }
}

#[test]
fn offset_of_a_preset_counts_when_scaling_is_switched_on() {
    let mut rig = placed("tiltix080", mounted(false));
    rig.done("set slope-long16-preset-value=10deg");
    rig.done("set slope-long16-preset-enable=on");
    rig.done("set slope-long16-preset-enable=off");
    let report = aligned(&mut rig, || mounted(true));
    let surface = report["angles"][0]["surface"].as_f64().unwrap();
    let now = number(&rig.json("get slope-long16"), "slope-long16");
    assert!((now + surface).abs() < 0.06, "{now}: {report}");
}

#[test]
fn align_changes_nothing_without_a_turn_or_a_yes() {
    for yes_to in ["Turn the sensor", "nothing"] {
        let mut rig = placed("is2", mounted(false));
        rig.yes_to = Some(yes_to);
        let ended = turned(&mut rig, "align", || mounted(true));
        assert_eq!(ended.code, 2, "{ended:?}");
        assert!(ended.notes.contains("nothing has changed"), "{ended:?}");
        assert_eq!(number(&rig.json("get zero-x"), "zero-x"), 0.0);
    }
    // The question whether the sensor is turned has no other answer than that of a user.
    let mut rig = placed("is2", mounted(false));
    rig.says_yes = false;
    assert_eq!(rig.fails("align --yes"), (2, "not-confirmed".to_owned()));
    assert!(rig.questions[0].contains("spread"), "{:?}", rig.questions);
}

#[test]
fn align_refuses_motion_and_a_sensor_without_an_offset() {
    let mut rig = Rig::with("jn2101");
    assert_eq!(rig.fails("align"), (2, "not-offered".to_owned()));
    assert!(rig.questions.is_empty());
    let mut rig = Rig::with("is2");
    let id = rig.first();
    for step in 0..200 {
        let sways = move |bus: &mut Bus| {
            bus.device_mut(id)
                .set_motion(tilt(f64::from(step % 2), 0.0));
        };
        let at = rig.later(step * 700);
        rig.events.push((at, Rc::new(sways)));
    }
    let ended = rig.tool("align");
    assert_eq!(ended.code, 1, "{ended:?}");
    assert!(ended.notes.contains("not at rest for 60 s"), "{ended:?}");
    assert!(rig.questions.is_empty());
}

#[test]
fn align_ends_if_the_adapter_or_the_sensor_is_gone() {
    let mut rig = Rig::with("is2");
    rig.cut = Some(40);
    assert_eq!(rig.tool("align").code, 4);
    let mut rig = Rig::with("is2");
    rig.deaf = Some((rig.later(2000), rig.later(600_000)));
    assert_eq!(rig.fails("align"), (3, "no-answer".to_owned()));
}
