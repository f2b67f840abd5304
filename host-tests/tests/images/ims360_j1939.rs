//! The image of the IMS360 in J1939: the change of the protocol, address claim, process data, acceptance filters and LEDs.

use crate::rig::*;
use bench::{BusRate, Flash, Logged};
use can_wire::frame_length::{INTERMISSION, frame_bits};
use can_wire::text::frame;
use plumbline::can::BitRate;

/// The claim of the preferred address, and the NAME of the sensor: serial number 1.
pub(crate) const CLAIM: &str = "18EEFF80#0100E0FF00910080";
pub(crate) const NAME: &str = "0100E0FF00910080";
/// A NAME that wins against it, and one that loses.
pub(crate) const LOWER: &str = "0000000000000000";
pub(crate) const HIGHER: &str = "FFFFFFFFFFFFFFFF";
/// A DM1 message without active codes.
pub(crate) const NO_CODES: &str = "18FECA80#00FF00000000FFFF";

impl Rig {
    pub(crate) fn send_text(&mut self, text: &str) {
        self.bus.send(self.tester, frame(text));
    }

    /// The frames of the sensor within this many milliseconds.
    pub(crate) fn wait_text(&mut self, ms: u64) -> Vec<String> {
        self.run(ms);
        self.frames().iter().map(|one| format!("{one:?}")).collect()
    }

    /// Sends a request with the bytes of an SDO from 21h to `address`. Returns the data of the reply.
    #[track_caller]
    pub(crate) fn parameter(&mut self, address: u8, request: &str) -> String {
        let reply = format!("18EF21{address:02X}#");
        self.frames();
        self.send_text(&format!("18EF{address:02X}21#{request}"));
        for _ in 0..1000 {
            let sent = self.wait_text(1);
            if let Some(data) = sent.iter().find_map(|text| text.strip_prefix(&reply)) {
                return data.to_string();
            }
        }
        panic!("no reply to {request}")
    }

    /// Stores J1939 as protocol and restarts the sensor. It sends its claim next.
    pub(crate) fn change_to_j1939(&mut self) {
        self.download(0x3100, 1, [1]);
        self.download_within(1_000, 0x1010, 1, *b"save");
        self.frames();
        self.send_text("000#8132");
    }

    /// The times of the frames of the sensor that are not read yet, with the text of each.
    pub(crate) fn sent_text(&mut self) -> Vec<(u64, String)> {
        let text = |one: &Logged| (one.start / 1_000_000, format!("{:?}", one.frame));
        self.sent().iter().map(text).collect()
    }
}

/// A level sensor that has claimed its address. Its process data is off.
pub(crate) fn claimed() -> Rig {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x2104, 1, [0, 0]);
    rig.change_to_j1939();
    let sent = rig.wait_text(400);
    assert_eq!(sent, [CLAIM, NO_CODES]);
    rig
}

#[test]
fn image_takes_the_next_address_for_each_of_many_claims_without_a_gap() {
    let mut rig = claimed();
    for address in 0x80..0x84 {
        rig.send_text(&format!("18EEFF{address:02X}#{LOWER}"));
    }
    rig.run(600);
    let sent = rig.sent_text();
    let last = format!("18EEFF84#{NAME}");
    let claim = sent.iter().position(|(_, text)| *text == last);
    let claim = claim.unwrap_or_else(|| panic!("{sent:?}"));
    // Claims of the addresses above 80h, each at most once and in their order: the others were lost before the claim was sent.
    let claims: Vec<&str> = sent[..=claim].iter().map(|(_, text)| &**text).collect();
    let possible: Vec<String> = (0x81..=0x84_u8)
        .map(|address| format!("18EEFF{address:02X}#{NAME}"))
        .collect();
    assert!(
        claims
            .iter()
            .all(|text| possible.iter().any(|one| one == text)),
        "{sent:?}"
    );
    assert!(
        claims.is_sorted_by(|earlier, later| earlier < later),
        "{sent:?}"
    );
    let (at, text) = &sent[claim + 1];
    // Claims of one address that collide can make the controller error passive.
    let codes = ["00FF00000000FFFF", "04FF7F020201FFFF"];
    let codes = codes.map(|codes| format!("18FECA84#{codes}"));
    assert!(codes.contains(text), "{text}");
    let silence = at - sent[claim].0;
    assert!((250_000..260_000).contains(&silence), "{silence} us");
    // The filters follow the address.
    assert_eq!(rig.parameter(0x84, "4000100000000000"), "430010009A010407");
    rig.send_text("18EF8021#4000100000000000");
    rig.send_text("18EA8021#00EE00");
    assert_eq!(rig.wait_text(50), [""; 0]);
    // The address is kept against a higher NAME.
    rig.send_text(&format!("18EEFF84#{HIGHER}"));
    assert_eq!(rig.wait_text(20), [last.as_str()]);
    // Each start begins with the preferred address.
    rig.power_cycle();
    assert_eq!(rig.wait_text(400), [CLAIM, NO_CODES]);
}

