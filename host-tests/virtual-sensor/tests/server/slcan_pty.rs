//! Clients that use slcan over the pseudoterminal (`--pty`).
#![cfg(unix)]

use crate::process::client::{BEL, BOOT_UP, Client, POLL, REPLY};
use crate::process::sensor::Sensor;
use rustix::fs::{Mode, OFlags};
use rustix::termios::{LocalModes, OutputModes, tcgetattr};
use std::fs::File;
use std::io::Write;
use std::time::{Duration, Instant};

fn open(path: &str) -> Client<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC | OFlags::NONBLOCK;
    let terminal = rustix::fs::open(path, flags, Mode::empty()).expect("it is there");
    Client::on(File::from(terminal))
}

/// Time limit for the server to notice that the terminal is closed.
const LIMIT: Duration = Duration::from_secs(60);

/// Opens the terminal when the server has noticed that the previous client, which had an open channel, has closed it. Nothing tells
/// when the server has noticed it, and it cannot notice it while the terminal is open again.
#[track_caller]
fn reopen(path: &str) -> Client<File> {
    let mut pause = Duration::from_millis(10);
    let end = Instant::now() + LIMIT;
    loop {
        std::thread::sleep(pause);
        let mut client = open(path);
        // Ends the incomplete line of the previous client. A closed channel refuses the frame.
        client
            .stream
            .write_all(b"\rt1230\rN\r")
            .expect("a terminal");
        let mut lines = Vec::new();
        while !lines
            .last()
            .is_some_and(|line: &String| line.starts_with('N'))
        {
            lines.push(client.next().expect("an answer"));
        }
        // Lines for the previous client: this one was faster than the server, which discards them.
        if lines == ["", BEL, "N0001"] {
            return client;
        }
        assert!(Instant::now() < end, "the channel is still open: {lines:?}");
        pause *= 2;
    }
}

fn sensor_with_terminal(arguments: &[&str]) -> (Sensor, String) {
    let mut sensor = Sensor::start(&[arguments, &["--pty"]].concat());
    let line = sensor.line();
    let path = line
        .strip_prefix("slcan ")
        .expect("slcan /dev/...")
        .to_owned();
    (sensor, path)
}

#[test]
fn terminal_is_raw_and_speaks_slcan() {
    let (sensor, path) = sensor_with_terminal(&[]);
    let mut witness = Client::awake(&sensor);
    let mut client = open(&path);
    let settings = tcgetattr(&client.stream).expect("a terminal");
    assert!(
        !settings
            .local_modes
            .intersects(LocalModes::ECHO | LocalModes::ICANON | LocalModes::ISIG)
    );
    assert!(!settings.output_modes.contains(OutputModes::OPOST));
    client.expect("C", "");
    client.expect("V", "V1010");
    client.expect("t1230", BEL);
    client.expect("O", "");
    client.expect("\x03", BEL);
    client.expect("\n", BEL);
    client.poll();
    assert_eq!(witness.next().as_deref(), Some(POLL));
    witness.find(REPLY);
    witness.expect("t1230", "z");
    assert_eq!(client.next().as_deref(), Some("t1230"));
}

#[test]
fn terminal_can_be_reopened() {
    let (sensor, path) = sensor_with_terminal(&[]);
    let mut witness = Client::awake(&sensor);
    for _ in 0..5 {
        let mut client = reopen(&path);
        client.expect("O", "");
        client.poll();
        // Not read, within a line and without C.
        client.say("V");
        client.stream.write_all(b"t12").expect("a terminal");
        drop(client);
        // No client is there to receive these frames.
        let lines = witness.settle();
        assert!(
            !lines.iter().any(|line| line.starts_with(BOOT_UP)),
            "{lines:?}"
        );
    }
}

#[test]
fn frames_of_closed_terminal_are_sent() {
    let (sensor, path) = sensor_with_terminal(&[]);
    let mut witness = Client::awake(&sensor);
    open(&path)
        .stream
        .write_all(b"O\rt7E6155\r")
        .expect("a terminal");
    assert_eq!(witness.next().as_deref(), Some("t7E6155"));
}

#[test]
fn terminal_client_that_never_reads_does_not_block_others() {
    let (sensor, path) = sensor_with_terminal(&[]);
    let mut reader = Client::awake(&sensor);
    let mut idle = open(&path);
    idle.say("O");
    // More than the buffers of a terminal hold.
    let frames = 10_000;
    let mut sender = Client::open(&sensor);
    for _ in 0..frames / 100 {
        sender
            .stream
            .write_all("t12381122334455667788\r".repeat(100).as_bytes())
            .expect("it listens");
    }
    reader.poll();
    drop(idle);
    reopen(&path).expect("V", "V1010");
    drop(sender);
    reader.poll();
}
