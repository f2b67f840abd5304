//! Helpers for tests of the TILTIX with the MAC ID 3 of the manual's examples and the master 0Ah.

use super::Tester;
use plumbline::model::tiltix::tiltix080::Tiltix080;
use plumbline::model::tiltix::tiltix360::Tiltix360;
use plumbline::node::{Boot, Node};

/// The factory values of all attributes that do not depend on the angle.
pub const FACTORY: [(u8, &str); 17] = [
    (0x71, "0A00"),
    (0x73, "00"),
    (0x74, "0000"),
    (0x75, "00"),
    (0x76, "0000"),
    (0x77, "0000"),
    (0x7B, "00"),
    (0x7C, "0000"),
    (0x7D, "00"),
    (0x7E, "0000"),
    (0x7F, "0000"),
    (0x81, "67"),
    (0x82, "67"),
    (0x84, "64"),
    (0x85, "0000"),
    (0x87, "00"),
    (0x88, "00"),
];

/// The stored MAC ID 3; all other parameters have their factory values.
fn mac_3() -> Boot<'static> {
    Boot {
        parameters: Some(&[3]),
        ..Boot::default()
    }
}

/// A TILTIX 080, level, with explicit, poll and COS connections as far as `choice` has them.
pub fn tiltix080(choice: u8) -> Tester<Tiltix080> {
    allocated(Tester::power_up(mac_3(), Tiltix080::new), choice)
}

/// A TILTIX 360 at 0 deg with these connections.
pub fn tiltix360(choice: u8) -> Tester<Tiltix360> {
    allocated(Tester::power_up(mac_3(), Tiltix360::new), choice)
}

fn allocated<N: Node>(mut tester: Tester<N>, choice: u8) -> Tester<N> {
    assert_eq!(tester.wait_text(2001).len(), 2);
    let request = format!("41E#0A4B0301{choice:02X}0A");
    assert_eq!(tester.exchange(&request), ["41B#0ACB00"]);
    // The connection never times out.
    assert_eq!(tester.request("1005010900 00"), "900000");
    tester
}

impl<N: Node> Tester<N> {
    /// Sends the body of a request on the explicit connection, without regard to spaces. Returns the body of the response.
    pub fn request(&mut self, body: &str) -> String {
        let body = body.replace(' ', "");
        let sent = self.exchange(&format!("41C#0A{body}"));
        assert_eq!(sent.len(), 1, "{body} -> {sent:?}");
        let response = sent[0].strip_prefix("41B#0A");
        response
            .unwrap_or_else(|| panic!("{body} -> {sent:?}"))
            .to_string()
    }

    /// Reads an attribute of the angle object, low byte first; the error is the general code.
    pub fn get(&mut self, attribute: u8) -> Result<String, u8> {
        let response = self.request(&format!("0E6501{attribute:02X}"));
        match response.strip_prefix("8E") {
            Some(value) => Ok(value.to_owned()),
            None => Err(general_code(&response)),
        }
    }

    /// Sets an attribute of the angle object to these bytes; the error is the general code.
    pub fn set(&mut self, attribute: u8, value: &str) -> Result<(), u8> {
        let response = self.request(&format!("106501{attribute:02X}{value}"));
        match response.as_str() {
            "90" => Ok(()),
            _ => Err(general_code(&response)),
        }
    }

    /// The specific force of a 1-axis sensor at this angle in deg, until the filters have settled.
    pub fn turn(&mut self, angle: f64) {
        let (x, y) = angle.to_radians().sin_cos();
        self.settle_at([x, y, 0.0]);
    }
}

fn general_code(response: &str) -> u8 {
    let code = response.strip_prefix("94").expect("an error response");
    assert_eq!(&code[2..], "FF", "no additional code");
    u8::from_str_radix(&code[..2], 16).expect("a byte")
}
