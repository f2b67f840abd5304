//! The program as a process, with the server of the virtual sensor: slcan over TCP and on a pseudoterminal.
//!
//! The clock is the time of the bus, except in the tests of python-canopen and of the demonstration.

#[cfg(unix)]
mod bridge;
mod command_line;
mod document;
mod elf;
mod exchange;
#[cfg(unix)]
mod mosquitto;
#[cfg(target_os = "linux")]
mod pcan;
mod questions;
pub mod sensor;

use bench::BusRate;
use plumbline::can::BitRate;
use plumbline::model::catalog::PRODUCTS;
use sensor::{Sensor, document, plumbline, program};
use serde_json::Value;
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use virtual_sensor::server::Clock;

#[test]
fn sensor_is_read_set_and_stored_over_tcp() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    assert_eq!(
        sensor.json("--rate 250 get cyclic-time")["cyclic-time"]["raw"],
        250
    );
    sensor.done("--rate 250 set filter=2.5Hz,butterworth --save");
    let read = sensor.json("--rate 250 get filter");
    assert_eq!(
        (&read["cut-off"]["raw"], &read["filter-type"]["value"]),
        (&Value::from(2500), &Value::from("Butterworth"))
    );
    // The same scheme by its other name.
    let port = sensor.port.replace("slcan://", "socket://");
    let read = document(&sensor.run_at(&port, "--json --rate 250 get cut-off"));
    assert_eq!(read["cut-off"]["raw"], 2500);
    let output = sensor.run("--rate 250 set cyclic-time=0");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("1..65535 ms"),
        "{output:?}"
    );
}

#[test]
fn scan_finds_a_talking_sensor_at_its_rate() {
    let sensor = Sensor::start("jn2101", BusRate::Fixed(BitRate::K125), Clock::Client);
    let rows = sensor.json("scan");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["rate"]),
        (&Value::from("jn2101"), &Value::from(125))
    );
}

#[test]
fn silent_sensor_is_found_after_a_yes() {
    let sensor = Sensor::start("is1", BusRate::Fixed(BitRate::K500), Clock::Client);
    let output = sensor.run("--rate 500 --json scan");
    assert_eq!(
        output.status.code(),
        Some(3),
        "standard input is no terminal: nothing is asked: {output:?}"
    );
    assert!(String::from_utf8_lossy(&output.stderr).contains("nothing was sent"));
    let rows = sensor.json("--rate 500 --yes scan");
    assert_eq!(rows[0]["product"], "is1");
}

#[test]
fn configuration_file_is_read_by_python_canopen() {
    let sensor = Sensor::start("jn2101", BusRate::Follow, Clock::Client);
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("process-dcf.toml");
    let configuration = path.with_extension("dcf");
    for file in [&path, &configuration] {
        let _ = std::fs::remove_file(file);
    }
    let node = "--rate 250 --node 10";
    sensor.done(&format!(
        "{node} set resolution=raw:100 tpdo1-event-timer=20ms heartbeat=500ms"
    ));
    sensor.done(&format!("{node} backup {}", path.display()));
    let file = configuration.display().to_string();
    let values = [
        "6000:0=64",
        "1800:5=14",
        "1017:0=1F4",
        "2000:0=A",
        "1005:0=80",
    ];
    let arguments = [&[file.as_str(), "10", "250"], &values[..]].concat();
    host_tests::python::run("dcf_check.py", &["canopen"], &arguments);
}

/// A device that is not of this project, beside a sensor. The node of python-canopen has the clock of the computer.
#[test]
fn node_of_python_canopen_is_read_and_set_by_its_data_sheet() {
    let sensor = Sensor::start("jn2101", BusRate::Fixed(BitRate::K125), Clock::Computer);
    let eds = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/tool/process/encoder.eds"
    );
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("process-encoder");
    std::fs::create_dir_all(&folder).expect("a folder");
    let folder = folder.display().to_string();
    let address = sensor.port.trim_start_matches("slcan://");
    let arguments = [env!("CARGO_BIN_EXE_plumbline"), address, eds, &folder];
    let modules = ["canopen", "can", "serial"];
    host_tests::python::run("local_node_check.py", &modules, &arguments);
}

#[cfg(unix)]
#[test]
fn serial_port_is_an_adapter() {
    let sensor = Sensor::start("is2", BusRate::Follow, Clock::Client);
    let serial = sensor.serial.as_deref().expect("a pseudoterminal");
    let port = format!("slcan:{serial}");
    let output = sensor.run_at(&port, "--json --rate 250 --id 300 get serial-number");
    assert_eq!(document(&output)["serial-number"]["raw"], 1);
    let watch = "--rate 250 --id 300 watch --every 20 --seconds 3";
    let watched = sensor.run_at(&port, watch);
    let text = String::from_utf8_lossy(&watched.stdout);
    assert_eq!(text.lines().count(), 150, "{watched:?}");
}