/// The image at this bit rate with process data every 10 ms.
pub(crate) fn at(rate: BitRate) -> Rig {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x2001, 0, rate.bits_per_second().to_le_bytes());
    rig.download(0x3100, 1, [1]);
    rig.download_within(1_000, 0x1010, 1, *b"save");
    let bytes = rig.flash().bytes().to_vec();
    let memory = Flash::with_content(chip().facts().geometry, bytes);
    drop(rig);
    let mut rig = Rig::with("ims360", BusRate::Fixed(rate), memory);
    rig.set_motion(tilt("ims360", 0.0, 0.0));
    let sent = rig.wait_text(400);
    assert_eq!(sent[..2], [CLAIM, NO_CODES]);
    rig
}

/// What other nodes of a vehicle send: process data, requests and parameters of each other, acknowledgements, other protocols.
const PASSING: [&str; 14] = [
    "0CF00400#F07D84A0140000FF",
    "18FEF100#F7000000CCFF00FF",
    "0C000003#FFFFFFFFFFFFFFFF",
    "18FEEE00#7AFFFFFFFFFFFFFF",
    "18EA0021#EBFE00",
    "18EA8121#CAFE00",
    "18EF2122#0102030405060708",
    "18EF8122#4000100000000000",
    "18E8FF00#01FFFFFF21EEFE00",
    "1CEC2100#10140003FFEBFE00",
    "1CEB2100#01506C756D626C69",
    "0CF0292A#00007D00007D33FF",
    "1AEF8021#4000100000000000",
    "632#4000100000000000",
];

/// The trouble codes of an engine to all nodes: they use the same groups as Commanded Address.
const TO_ALL: [&str; 3] = [
    "1CECFF00#200A0002FFCAFE00",
    "1CEBFF00#0104FF7013000171",
    "1CEBFF00#02130201FFFFFFFF",
];

#[test]
fn frames_for_others_on_a_busy_bus_do_not_reach_the_program() {
    const TIME: u64 = 2000;
    let mut rig = at(BitRate::K250);
    let weak = rig.bus.adapter();
    rig.bus.open(weak, Some(BitRate::K250), false);
    rig.run(1);
    rig.frames();
    let stored = rig.microcontroller().can().stored();
    let begin = rig.log.len();
    let mut passing = PASSING.iter().cycle();
    let mut needed = 0;
    for at in 0..TIME {
        // A fifth of the time is for frames that the sensor needs: theirs are the lowest priorities.
        while at % 100 < 80 && rig.bus.queued(weak) < 2 {
            rig.bus
                .send(weak, frame(passing.next().expect("without end")));
        }
        if at % 100 == 80 {
            for text in TO_ALL {
                rig.send_text(text);
            }
            rig.send_text("18EA8021#EEFE00");
            needed += 4;
        }
        rig.run(1);
    }
    rig.bus.close(weak);
    rig.run(10);
    let bits = |one: &Logged| u64::from(frame_bits(&one.frame) + INTERMISSION);
    let load: u64 = rig.log[begin..].iter().map(bits).sum();
    let frames = rig.log.len() - begin;
    let reached = rig.microcontroller().can().stored() - stored;
    println!(
        "{frames} frames, {load} of {} bits, {reached} reached the program",
        TIME * 250
    );
    assert!(load * 100 >= TIME * 250 * 70, "{load}");
    assert!(frames > 2500, "{frames}");
    assert_eq!(reached, needed);
    assert_eq!(rig.microcontroller().can().overruns(), 0);
    let sent: Vec<String> = rig.frames().iter().map(|one| format!("{one:?}")).collect();
    let count = |start: &str| sent.iter().filter(|text| text.starts_with(start)).count();
    let slopes = count("0CF02980#");
    assert!((198..=202).contains(&slopes), "{slopes}");
    assert_eq!(count("18E8FF80#01FFFFFF21EEFE00"), 20);
}

#[test]
fn filters_without_an_address_admit_claims_requests_and_commands() {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x2106, 1, [0]);
    rig.change_to_j1939();
    rig.run(400);
    rig.send_text(&format!("18EEFF80#{LOWER}"));
    rig.run(200);
    rig.frames();
    let stored = rig.microcontroller().can().stored();
    for text in PASSING {
        rig.send_text(text);
    }
    rig.send_text("18EF8021#4000100000000000");
    rig.send_text("18EA8021#00EE00");
    assert_eq!(rig.wait_text(200), [""; 0]);
    assert_eq!(rig.microcontroller().can().stored() - stored, 0);
    rig.send_text("18EAFE21#00EE00");
    assert_eq!(rig.wait_text(200), ["18EEFFFE#0100E0FF00910000"]);
    rig.send_text("1CECFF21#20090002FFD8FE00");
    rig.send_text("1CEBFF21#010100E0FF009100");
    rig.send_text("1CEBFF21#0200A0FFFFFFFFFF");
    rig.run(400);
    let sent = rig.sent_text();
    assert_eq!(sent[0].1, "18EEFFA0#0100E0FF00910000");
    assert_eq!(rig.parameter(0xA0, "4002210000000000"), "4F022100A0000000");
}
