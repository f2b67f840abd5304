//! A sensor on the bus of an adapter (`--on`): another virtual sensor with its clients, or an adapter that does as a test says.

use crate::process::assert_fails;
use crate::process::client::{Client, POLL, REPLY};
use crate::process::sensor::{PATIENCE, Sensor};
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

/// A bus at 125 kbit/s with a sensor that this test does not use.
fn bus(model: &str) -> Sensor {
    Sensor::start(&["--bus-rate", "125", "--model", model])
}

/// Starts a sensor on the bus of another.
fn on(bus: &Sensor, model: &str) -> Sensor {
    let port = format!("slcan://127.0.0.1:{}", bus.port);
    let mut sensor = Sensor::start(&["--bus-rate", "125", "--on", &port, "--model", model]);
    assert_eq!(sensor.line(), format!("on {port} at 125 kbit/s"));
    sensor
}

/// Sends a request until a line that starts with this text comes.
#[track_caller]
fn ask(bus: &Sensor, request: &str, reply: &str) -> String {
    let mut client = Client::open(bus);
    client.impatient();
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        client.say(request);
        while let Some(line) = client.next_within(Duration::from_millis(200)) {
            if line.starts_with(reply) {
                return line;
            }
        }
    }
    panic!("no {reply}");
}

#[test]
fn sensor_of_each_protocol_answers_on_bus_of_adapter() {
    let can_open = bus("jn2101");
    let fsc = on(&can_open, "is2");
    ask(&can_open, POLL, REPLY);
    let device_net = on(&can_open, "tiltix360");
    // Opens the explicit connection of MAC ID 63; it is refused as in use if an earlier answer came late.
    let answer = ask(&can_open, "t5FE60A4B0301010A", "t5FB");
    assert!(
        ["t5FB30ACB", "t5FB40A94"].contains(&&answer[..9]),
        "{answer}"
    );
    drop((fsc, device_net));
    let other = bus("is2");
    let _sensor = on(&other, "jn2101");
    // The device type of section 14 of the manual of the JN2101.
    ask(&other, "t60A84000100000000000", "t58A8430010009A010400");
}

/// The folder with the library of the tests of the tool, which has the entry points of PCAN-Basic.
#[cfg(target_os = "linux")]
fn pcan() -> &'static str {
    let folder = concat!(env!("CARGO_TARGET_TMPDIR"), "/pcan-on");
    std::fs::create_dir_all(folder).expect("a folder");
    let source = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tool/tests/tool/process/pcan_basic.rs"
    );
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = std::process::Command::new(compiler)
        .args(["--edition", "2024", "--crate-type", "cdylib", "-o"])
        .arg(format!("{folder}/libpcanbasic.so"))
        .arg(source)
        .output()
        .expect("rustc starts");
    assert!(output.status.success(), "{output:?}");
    folder
}

/// The library lets the time of the bus pass.
#[cfg(target_os = "linux")]
#[test]
fn sensor_answers_on_bus_of_pcan_adapter() {
    let bus = Sensor::start(&["--bus-rate", "125", "--clock", "client"]);
    let address = format!("127.0.0.1:{}", bus.port);
    let environment = [("LD_LIBRARY_PATH", pcan()), ("PCAN_TEST_BUS", &address)];
    let arguments = ["--bus-rate", "125", "--on", "pcan", "--model", "jn2101"];
    let mut sensor = Sensor::start_with(&arguments, &environment);
    assert_eq!(sensor.line(), "on pcan at 125 kbit/s");
    ask(&bus, "t60A84000100000000000", "t58A8430010009A010400");
}

#[test]
fn missing_adapter_ends_program_with_a_sentence() {
    for (port, code, words) in [
        ("slcan://127.0.0.1:1", 1, "cannot connect to 127.0.0.1:1"),
        ("slcan:/dev/no-such", 1, "cannot open /dev/no-such"),
        ("slcan:", 2, "slcan: needs a serial port"),
        ("demo:is2", 2, "there is no port \"demo:is2\""),
        ("/dev/ttyACM0", 2, "did you mean slcan:/dev/ttyACM0"),
    ] {
        assert_fails(&["--listen", "127.0.0.1:0", "--on", port], code, &[words]);
    }
    let client = ["--on", "slcan://127.0.0.1:1", "--clock", "client"];
    assert_fails(&client, 2, &["--clock client is not possible"]);
}

