//! Faults of the accelerometer (`--fault`).

use crate::process::client::{BOOT_UP, Client, POLL, REPLY, advance};
use crate::process::sensor::Sensor;
use std::net::TcpStream;

/// The status byte with factory values, and with the sensor errors of both axes.
const GOOD: &str = "03";
const FAULTY: &str = "33";

const TILT: &str = "tilt=12.34,-5.67";

/// An is2 in this scene with these faults.
fn sensor(scene: &str, faults: &[&str]) -> Sensor {
    let faults: Vec<&str> = faults.iter().flat_map(|fault| ["--fault", fault]).collect();
    let common = ["--clock", "client", "--scene", scene];
    Sensor::start(&[&common[..], &crate::firmware("is2"), &faults].concat())
}

/// The first line with this beginning in the next second.
fn find(client: &mut Client<TcpStream>, request: &str, beginning: &str) -> String {
    client.expect(request, "z");
    for _ in 0..100 {
        let (lines, _) = advance(client, 10_000);
        if let Some(line) = lines.into_iter().find(|line| line.starts_with(beginning)) {
            return line;
        }
    }
    panic!("no line starts with {beginning}");
}

/// The status byte of the first boot-up message.
fn boots(client: &mut Client<TcpStream>) -> String {
    find(client, POLL, BOOT_UP)[7..9].to_owned()
}

/// Lets time pass; then the status byte and the angles of a poll.
fn poll(client: &mut Client<TcpStream>, ms: u64) -> (String, String) {
    for _ in 0..ms / 10 {
        advance(client, 10_000);
    }
    let reply = find(client, POLL, REPLY);
    (reply[7..9].to_owned(), reply[9..17].to_owned())
}

#[test]
fn accelerometer_without_values_from_power_up_on_is_fault_in_first_frame() {
    for fault in ["accelerometer=silent", "accelerometer=stopped@0"] {
        let sensor = sensor(TILT, &[fault]);
        let mut client = Client::open(&sensor);
        assert_eq!(boots(&mut client), FAULTY, "{fault}");
    }
}

#[test]
fn accelerometer_that_fails_later_is_good_before() {
    for fault in ["accelerometer=silent@1", "accelerometer=stopped@1"] {
        let sensor = sensor(TILT, &[fault]);
        let mut client = Client::open(&sensor);
        assert_eq!(boots(&mut client), GOOD, "{fault}");
        assert_eq!(poll(&mut client, 500).0, GOOD, "{fault}");
        assert_eq!(poll(&mut client, 700).0, FAULTY, "{fault}");
    }
}

#[test]
fn frozen_accelerometer_is_a_fault_and_zero_measures_0_g() {
    let frozen = sensor(TILT, &["accelerometer=frozen@1"]);
    let mut client = Client::open(&frozen);
    boots(&mut client);
    let before = poll(&mut client, 900);
    assert_eq!(before.0, GOOD);
    assert_eq!(poll(&mut client, 800), (FAULTY.to_owned(), before.1));
    let zero = sensor(TILT, &["accelerometer=zero@1"]);
    let mut client = Client::open(&zero);
    boots(&mut client);
    assert_eq!(poll(&mut client, 500).0, GOOD);
    assert_eq!(poll(&mut client, 2000).0, FAULTY);
}

#[test]
fn axis_without_signal_and_clipping_axis_are_faults() {
    // At these angles the other axes measure less than 0.6 g.
    for (fault, tilt) in [
        ("axis-y", "tilt=10,75"),
        ("axis-z", "tilt=3,4"),
        ("clipping", "tilt=3,4"),
    ] {
        let sensor = sensor(tilt, &[&format!("accelerometer={fault}@1")]);
        let mut client = Client::open(&sensor);
        assert_eq!(boots(&mut client), GOOD, "{fault}");
        assert_eq!(poll(&mut client, 500).0, GOOD, "{fault}");
        assert_ne!(poll(&mut client, 2500).0, GOOD, "{fault}");
    }
}
