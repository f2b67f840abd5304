//! Clients that control the sensor (`--control`).

use crate::image::image_for;
use crate::process::client::{BOOT_UP, Client, POLL, REPLY};
use crate::process::sensor::{PATIENCE, Sensor};
use crate::{assert_fails, new_path, text};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::{Shutdown, TcpStream};
use stm32_sim::board::Board;
use stm32_sim::firmware;

/// A control client of a sensor.
pub struct Control(BufReader<TcpStream>);

impl Control {
    pub fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
        stream.set_nodelay(true).expect("a socket");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        Self(BufReader::new(stream))
    }

    pub fn say(&mut self, bytes: &[u8]) {
        self.0.get_mut().write_all(bytes).expect("it accepts");
    }

    /// The next line; None at the end.
    pub fn next(&mut self) -> Option<Value> {
        let mut line = String::new();
        self.0.read_line(&mut line).expect("a line");
        (!line.is_empty()).then(|| serde_json::from_str(&line).expect("JSON"))
    }

    /// Sends a request; returns the events before the answer, and the answer.
    pub fn ask(&mut self, request: &str) -> (Vec<Value>, Value) {
        self.say(format!("{request}\n").as_bytes());
        let mut events = Vec::new();
        loop {
            match self.next().expect("an answer") {
                event if event.get("event").is_some() => events.push(event),
                answer => return (events, answer),
            }
        }
    }

    /// Sends a request that must succeed; returns the members of the answer.
    #[track_caller]
    pub fn ok(&mut self, request: &Value) -> Value {
        let (_, mut answer) = self.ask(&request.to_string());
        assert!(answer.get("error").is_none(), "{request}: {answer}");
        answer["ok"].take()
    }

    /// The frames in this time.
    pub fn frames(&mut self, seconds: f64) -> Vec<String> {
        let request = json!({ "do": "advance", "seconds": seconds });
        let (events, _) = self.ask(&request.to_string());
        let frames = events.iter().filter_map(|event| event["frame"].as_str());
        frames.map(str::to_owned).collect()
    }

    /// The data of the answer to this request.
    #[track_caller]
    pub fn answer(&mut self, request: &str, beginning: &str) -> String {
        self.ok(&json!({ "do": "send", "frame": request }));
        let frames = self.frames(0.3);
        let answer = frames
            .iter()
            .find_map(|frame| frame.strip_prefix(beginning));
        answer
            .unwrap_or_else(|| panic!("no {beginning}: {frames:?}"))
            .to_owned()
    }
}

/// A sensor with this command line, and the port for control.
pub fn start(arguments: &[&str]) -> (Sensor, u16) {
    let mut sensor = Sensor::start(&[&["--control", "0"], arguments].concat());
    let line = sensor.line();
    let port = line.strip_prefix("control socket://127.0.0.1:");
    let port = port.and_then(|port| port.parse().ok());
    (
        sensor,
        port.unwrap_or_else(|| panic!("the second line is {line:?}")),
    )
}

