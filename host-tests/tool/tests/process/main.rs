//! The program as a process, with the server of the virtual sensor: slcan over TCP and on a pseudoterminal.

use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading};
use serde_json::Value;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::mpsc::channel;
use std::thread;
use virtual_sensor::server::{Clock, Server, tcp};

/// Starts a virtual sensor; it runs until the test program ends. Returns its address, and the path of its serial port if there is one.
fn sensor(product: &'static str, rate: BusRate) -> (String, Option<String>) {
    let (sender, address) = channel();
    thread::spawn(move || {
        let level = Reading {
            acceleration: I32x3 {
                x: 0,
                y: 0,
                z: ONE_G,
            },
            temperature: 25_00,
            ..Reading::default()
        };
        let node_type = NodeType::find(product).expect("a product");
        let mut bus = Bus::new(rate);
        let flash = Flash::blank(Geometry::STM32F103);
        let id = bus.attach(Device::new(&node_type, 1, flash, Box::new(level)));
        let (server, events) = Server::new(bus, id, Clock::Computer, None, None);
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let port = listener.local_addr().expect("an address").port();
        #[cfg(unix)]
        let serial = virtual_sensor::server::pty::serve(events.clone())
            .ok()
            .map(|path| path.to_string());
        #[cfg(not(unix))]
        let serial = None;
        tcp::serve(listener, events).expect("a thread");
        sender
            .send((format!("slcan://127.0.0.1:{port}"), serial))
            .expect("the test waits");
        // It ends with the test program.
        let _ = server.run();
    });
    address.recv().expect("the sensor starts")
}

fn plumbline(port: &str, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
    command
        .env("PLUMBLINE_PORT", port)
        .args(arguments.split(' '));
    command.output().expect("the program starts")
}

#[track_caller]
fn json(port: &str, arguments: &str) -> Value {
    let output = plumbline(port, &format!("--json {arguments}"));
    assert!(output.status.success(), "{arguments}: {output:?}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

#[test]
fn sensor_is_read_set_and_stored_over_tcp() {
    let (port, _) = sensor("is2", BusRate::Follow);
    assert_eq!(json(&port, "get cyclic-time")["cyclic-time"]["raw"], 250);
    assert!(
        plumbline(&port, "set filter=2.5Hz,butterworth --save")
            .status
            .success()
    );
    let read = json(&port, "get filter");
    assert_eq!(
        (&read["cut-off"]["raw"], &read["filter-type"]["value"]),
        (&Value::from(2500), &Value::from("Butterworth"))
    );
    let output = plumbline(&port, "set cyclic-time=0");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("1..65535 ms"),
        "{output:?}"
    );
}

#[test]
fn scan_finds_talking_sensors_at_their_rate() {
    for (product, rate) in [("jn2101", 125), ("tiltix360", 125)] {
        let (port, _) = sensor(product, BusRate::Fixed(BitRate::K125));
        let rows = json(&port, "scan");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["rate"]),
            (&Value::from(product), &Value::from(rate))
        );
    }
}

#[test]
fn silent_sensor_is_found_after_a_yes() {
    let (port, _) = sensor("is1", BusRate::Fixed(BitRate::K500));
    let output = plumbline(&port, "--rate 500 --json scan");
    assert_eq!(
        output.status.code(),
        Some(3),
        "standard input is no terminal: nothing is asked"
    );
    assert!(String::from_utf8_lossy(&output.stderr).contains("nothing was sent"));
    let rows = json(&port, "--rate 500 --yes scan");
    assert_eq!(rows[0]["product"], "is1");
}

#[test]
fn every_product_gives_its_parameters_to_a_backup() {
    for product in ["is1tk", "is2d", "jn2101", "ims360", "tiltix080"] {
        let (port, _) = sensor(product, BusRate::Follow);
        let path =
            PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("process-{product}.toml"));
        let _ = std::fs::remove_file(&path);
        let output = plumbline(&port, &format!("backup {}", path.display()));
        assert!(output.status.success(), "{product} {output:?}");
        assert_eq!(
            json(&port, &format!("diff {}", path.display())),
            serde_json::json!({}),
            "{product}"
        );
    }
}

#[cfg(unix)]
#[test]
fn serial_port_is_an_adapter() {
    let (_, serial) = sensor("is2", BusRate::Follow);
    let port = format!("slcan:{}", serial.expect("a pseudoterminal"));
    assert_eq!(json(&port, "get serial-number")["serial-number"]["raw"], 1);
    let watched = plumbline(&port, "watch --every 20 --seconds 0.5");
    assert!(
        watched.status.success() && watched.stdout.len() > 400,
        "{watched:?}"
    );
}

#[test]
fn demonstration_needs_no_hardware() {
    for product in ["is2", "jn2101", "ims360", "tiltix080"] {
        let read = json(&format!("demo:{product}"), "zero");
        assert!(read["zero"].is_object(), "{product}");
    }
    assert_eq!(plumbline("demo:is3", "get").status.code(), Some(2));
}

#[test]
fn missing_adapter_is_exit_code_4_with_a_next_step() {
    for (port, code) in [
        ("slcan://127.0.0.1:1", 4),
        ("slcan:/dev/nonexistent", 4),
        ("nonexistent0", 4),
        ("usb:", 2),
        ("", 2),
    ] {
        let output = plumbline(port, "get");
        assert_eq!(output.status.code(), Some(code), "{port} {output:?}");
        assert!(output.stderr.len() > 60, "{port} {output:?}");
    }
}

#[test]
fn completions_and_manual_page_are_printed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = plumbline("", &format!("completions {shell}"));
        assert!(
            output.status.success() && output.stdout.len() > 1000,
            "{shell}"
        );
    }
    let page = plumbline("", "man");
    assert!(
        String::from_utf8_lossy(&page.stdout).contains(".TH plumbline 1"),
        "{page:?}"
    );
    assert_eq!(plumbline("", "nonsense").status.code(), Some(2));
}

/// The command lines of the document.
fn documented() -> Vec<&'static str> {
    let document = include_str!("../../README.md");
    let lines = document
        .lines()
        .filter_map(|line| line.strip_prefix("plumbline "));
    lines.collect()
}

#[test]
fn document_shows_every_command() {
    use clap::CommandFactory;
    let commands = plumbline_tool::cli::Cli::command();
    for command in commands.get_subcommands() {
        let name = command.get_name();
        let is_shown = documented()
            .iter()
            .any(|line| line.split(' ').any(|word| word == name));
        assert!(is_shown, "{name}");
    }
}

#[test]
fn every_command_line_of_the_document_works() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("document");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    for line in documented() {
        // A search of all identifiers takes 41 s.
        if line.contains("--search") {
            continue;
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
        let mut words: Vec<&str> = line.split(' ').collect();
        let port = match () {
            () if words.contains(&"--node") => "demo:jn2101",
            () if words.contains(&"--mac") => "demo:tiltix080",
            () => "demo:is2",
        };
        command.env("PLUMBLINE_PORT", port).current_dir(&folder);
        if line == "watch" {
            words.extend(["--seconds", "1"]);
        }
        // Without a terminal a question is answered with no.
        if words.contains(&"scan") {
            words.extend(["--port", "demo:jn2101"]);
        }
        let output = command.args(words).output().expect("the program starts");
        assert!(output.status.success(), "{line}: {output:?}");
    }
}
