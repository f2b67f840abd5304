//! Clients that control the sensor (`--control`): its motion, its faults, its memory, its bus.

use crate::process::control::{Control, start};
use crate::process::sensor::Sensor;
use serde_json::{Value, json};

/// An is2 that has sent its boot-up messages.
fn awake() -> (Sensor, Control) {
    let common = ["--clock", "client", "--scene", "tilt=3,4"];
    let (sensor, port) = start(&[&common[..], &crate::firmware("is2")].concat());
    let mut control = Control::connect(port);
    let (_, answer) = control.ask(r#"{"do":"subscribe","events":["frames","state"]}"#);
    assert!(answer["ok"].is_object(), "{answer}");
    control.answer("300#00", "301#FF");
    (sensor, control)
}

/// X and Y of a poll in 0.01 deg.
#[track_caller]
fn poll(control: &mut Control) -> (i16, i16) {
    let data = control.answer("300#00", "301#00");
    let value = |at: usize| {
        let value = u16::from_str_radix(&data[at..at + 4], 16).expect("hexadecimal");
        value.swap_bytes() as i16
    };
    (value(2), value(6))
}

#[test]
fn sensor_follows_its_motion() {
    let (_sensor, mut control) = awake();
    let near = |(x, y): (i16, i16), to: (i16, i16)| {
        assert!(
            (x - to.0).abs() <= 4 && (y - to.1).abs() <= 4,
            "{x},{y} {to:?}"
        );
    };
    control.ok(&json!({ "do": "tilt", "x": -12.5, "y": 30 }));
    control.frames(1.5);
    near(poll(&mut control), (-1250, 3000));
    let turn = json!({ "do": "rate", "x": 10, "y": -5, "seconds": 2 });
    assert_eq!(control.ok(&turn)["to"], json!([7.5, 20.0]));
    control.frames(4.0);
    near(poll(&mut control), (750, 2000));
    let csv = "t_s,ax_g,ay_g,az_g\n0,0,0,1\n1,-0.5,0,0.8660254\n";
    control.ok(&json!({ "do": "scene", "csv": csv }));
    control.frames(3.0);
    near(poll(&mut control), (3000, 0));
    control.ok(&json!({ "do": "temperature", "celsius": 61.5 }));
    control.ok(&json!({ "do": "supply", "volts": 9.5 }));
    let state = control.ok(&json!({ "do": "state" }));
    assert_eq!(state["temperature"], 61.5);
    assert_eq!(state["supply"], 9.5);
}

#[test]
fn repaired_accelerometer_measures_again() {
    let (_sensor, mut control) = awake();
    for fault in ["silent", "stopped", "frozen", "zero", "axis-z", "clipping"] {
        control.ok(&json!({ "do": "accelerometer", "fault": fault }));
        control.frames(2.0);
        let bad = control.answer("300#00", "301#00");
        assert_ne!(&bad[..2], "03", "{fault}");
        control.ok(&json!({ "do": "accelerometer", "fault": null }));
        control.frames(2.0);
        let good = control.answer("300#00", "301#00");
        assert_eq!(&good[..2], "03", "{fault}");
    }
}

#[test]
fn memory_keeps_what_was_saved_before_its_faults() {
    let (_sensor, mut control) = awake();
    // Cyclic time 20 ms (25h), SAVE.
    let save = |control: &mut Control| control.answer("300#5053415645", "301#50");
    control.answer("300#251400", "301#25");
    let good = save(&mut control);
    control.frames(0.1);
    let before = control.ok(&json!({ "do": "image" }));
    control.ok(&json!({ "do": "memory", "fault": "programming" }));
    control.answer("300#251E00", "301#25");
    assert_ne!(save(&mut control), good);
    let after = control.ok(&json!({ "do": "image" }));
    assert_eq!(before["parameters"], after["parameters"]);
    control.ok(&json!({ "do": "memory", "fault": null }));
    control.ok(&json!({ "do": "cut-in-save", "operations": 2, "seed": 7 }));
    control.ok(&json!({ "do": "send", "frame": "300#5053415645" }));
    control.frames(0.3);
    let state = control.ok(&json!({ "do": "state" }));
    assert_eq!((&state["on"], &state["boots"]), (&json!(false), &json!(1)));
    control.ok(&json!({ "do": "power", "on": true }));
    control.frames(0.1);
    control.answer("300#00", "301#FF");
    assert_eq!(&control.answer("300#15", "301#15")[2..6], "1400");
    control.answer("300#251E00", "301#25");
    save(&mut control);
    control.ok(&json!({ "do": "damage" }));
    assert_eq!(control.ok(&json!({ "do": "image" }))["damaged"], true);
}

#[test]
fn sensor_goes_bus_off_and_returns() {
    let (_sensor, mut control) = awake();
    control.ok(&json!({ "do": "bus-off" }));
    control.ok(&json!({ "do": "send", "frame": "300#00" }));
    let (events, _) = control.ask(r#"{"do":"advance","seconds":0.1}"#);
    let states: Vec<&Value> = events.iter().map(|event| &event["bus"]).collect();
    let bus_off = json!("bus-off");
    assert!(states.contains(&&bus_off), "{events:?}");
    control.ok(&json!({ "do": "restart" }));
    control.frames(0.1);
    control.answer("300#00", "301#FF");
}
