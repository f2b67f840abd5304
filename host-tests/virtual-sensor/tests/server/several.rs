//! Several sensors on one bus.

use crate::process::control::{Control, start};
use crate::process::{assert_fails, new_path, text};
use serde_json::{Value, json};

#[test]
fn sensors_of_one_bus_have_their_own_names_scenes_and_memories() {
    let store = new_path("second.store");
    let arguments = [
        &["--bus-rate", "125", "--clock", "client"][..],
        &["--scene", "tilt=1,2", "--model", "jn2101"],
        &[
            "--model",
            "ims360",
            "--scene",
            "tilt=5,6",
            "--store",
            text(&store),
        ],
        &["--model=JN2101", "--scene", "tilt=-3,4"],
    ]
    .concat();
    let (_sensor, port) = start(&arguments);
    let mut control = Control::connect(port);
    let sensors = control.ok(&json!({ "do": "sensors" }));
    let names: Vec<&Value> = (0..3).map(|at| &sensors["sensors"][at]["sensor"]).collect();
    assert_eq!(names, ["jn2101", "ims360", "jn2101-2"]);
    let (_, answer) = control.ask(r#"{"do":"state"}"#);
    let error = answer["error"].as_str().expect("an error");
    assert!(error.contains("jn2101, ims360, jn2101-2"), "{error}");
    control.ok(&json!({ "do": "tilt", "sensor": "jn2101-2", "x": 20, "y": 0 }));
    control.ok(&json!({ "do": "power", "sensor": "ims360", "on": false }));
    control.frames(2.0);
    let mut state = |name| control.ok(&json!({ "do": "state", "sensor": name }));
    assert_eq!(state("jn2101")["angles"], json!([1.0, 2.0]));
    assert_eq!(state("jn2101-2")["angles"], json!([20.0, 0.0]));
    let off = state("ims360");
    assert_eq!((&off["on"], &off["angles"]), (&json!(false), &Value::Null));
}

#[test]
fn second_sensor_with_option_of_the_bus_or_store_of_the_first_is_refused() {
    let two = ["--model", "is2", "--model", "is1"];
    let store = new_path("one-for-two.store");
    let own = ["--store", text(&store)];
    let shared = [&two[..2], &own, &two[2..], &own].concat();
    assert_fails(&shared, 2, &["the same store", text(&store)]);
    assert_fails(
        &[&two[..], &["--bus-rate", "125"]].concat(),
        2,
        &["--bus-rate"],
    );
    assert_fails(&[&two[..], &["--model", "is3"]].concat(), 2, &["is3"]);
}
