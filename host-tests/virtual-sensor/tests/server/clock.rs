//! Clients that advance the time (`--clock client`).

use crate::process::client::{BEL, BOOT_UP, Client, POLL, QUIET, REPLY, advance};
use crate::process::sensor::Sensor;
use std::net::TcpStream;

/// The start of a cyclic frame of the is2.
const CYCLIC: &str = "t301800";

/// Sends a line and advances the time until the first frame with this beginning; returns the time of that frame and of the clock.
fn advance_to(client: &mut Client<TcpStream>, line: &str, beginning: &str) -> (u64, u64) {
    client.expect(line, "z");
    for _ in 0..20 {
        let (lines, now) = advance(client, 1_000_000);
        let frame = lines.iter().position(|line| line.starts_with(beginning));
        if let Some(at) = frame.and_then(|frame| lines[frame - 1].strip_prefix('#')) {
            return (u64::from_str_radix(at, 16).expect("a time"), now);
        }
    }
    panic!("no line starts with {beginning}");
}

/// An is2 at 250 kbit/s that has sent its boot-up messages, and its client.
fn awake() -> (Sensor, Client<TcpStream>) {
    let sensor = Sensor::start(&["--clock", "client"]);
    let mut client = Client::open(&sensor);
    client.say(POLL);
    let mut heard = 0;
    while heard < 2 {
        let (lines, _) = advance(&mut client, 1_000_000);
        heard += lines
            .iter()
            .filter(|line| line.starts_with(BOOT_UP))
            .count();
    }
    (sensor, client)
}

#[test]
fn slcan_dialog_of_readme_is_that_of_the_program() {
    let readme = include_str!("../../README.md");
    let begin = "$ virtual-sensor --clock client ";
    let mut lines = readme.lines().skip_while(|line| !line.starts_with(begin));
    let command = lines.next().and_then(|line| line.strip_prefix(begin));
    let own = shlex::split(command.expect("a command line")).expect("words");
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    let sensor = Sensor::start(&[&["--clock", "client"], &own[..]].concat());
    let mut client = Client::connect(&sensor);
    let mut answers = 0;
    for line in lines.take_while(|line| !line.starts_with("```")) {
        if let Some(request) = line.strip_prefix("-> ") {
            client.say(request);
        } else if let Some(answer) = line.strip_prefix("<-") {
            assert_eq!(client.next().as_deref(), Some(answer.trim()), "{line}");
            answers += 1;
        }
    }
    assert!(answers > 10);
}

#[test]
fn time_stands_still_without_a_client_that_advances_it() {
    let (_sensor, mut client) = awake();
    let (_, before) = advance(&mut client, 0);
    client.expect(POLL, "z");
    client.impatient();
    assert_eq!(client.next_within(QUIET), None);
    assert_eq!(advance(&mut client, 0), (vec![], before));
}

#[test]
fn time_advances_by_the_span_without_a_frame() {
    let (_sensor, mut client) = awake();
    let (_, before) = advance(&mut client, 0);
    for span in [1, 999, 1_000_000, 60_000_000] {
        let (_, start) = advance(&mut client, 0);
        assert_eq!(advance(&mut client, span), (vec![], start + span));
    }
    assert_eq!(advance(&mut client, 0).1, before + 61_001_000);
}

#[test]
fn time_stops_at_a_frame_of_the_client() {
    let (_sensor, mut client) = awake();
    let (_, before) = advance(&mut client, 0);
    let (at, now) = advance_to(&mut client, POLL, REPLY);
    // Request and reply have together 130 to 200 bits of 4 us.
    assert!(
        (before + 520..before + 800).contains(&at),
        "{before} to {at}"
    );
    assert!((at..at + 200).contains(&now), "{at} to {now}");
}

#[test]
fn cyclic_frames_have_the_time_of_the_bus() {
    let (_sensor, mut client) = awake();
    // Cyclic time 20 ms, then cyclic mode on.
    advance_to(&mut client, "t3003251400", "t301225");
    let (first, _) = advance_to(&mut client, "t30022601", CYCLIC);
    let mut last = first;
    for _ in 0..50 {
        let (lines, _) = advance(&mut client, 1_000_000);
        let at = lines[0].strip_prefix('#').expect("a time");
        let at = u64::from_str_radix(at, 16).expect("a time");
        // The number of stuff bits differs.
        assert!((19_900..20_100).contains(&(at - last)), "{last} to {at}");
        last = at;
    }
}

#[test]
fn frames_are_on_the_bus_when_another_client_advances_the_time() {
    let (sensor, mut client) = awake();
    let mut clock = Client::connect(&sensor);
    client.expect(POLL, "z");
    advance(&mut client, 0);
    let (lines, _) = advance(&mut clock, 100_000);
    assert!(lines.is_empty(), "its channel is closed");
    let (lines, _) = advance(&mut client, 0);
    assert!(
        lines[0].starts_with('#') && lines[1].starts_with(REPLY),
        "{lines:?}"
    );
}

#[test]
fn invalid_span_is_refused() {
    let (_sensor, mut client) = awake();
    for line in ["@", "@G", "@-1", "@100000000", "@ 1"] {
        client.expect(line, BEL);
    }
    let sensor = Sensor::start(&[]);
    Client::open(&sensor).expect("@1", BEL);
}