#[test]
fn adapter_that_is_unplugged_ends_program_with_a_sentence() {
    let bus = bus("jn2101");
    let mut sensor = on(&bus, "is2");
    drop(bus);
    assert_eq!(sensor.exit_code(), Some(1));
    let errors = sensor.errors();
    assert!(errors.contains("has failed"), "{errors}");
}

/// An adapter that answers each command with CR, except as this says: frames and answers instead of it.
fn adapter(answer: impl Fn(&str) -> Option<String> + Send + 'static) -> (String, Lines) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("a socket").port();
    let (sender, lines) = std::sync::mpsc::channel();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a client");
        let mut reader = BufReader::new(stream.try_clone().expect("a socket"));
        let mut line = Vec::new();
        while reader
            .read_until(b'\r', &mut line)
            .is_ok_and(|count| count > 0)
        {
            let text = String::from_utf8_lossy(&line).trim().to_owned();
            line.clear();
            let answer = answer(&text).unwrap_or_else(|| "\r".to_owned());
            if answer == END || stream.write_all(answer.as_bytes()).is_err() {
                return;
            }
            if sender
                .send((text, stream.try_clone().expect("a socket")))
                .is_err()
            {
                return;
            }
        }
    });
    (format!("slcan://127.0.0.1:{port}"), lines)
}

/// The adapter is unplugged.
const END: &str = "end";

/// The lines that the adapter has received, and its stream.
type Lines = std::sync::mpsc::Receiver<(String, TcpStream)>;

/// Waits for a line that starts with this text.
#[track_caller]
fn wait(lines: &Lines, beginning: &str) -> TcpStream {
    let mut others = Vec::new();
    let end = Instant::now() + PATIENCE;
    loop {
        match lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok((line, stream)) if line.starts_with(beginning) => return stream,
            Ok((line, _)) => others.push(line),
            Err(_) => panic!("no {beginning}: {others:?}"),
        }
    }
}

#[test]
fn adapter_without_bit_rate_of_sensor_ends_program_with_a_sentence() {
    let (port, _lines) = adapter(|line| line.starts_with('S').then(|| "\x07".to_owned()));
    let arguments = [
        "--listen",
        "127.0.0.1:0",
        "--model",
        "jn2101",
        "--on",
        &port,
    ];
    assert_fails(&arguments, 1, &["cannot have 125 kbit/s"]);
}

#[test]
fn errors_of_bus_without_a_frame_are_told_once() {
    let questions = std::sync::atomic::AtomicU32::new(0);
    let (port, lines) = adapter(move |line| match line {
        "F" => {
            questions.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Some("F84\r".to_owned())
        }
        // Its queue is full.
        _ if line.starts_with('t') => Some("\x07".to_owned()),
        _ => None,
    });
    let mut sensor = Sensor::start(&["--model", "jn2101", "--on", &port]);
    let mut stream = wait(&lines, "F");
    // A frame ends the questions. SDO reads, whose answers are refused.
    for _ in 0..2 {
        let request = b"t60A84000100000000000\r";
        stream.write_all(request).expect("a socket");
        wait(&lines, "t58A");
    }
    stream.shutdown(std::net::Shutdown::Both).expect("a socket");
    assert_eq!(sensor.exit_code(), Some(1));
    let errors = sensor.errors();
    let count = |words: &str| errors.matches(words).count();
    assert_eq!(count("whether the bus has 125 kbit/s"), 1, "{errors}");
    assert!(count("refused a frame") >= 1, "{errors}");
}

#[test]
fn adapter_takes_over_new_bit_rate_of_sensor() {
    let (port, lines) = adapter(|_| None);
    let _sensor = Sensor::start(&["--model", "ims360", "--on", &port]);
    // Frames before the answer to O are not for the sensor. Its boot-up message comes after it.
    let mut stream = wait(&lines, "t732100");
    let mut say = |frame: &str| {
        let line = format!("{frame}\r");
        stream.write_all(line.as_bytes()).expect("a socket");
    };
    // LSS: configuration, 500 kbit/s, store; then a reset of the node.
    say("t7E580401000000000000");
    for (request, reply) in [
        ("t7E581300020000000000", "t7E481300"),
        ("t7E581700000000000000", "t7E481700"),
    ] {
        say(request);
        wait(&lines, reply);
    }
    say("t7E580400000000000000");
    say("t00028132");
    for line in ["S6", "O", "t732100"] {
        wait(&lines, line);
    }
}
