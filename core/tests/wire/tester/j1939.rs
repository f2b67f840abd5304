//! Helpers for tests of the IMS360 in J1939.

use super::ims360::{Ims360Tester, booted};

/// The data of the claim: the NAME of a sensor with factory values.
pub const NAME: &str = "0102E3FF00910080";
/// A NAME that is lower than ours.
pub const LOWER: &str = "0000000000000000";
/// The claim of the preferred address.
pub const CLAIM: &str = "18EEFF80#0102E3FF00910080";
/// A DM1 message without active codes.
pub const NO_CODES: &str = "18FECA80#00FF00000000FFFF";

/// Writes of objects over CANopen that select J1939 and store it.
pub fn select(tester: &mut Ims360Tester) {
    assert_eq!(tester.write(0x3100, 1, 1, 1), Ok(()));
    assert_eq!(tester.write(0x1010, 1, 4, 0x6576_6173), Ok(()));
}

/// A sensor with these objects (index, sub-index, size, value) after power-up in J1939.
pub fn with(objects: &[(u16, u8, u8, u32)]) -> Ims360Tester {
    let mut tester = booted();
    for &(index, sub, size, value) in objects {
        assert_eq!(
            tester.write(index, sub, size, value),
            Ok(()),
            "{index:04X}h"
        );
    }
    select(&mut tester);
    tester.power_cycle();
    tester
}

/// A sensor that has claimed its address. It sends no process data.
pub fn claimed_with(objects: &[(u16, u8, u8, u32)]) -> Ims360Tester {
    let mut objects = objects.to_vec();
    objects.push((0x2104, 1, 2, 0));
    let mut tester = with(&objects);
    tester.wait(250);
    tester
}

/// As [`claimed_with`], with the other factory values.
pub fn claimed() -> Ims360Tester {
    claimed_with(&[])
}

impl Ims360Tester {
    /// Sends an SDO request from 21h to 80h and returns the data of its single reply.
    pub fn parameter(&mut self, request: &str) -> String {
        let sent = self.exchange(&format!("18EF8021#{request}"));
        let [reply] = &sent[..] else {
            panic!("{request} -> {sent:?}");
        };
        let data = reply.strip_prefix("18EF2180#");
        data.unwrap_or_else(|| panic!("{request} -> {reply}"))
            .to_string()
    }

    /// Requests a group from 21h: `EBFE00`, of 80h or of all.
    pub fn request_group(&mut self, destination: &str, pgn: &str) -> Vec<String> {
        self.exchange(&format!("18EA{destination}21#{pgn}"))
    }

    /// Sends Commanded Address to all nodes, with this NAME and the address A0h. Returns the frames that follow.
    pub fn command_address(&mut self, name: &str) -> Vec<String> {
        let mut sent = self.exchange("1CECFF21#20090002FFD8FE00");
        // An engine sends its trouble codes at the same time.
        sent.extend(self.exchange("1CECFF00#200A0002FFCAFE00"));
        sent.extend(self.exchange(&format!("1CEBFF21#01{}", &name[..14])));
        sent.extend(self.exchange("1CEBFF00#0104FF7013000171"));
        sent.extend(self.exchange(&format!("1CEBFF21#02{}A0FFFFFFFFFF", &name[14..])));
        sent
    }
}
