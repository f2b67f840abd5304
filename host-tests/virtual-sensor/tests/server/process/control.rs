//! A client that controls the sensors (`--control`).

use super::sensor::{PATIENCE, Sensor};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;

/// A control client of a sensor.
pub struct Control(pub BufReader<TcpStream>);

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
