//! A virtual sensor for the program, and a run of the program.

use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use plumbline::measure::{I32x3, ONE_G, Reading};
use serde_json::Value;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};
use virtual_sensor::server::{Clock, Events, Server, tcp};

/// A virtual sensor in a thread, which ends with its test.
pub struct Sensor {
    /// The port for `--port`.
    pub port: String,
    /// The path of its serial port, if there is one.
    pub serial: Option<String>,
    clock: Clock,
    events: Events,
    thread: Option<JoinHandle<()>>,
}

impl Sensor {
    /// Starts a virtual sensor. With `Clock::Client` the load of the computer has no influence: the program advances the time.
    pub fn start(product: &'static str, rate: BusRate, clock: Clock) -> Self {
        let (sender, started) = channel();
        let thread = thread::spawn(move || {
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
            let (server, events) = Server::new(bus, id, clock, None, None);
            let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
            let port = listener.local_addr().expect("an address").port();
            #[cfg(unix)]
            let serial = virtual_sensor::server::pty::serve(events.clone())
                .ok()
                .map(|path| path.to_string());
            #[cfg(not(unix))]
            let serial = None;
            tcp::serve(listener, events.clone()).expect("a thread");
            let port = format!("slcan://127.0.0.1:{port}");
            sender.send((port, serial, events)).expect("the test waits");
            server.run().expect("the server runs");
        });
        let (port, serial, events) = started.recv().expect("the sensor starts");
        Self {
            port,
            serial,
            clock,
            events,
            thread: Some(thread),
        }
    }

    /// Runs the program on this port.
    pub fn run_at(&self, port: &str, arguments: &str) -> Output {
        let clock = match self.clock {
            Clock::Client => "bus",
            Clock::Computer => "computer",
        };
        program(port, clock, arguments)
    }

    pub fn run(&self, arguments: &str) -> Output {
        self.run_at(&self.port, arguments)
    }

    /// Runs the program, which must succeed.
    #[track_caller]
    pub fn done(&self, arguments: &str) {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {output:?}");
    }

    #[track_caller]
    pub fn json(&self, arguments: &str) -> Value {
        document(&self.run(&format!("--json {arguments}")))
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.events.stop();
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(thread::panicking() || !matches!(ended, Some(Err(_))));
    }
}

/// A new folder without names of sensors and without a last command: tests must not use the folder of the user.
pub fn no_config() -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let folder = folder.join(format!("process-config-{number}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// The program with this clock: `bus`, or the clock of the computer.
pub fn command(port: &str, clock: &str, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_plumbline"));
    command
        .env("PLUMBLINE_PORT", port)
        .env("PLUMBLINE_CLOCK", clock)
        .env("PLUMBLINE_CONFIG", no_config())
        .args(arguments.split(' '));
    command
}

/// Runs the program with this clock.
pub fn program(port: &str, clock: &str, arguments: &str) -> Output {
    let mut command = command(port, clock, arguments);
    command.output().expect("the program starts")
}

/// Runs the program with the time of the bus.
pub fn plumbline(port: &str, arguments: &str) -> Output {
    program(port, "bus", arguments)
}

/// The document of a run that must have succeeded.
#[track_caller]
pub fn document(output: &Output) -> Value {
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

/// A pseudoterminal: its other side, and its path.
#[cfg(unix)]
pub fn terminal() -> (std::os::fd::OwnedFd, std::ffi::CString) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&master).expect("it is ours");
    unlockpt(&master).expect("it is ours");
    let path = ptsname(&master, Vec::new()).expect("a name");
    (master, path)
}
