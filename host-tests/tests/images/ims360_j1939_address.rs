//! The image of the IMS360 in J1939 while its address changes: the frames in its mailboxes, and its acceptance filters.

use crate::ims360_j1939::{CLAIM, HIGHER, LOWER, NAME, at, claimed};
use crate::rig::*;
use bench::Source;
use plumbline::can::BitRate;

/// Another node claims the same address in the same bit: the identifiers are equal, the data differs.
#[test]
fn image_does_not_repeat_a_claim_that_collides() {
    for name in ["FFFFFFFFFFFFFFFF", "0000000000000090"] {
        let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
        rig.bus.give_way(false);
        rig.change_to_j1939();
        let sensor = Source::Device(rig.sensor);
        let before = rig.bus.disturbed(sensor);
        // The claim of the sensor waits for the bus until the tester sends its own.
        for _ in 0..30 {
            rig.send_text("00FF0021#0102030405060708");
        }
        let other = format!("18EEFF80#{name}");
        rig.send_text(&other);
        rig.run(230);
        let texts = rig.log.iter().map(|one| format!("{:?}", one.frame));
        let claims: Vec<_> = texts.filter(|text| text.starts_with("18EEFF")).collect();
        assert_eq!(claims, [other, CLAIM.to_string()]);
        assert_eq!(rig.bus.disturbed(sensor) - before, 1);
    }
}

/// At 1 Mbit/s the claim begins before the receive interrupt has aborted it, and loses the arbitration against the frame that follows. The
/// image repeats a claim that has lost the arbitration, but not an aborted one.
#[test]
fn image_does_not_repeat_a_claim_that_was_aborted_on_the_bus() {
    let mut rig = at(BitRate::M1);
    rig.power_cycle();
    while !rig.wait_text(1).contains(&CLAIM.to_string()) {}
    rig.bus.give_way(false);
    for address in 0x80_u8..0xC0 {
        rig.run_us(5_000 + 137 * u64::from(address));
        rig.sent();
        // The first claim of the tester makes the sensor send its claim again, the second one takes the address.
        for name in [HIGHER, LOWER] {
            rig.send_text(&format!("18EEFF{address:02X}#{name}"));
        }
        rig.send_text("001#");
        let next = format!("18EEFF{:02X}#{NAME}", address + 1);
        assert_eq!(rig.wait_text(10), [next], "loss of {address:02X}h");
    }
}

#[test]
fn image_sends_nothing_from_an_address_after_its_loss() {
    // The claim wins against the answer, which is in a mailbox. The controller would send it 4 bit times after the receive interrupt: 32 us.
    let mut rig = at(BitRate::K125);
    for address in 0x80_u8..0xA8 {
        rig.run_us(300_000 + 137 * u64::from(address));
        rig.sent();
        let begin = rig.log.len();
        let lost = format!("18EEFF{address:02X}#{LOWER}");
        rig.send_text(&format!("18EF{address:02X}21#2B113100401F0000"));
        rig.send_text(&lost);
        rig.run(20);
        let texts = rig.log[begin..]
            .iter()
            .map(|one| format!("{:?}", one.frame));
        let after: Vec<String> = texts.skip_while(|text| *text != lost).skip(1).collect();
        let next = format!("18EEFF{:02X}#{NAME}", address + 1);
        assert_eq!(after, [next], "loss of {address:02X}h");
    }
}

#[test]
fn image_receives_without_a_gap_while_the_filters_follow_the_address() {
    let mut rig = claimed();
    let before = rig.microcontroller().can().reception_stops();
    for address in 0x80..0x84 {
        rig.send_text(&format!("18EEFF{address:02X}#{LOWER}"));
    }
    rig.run(600);
    assert_eq!(rig.parameter(0x84, "4000100000000000"), "430010009A010407");
    assert_eq!(rig.microcontroller().can().reception_stops(), before);
}