/// An is2 that has sent its boot-up messages: built for the PC, and as the image for the Blue Pill.
fn awake() -> impl Iterator<Item = (Sensor, Control)> {
    let image = image_for(Board::BluePill, "is2");
    let image = image.to_str().expect("a path in UTF-8").to_owned();
    [vec![], vec!["--elf".to_owned(), image]]
        .into_iter()
        .map(|own| {
            let own: Vec<&str> = own.iter().map(String::as_str).collect();
            let common = ["--clock", "client", "--scene", "tilt=3,4"];
            let (sensor, port) = start(&[&common[..], &own].concat());
            let mut control = Control::connect(port);
            let (_, answer) = control.ask(r#"{"do":"subscribe","events":["frames","state"]}"#);
            assert!(answer["ok"].is_object(), "{answer}");
            control.answer("300#00", "301#FF");
            (sensor, control)
        })
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
fn dialogs_of_readme_are_those_of_the_program() {
    let readme = include_str!("../../README.md");
    let mut current: Option<(Sensor, Control)> = None;
    let mut dialogs = 0;
    for line in readme.lines() {
        if let Some(command) = line.strip_prefix("$ virtual-sensor --control 0 ") {
            let arguments = shlex::split(command).expect("a command line");
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let (sensor, port) = start(&arguments);
            current = Some((sensor, Control::connect(port)));
            dialogs += 1;
        } else if let Some(request) = line.strip_prefix("> ") {
            let (_, control) = current.as_mut().expect("a command line");
            control.say(format!("{request}\n").as_bytes());
        } else if let Some(expected) = line.strip_prefix("< ") {
            let (_, control) = current.as_mut().expect("a command line");
            let expected: Value = serde_json::from_str(expected).expect("JSON");
            assert_eq!(control.next(), Some(expected));
        }
    }
    assert!(dialogs > 4);
}

#[test]
fn sensor_follows_its_motion() {
    for (_sensor, mut control) in awake() {
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
}

#[test]
fn repaired_accelerometer_measures_again() {
    for (_sensor, mut control) in awake() {
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
}

#[test]
#[ignore = "another measuring element: `.ci/run boards`"]
fn fault_that_the_adxl355_of_an_image_cannot_have_is_refused() {
    let built = firmware::build_for_element(Board::BluePill, &["is2"], "adxl355");
    let built = built.expect("it builds");
    let image = ["--elf", text(&built["is2"])];
    let (_sensor, port) = start(&[&["--clock", "client"], &image[..]].concat());
    let mut control = Control::connect(port);
    for fault in ["silent", "stopped", "frozen"] {
        let request = json!({ "do": "accelerometer", "fault": fault });
        let (_, answer) = control.ask(&request.to_string());
        let error = format!("the ADXL355 of the simulated board has no fault {fault}");
        assert_eq!(answer, json!({ "error": error }));
    }
    control.ok(&json!({ "do": "accelerometer", "fault": "zero" }));
}

#[test]
fn memory_keeps_what_was_saved_before_its_faults() {
    for (_sensor, mut control) in awake() {
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
}

#[test]
fn sensor_goes_bus_off_and_returns() {
    for (_sensor, mut control) in awake() {
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
}

#[test]
fn lost_and_late_frames_are_on_the_bus_but_not_at_the_client() {
    let (sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let mut control = Control::connect(port);
    let mut client = Client::open(&sensor);
    control.ok(&json!({ "do": "subscribe", "events": ["frames"] }));
    client.expect(POLL, "z");
    control.frames(0.2);
    client.find(BOOT_UP);
    client.find(BOOT_UP);
    let lose = json!({ "do": "lose", "count": 1, "from": "sensors", "identifier": "301" });
    assert_eq!(control.ok(&lose)["clients"], 1);
    let delay = json!({ "do": "delay", "count": 1, "from": "sensors", "seconds": 0.5 });
    control.ok(&delay);
    for _ in 0..2 {
        client.expect(POLL, "z");
        let frames = control.frames(0.1);
        assert!(
            frames.iter().any(|frame| frame.starts_with("301#00")),
            "{frames:?}"
        );
    }
    // Nothing has come before the answer.
    client.expect("V", "V1010");
    control.frames(0.6);
    assert!(client.next().is_some_and(|line| line.starts_with('#')));
    assert!(client.next().is_some_and(|line| line.starts_with(REPLY)));
    control.ok(&json!({ "do": "lose", "count": 1, "from": "clients" }));
    client.expect(POLL, "z");
    assert_eq!(control.frames(0.1), [""; 0]);
    control.ok(&json!({ "do": "delay", "count": 1, "from": "clients", "seconds": 0.2 }));
    client.expect(POLL, "z");
    assert_eq!(control.frames(0.19), [""; 0]);
    assert_eq!(control.frames(0.1).len(), 2);
}

#[test]
fn nonsense_gets_an_error_and_changes_nothing() {
    let (sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let mut control = Control::connect(port);
    let before = control.ok(&json!({ "do": "state" }));
    for bad in [
        "{",
        "[]",
        "null",
        "\"do\"",
        "{}",
        r#"{"do":1}"#,
        r#"{"do":"tilt","x":1}"#,
        r#"{"do":"tilt","x":"1","y":2}"#,
        r#"{"do":"tilt","x":1e999,"y":2}"#,
        r#"{"do":"tilt","x":1,"y":2,"sensor":5}"#,
        r#"{"do":"tilt","x":1,"y":2,"sensor":"is1"}"#,
        r#"{"do":"state","all":true}"#,
        r#"{"do":"rate","x":1,"y":2,"seconds":-1}"#,
        r#"{"do":"scene"}"#,
        r#"{"do":"scene","file":"/dev/zero"}"#,
        r#"{"do":"scene","file":"a","csv":"b"}"#,
        r#"{"do":"temperature","celsius":1e9}"#,
        r#"{"do":"supply","volts":-1}"#,
        r#"{"do":"memory","fault":"broken"}"#,
        r#"{"do":"damage"}"#,
        r#"{"do":"bus-off"}"#,
        r#"{"do":"corrupt","count":-1}"#,
        r#"{"do":"send","frame":"300"}"#,
        r#"{"do":"send","frame":"800#"}"#,
        r#"{"do":"advance","seconds":1,"sensor":"is2"}"#,
        r#"{"do":"advance","seconds":-1}"#,
        r#"{"do":"subscribe","events":"leds"}"#,
        "\u{0}\u{1}\u{7f}",
    ] {
        let (events, answer) = control.ask(bad);
        assert!(
            answer["error"].is_string() && events.is_empty(),
            "{bad}: {answer}"
        );
    }
    control.say(b"\xFF\xFE{\"do\"\n");
    assert!(control.next().expect("an answer")["error"].is_string());
    // Lines of 1 MiB and more, and empty lines, which are no requests.
    for length in [1 << 20, 5 << 20] {
        control.say(&vec![b'['; length]);
        control.say(b"\r\n\r\n\n");
        assert!(control.next().expect("an answer")["error"].is_string());
    }
    // A client that leaves in the middle of a line, and one that does not read.
    let mut half = Control::connect(port);
    half.say(br#"{"do":"tilt","x":50"#);
    half.0
        .get_mut()
        .shutdown(Shutdown::Write)
        .expect("a socket");
    assert_eq!(half.next(), None);
    assert_eq!(control.ok(&json!({ "do": "state" })), before);
    Client::open(&sensor);
}

#[test]
fn each_client_sees_its_events_and_what_the_others_do() {
    let (_sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let (mut one, mut other) = (Control::connect(port), Control::connect(port));
    one.ok(&json!({ "do": "subscribe", "events": ["state"] }));
    other.ok(&json!({ "do": "power", "on": false }));
    let event = one.next().expect("an event");
    assert_eq!(
        (&event["event"], &event["on"]),
        (&json!("state"), &json!(false))
    );
    one.ok(&json!({ "do": "subscribe", "events": [] }));
    other.ok(&json!({ "do": "power", "on": true }));
    let (events, _) = one.ask(r#"{"do":"sensors"}"#);
    assert_eq!(events, [Value::Null; 0]);
}

#[test]
fn time_of_the_computer_cannot_be_advanced() {
    let (_sensor, port) = start(&[]);
    let (_, answer) = Control::connect(port).ask(r#"{"do":"advance","seconds":1}"#);
    let error = answer["error"].as_str().expect("an error");
    assert!(error.contains("--clock client"), "{error}");
}

#[test]
fn place_for_control_that_is_in_use_or_wrong_is_named() {
    let (_sensor, port) = start(&[]);
    let used = port.to_string();
    for place in [&used, "nonsense", "99999"] {
        let arguments = ["--listen", "127.0.0.1:0", "--control", place];
        let message = format!("cannot listen at {place} for control");
        assert_fails(&arguments, 1, &[&message]);
    }
}

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
    let store = new_path("shared.store");
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
