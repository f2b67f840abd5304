//! What the program writes while it runs, and its end: frames, the log, the terminal.

use crate::process::client::Client;
use crate::process::sensor::{self, Killed, PATIENCE, Sensor};
use crate::process::{new_path, text};
use host_tests::python;
use std::fs;
use std::io::Read;
use std::net::TcpStream;
use std::time::Instant;

#[test]
fn sensor_reports_tilt_of_scene() {
    let sensor = Sensor::start(&["--scene", "tilt=12.34,-5.67"]);
    let mut client = Client::awake(&sensor);
    let end = Instant::now() + PATIENCE;
    loop {
        let (x, y) = client.poll();
        if (x - 1234).abs() <= 1 && (y + 567).abs() <= 1 {
            break;
        }
        assert!(Instant::now() < end, "{x} {y}");
    }
}

#[test]
fn log_has_candump_format_and_is_written_at_once() {
    let path = new_path("followed.log");
    let sensor = Sensor::start(&["--log", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.poll();
    client.expect("R123456788", "Z");
    client.poll();
    // The log line is written before the client receives the frame, or just after.
    let end = Instant::now() + PATIENCE;
    let log = loop {
        let log = fs::read_to_string(&path).expect("it is there");
        if log.lines().rev().take(2).any(|line| line.contains(" 301#")) && log.contains("#R8") {
            break log;
        }
        assert!(Instant::now() < end, "{log}");
    };
    let mut last = 0.0;
    for line in log.lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [time, "can0", _] = fields[..] else {
            panic!("{line}");
        };
        let time = time
            .strip_prefix('(')
            .and_then(|time| time.strip_suffix(')'))
            .expect("(time)");
        assert_eq!(
            time.split_once('.').map(|(_, fraction)| fraction.len()),
            Some(6),
            "{line}"
        );
        let time: f64 = time.parse().expect("a number");
        assert!(time >= last, "{line}");
        last = time;
    }
    let now = std::time::UNIX_EPOCH
        .elapsed()
        .expect("a clock")
        .as_secs_f64();
    assert!((now - last).abs() < 60.0);
    assert!(log.contains(" can0 300#00\n") && log.contains(" can0 12345678#R8\n"));
    assert!(log.contains(" can0 301#FF"));
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_ends_program_with_one_sentence() {
    let mut sensor = Sensor::start(&["--log", "/dev/full"]);
    let mut client = Client::open(&sensor);
    client.say("t1230");
    assert_eq!(sensor.exit_code(), Some(1));
    let errors = sensor.errors();
    assert!(
        errors.starts_with("virtual-sensor: cannot write the log /dev/full: "),
        "{errors}"
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_exits_cleanly_with_only_address_printed() {
    let mut sensor = Sensor::start(&[]);
    let mut client = Client::awake(&sensor);
    client.poll();
    assert_eq!(sensor.interrupt(), Some(0));
    assert_eq!(sensor.rest(), Vec::<String>::new());
    assert_eq!(sensor.errors(), "");
    let mut rest = Vec::new();
    // The connection ends, with or without an error.
    let _ = client.stream.read_to_end(&mut rest);
    assert!(rest.is_empty());
}

#[test]
fn python_can_connects_and_polls() {
    let log = new_path("python-can.log");
    let mut arguments = vec!["--log", text(&log)];
    if cfg!(unix) {
        arguments.push("--pty");
    }
    let mut sensor = Sensor::start(&arguments);
    let socket = sensor.channel();
    let mut script = vec![
        "--log".into(),
        text(&log).to_owned(),
        socket.clone(),
        socket,
    ];
    if cfg!(unix) {
        let line = sensor.line();
        script.push(
            line.strip_prefix("slcan ")
                .expect("slcan /dev/...")
                .to_owned(),
        );
    }
    let script: Vec<&str> = script.iter().map(String::as_str).collect();
    python::run("smoke.py", &["can", "serial"], &script);
}

#[cfg(unix)]
#[test]
fn status_line_is_shown_on_terminal() {
    use rustix::fs::{Mode, OFlags};
    use rustix::process::{Pid, Signal, kill_process};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::tcgetattr;
    use std::process::Stdio;
    let screen =
        openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&screen).expect("a terminal");
    unlockpt(&screen).expect("a terminal");
    let path = ptsname(&screen, Vec::new()).expect("a terminal");
    let output = rustix::fs::open(
        path.as_c_str(),
        OFlags::RDWR | OFlags::NOCTTY,
        Mode::empty(),
    )
    .expect("it is there");
    let before = format!("{:?}", tcgetattr(&screen).expect("a terminal"));
    let child = sensor::program()
        .args(["--listen", "127.0.0.1:0", "--scene", "tilt=30,-10"])
        .stdin(Stdio::null())
        .stdout(output)
        .spawn()
        .expect("the program starts");
    let mut child = Killed(child);
    let mut screen = fs::File::from(screen);
    let mut shown = String::new();
    // Reads until all of these have been shown in this order.
    let mut wait_for = |shown: &mut String, texts: &[&str]| {
        let end = Instant::now() + PATIENCE;
        let mut from = shown.len();
        for text in texts {
            while !shown[from..].contains(text) {
                assert!(Instant::now() < end, "{text} is not in {shown}");
                let mut buffer = [0; 4096];
                let length = screen.read(&mut buffer).expect("a terminal");
                *shown += std::str::from_utf8(&buffer[..length]).unwrap_or_default();
            }
            from += shown[from..].find(text).unwrap_or_default();
        }
    };
    wait_for(
        &mut shown,
        &[
            "slcan socket://127.0.0.1:",
            "\n",
            "30.00°",
            "-10.00°",
            // It detects the bit rate.
            "run flickering",
            "clients 0",
        ],
    );
    let port = shown["slcan socket://127.0.0.1:".len()..]
        .lines()
        .next()
        .unwrap_or_default();
    let client = TcpStream::connect(format!("127.0.0.1:{}", port.trim_end())).expect("it listens");
    wait_for(&mut shown, &["clients 1"]);
    drop(client);
    wait_for(&mut shown, &["clients 0"]);
    assert!(shown.starts_with("slcan socket://127.0.0.1:"));
    assert!(shown.contains("is2 ") && shown.contains("run") && shown.contains("kbit/s"));
    kill_process(Pid::from_child(&child.0), Signal::INT).expect("it runs");
    assert_eq!(child.0.wait().expect("a child").code(), Some(0));
    assert_eq!(
        format!("{:?}", tcgetattr(&screen).expect("a terminal")),
        before
    );
    let mut rest = Vec::new();
    // Reading a terminal without a program ends with an error.
    let _ = screen.read_to_end(&mut rest);
    assert!(rest.ends_with(b"\n"));
    // Every mode that a line switches off is on again at its end.
    shown += &String::from_utf8_lossy(&rest);
    assert_eq!(
        shown.matches("\x1b[?7l").count(),
        shown.matches("\x1b[?7h").count()
    );
}