/// A modem, or the port of another device: nothing ever comes from it.
#[cfg(unix)]
#[test]
fn serial_port_that_never_answers_ends_the_program_with_what_to_check() {
    let (_other_side, path) = sensor::terminal();
    let port = format!("slcan:{}", path.to_string_lossy());
    let output = program(&port, "computer", "--rate 250 --id 300 get");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{text}");
    for part in [port.as_str(), "plumbline ports", "other program"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The words for an adapter that a technician tries first.
#[test]
fn port_that_is_none_is_refused_with_the_port_that_is_meant() {
    for (port, meant) in [
        ("peak", "did you mean pcan?"),
        ("PCAN-USB", "did you mean pcan?"),
        (
            "slcan:socket://127.0.0.1:1",
            "did you mean slcan://127.0.0.1:1?",
        ),
        ("127.0.0.1:1", "did you mean slcan://127.0.0.1:1?"),
        ("COM3", "did you mean slcan:COM3?"),
        ("demo", "did you mean demo:is2?"),
    ] {
        let output = plumbline(port, "get");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{port} {text}");
        assert!(text.contains(meant), "{port} {text}");
    }
}

#[test]
fn demonstration_needs_no_hardware() {
    for (product, clock) in [
        ("is2", "computer"),
        ("jn2101", "bus"),
        ("ims360", "bus"),
        ("tiltix080", "bus"),
    ] {
        let output = program(&format!("demo:{product}"), clock, "--json --yes zero");
        assert!(document(&output)["zero"].is_object(), "{product}");
    }
    assert_eq!(plumbline("demo:is3", "get").status.code(), Some(2));
}

/// A sensor with one axis that lies flat would have no angle.
#[test]
fn demonstration_of_every_product_sways_slowly_without_an_error() {
    for product in PRODUCTS {
        let port = format!("demo:{}", product.name);
        let output = program(&port, "bus", "--json watch --every 500 --seconds 20");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(!text.contains("Error"), "{port} {text}");
        let angles = text.lines().map(|line| {
            let sample: Value = serde_json::from_str(line).expect("a sample");
            let angle = sample.as_object().and_then(|sample| sample.values().nth(1));
            angle.and_then(Value::as_f64).expect("an angle")
        });
        let angles: Vec<f64> = angles.collect();
        assert_eq!(angles.len(), 40, "{port}");
        let steps = angles.windows(2).map(|pair| {
            let step = (pair[1] - pair[0]).rem_euclid(360.0);
            step.min(360.0 - step)
        });
        let longest = steps.fold(0.0, f64::max);
        assert!((0.1..10.0).contains(&longest), "{port} {longest}");
    }
}

#[test]
fn watch_for_a_second_expects_no_poll_at_its_end() {
    let output = program("demo:is2", "computer", "watch --every 500 --seconds 1");
    let notes = String::from_utf8_lossy(&output.stderr);
    assert!(notes.contains("0 of 2 samples lost"), "{notes}");
}

#[test]
fn missing_adapter_is_exit_code_4_with_a_next_step() {
    // The port of a client is in use, and nobody accepts connections there.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let client = TcpStream::connect(listener.local_addr().expect("an address")).expect("a client");
    let refusing = format!("slcan://{}", client.local_addr().expect("an address"));
    for (port, code) in [
        (refusing.as_str(), 4),
        ("slcan:/dev/nonexistent", 4),
        ("nonexistent0", 4),
        // This adapter does not exist either, also on a computer without USB.
        ("usb:no-such-number", 4),
        ("sub:", 2),
        ("", 2),
    ] {
        let output = plumbline(port, "get");
        assert_eq!(output.status.code(), Some(code), "{port} {output:?}");
        assert!(output.stderr.len() > 60, "{port} {output:?}");
    }
}

/// The settings of cyclic mode are put back, and the file has the samples until then.
#[cfg(unix)]
#[test]
fn ctrl_c_puts_the_settings_back() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    for (product, address, names) in [
        ("is2", "--id 300", "cyclic-time cyclic-mode"),
        (
            "jn2101",
            "--node 10",
            "tpdo1-transmission-type tpdo1-event-timer",
        ),
    ] {
        let sensor = Sensor::start(product, BusRate::Follow, Clock::Client);
        let settings = || sensor.json(&format!("--rate 250 {address} get {names}"));
        let before = settings();
        let watch = format!("--yes --rate 250 {address} watch --cyclic --every 20");
        let mut child = sensor::command(&sensor.port, "bus", &watch)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        for _ in 0..5 {
            lines.next().expect("a sample").expect("text");
        }
        kill_process(Pid::from_child(&child), Signal::INT).expect("it runs");
        // The pipe must not be full before it ends.
        let more = lines.map_while(Result::ok).count();
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(0), "{more} {output:?}");
        assert_eq!(settings(), before, "{product} {output:?}");
    }
}

/// The page of the program: the address in its first line, the files of the page, and its end.
#[cfg(unix)]
#[test]
fn serve_prints_its_address_answers_and_ends_with_ctrl_c() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::io::{BufRead, BufReader, Read, Write};
    use std::process::Stdio;
    let mut child = sensor::command("demo:is2", "computer", "serve --demo --listen 127.0.0.1:0")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
    output.read_line(&mut line).expect("a line");
    let address = line.trim().strip_prefix("http://").expect("an address");
    let (address, secret) = address.split_once("/#").expect("a secret");
    assert_eq!(secret.len(), 32, "{line}");
    let mut page = TcpStream::connect(address).expect("a connection");
    let request = format!("GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    page.write_all(request.as_bytes()).expect("it is sent");
    let mut answer = String::new();
    page.read_to_string(&mut answer).expect("the page");
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
    assert!(answer.contains("<title>"), "{answer}");
    kill_process(Pid::from_child(&child), Signal::INT).expect("it runs");
    let ended = child.wait_with_output().expect("it ends");
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
}
