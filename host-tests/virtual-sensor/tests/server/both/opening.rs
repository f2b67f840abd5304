//! A sensor that repeats a frame without acknowledge: without a client, with clients that send in the moment in which they open,
//! and with clients that leave in the moment in which they have sent.

use crate::process::client::{Client, advance};
use crate::process::sensor::Sensor;
use std::io::Write;
use std::thread;
use std::time::Duration;

/// 125 kbit/s, open, SDO read of object 1000h of node 10.
const OPEN_AND_READ: &[u8] = b"S4\rO\rt60A84000100000000000\r";

/// The reply: the device type of section 14 of the manual of the JN2101.
const DEVICE_TYPE: &str = "t58A8430010009A010400";

/// SDO read of the error register, and the reply without an error.
const READ_ERRORS: &str = "t60A84001100000000000";
const NO_ERROR: &str = "t58A84F01100000000000";

/// The attempts of a test, each in another phase of the frame that the sensor repeats.
const ATTEMPTS: u64 = 12;

/// Starts a JN2101, which repeats its boot-up message until a client acknowledges it.
fn jn2101(more: &[&str]) -> Sensor {
    let model = ["--model", "jn2101"];
    Sensor::start(&[&model[..], more, &crate::firmware("jn2101")].concat())
}

/// A time in us at which it repeats its boot-up message, in another phase of the frame for each attempt.
fn phase(attempt: u64) -> u64 {
    100_000 + 1_313 * attempt
}

/// A new client that sends these bytes in one piece.
fn client(sensor: &Sensor, bytes: &[u8]) -> Client<std::net::TcpStream> {
    let mut client = Client::connect(sensor);
    client.stream.write_all(bytes).expect("it listens");
    client
}

#[test]
fn request_sent_while_client_opens_is_answered() {
    for attempt in 0..ATTEMPTS {
        let sensor = jn2101(&[]);
        thread::sleep(Duration::from_micros(phase(attempt)));
        let mut client = client(&sensor, OPEN_AND_READ);
        client.find("t70A100");
        client.find(DEVICE_TYPE);
        // The sensor was error passive. It is no longer, so it resets the error.
        client.say(READ_ERRORS);
        assert_eq!(client.find("t58A84F0110"), NO_ERROR, "attempt {attempt}");
    }
}

#[test]
fn client_that_leaves_after_its_request_leaves_no_reply_and_no_error() {
    for attempt in 0..ATTEMPTS {
        let sensor = jn2101(&["--clock", "client"]);
        let mut clock = Client::connect(&sensor);
        advance(&mut clock, phase(attempt));
        // The time stands still until it has left.
        client(&sensor, OPEN_AND_READ).leave();
        advance(&mut clock, 200_000);
        let mut next = client(&sensor, b"S4\rO\r");
        for answer in ["", ""] {
            assert_eq!(next.next().as_deref(), Some(answer));
        }
        next.expect(READ_ERRORS, "z");
        let (lines, _) = advance(&mut next, 200_000);
        // A reply or a repeated frame for the client that has left would come first. Before each frame comes its time.
        let frame = lines.get(1).map(String::as_str);
        assert_eq!(frame, Some(NO_ERROR), "attempt {attempt}: {lines:?}");
    }
}
