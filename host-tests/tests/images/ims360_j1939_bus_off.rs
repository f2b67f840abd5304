//! The image of the IMS360 in J1939: bus-off, with and without recovery.

use crate::ims360_j1939::{CLAIM, NO_CODES};
use crate::rig::*;
use bench::{Logged, Source};
use plumbline::node::BusState;

fn is_off(rig: &Rig) -> bool {
    rig.device().bus_state() == Some(BusState::BusOff)
}

#[test]
fn image_claims_again_after_bus_off() {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x3100, 2, [1]);
    rig.change_to_j1939();
    rig.run(500);
    rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
    rig.wait_until(100, 200, is_off);
    rig.frames();
    rig.run(600);
    let sent = rig.sent_text();
    assert_eq!(sent[0].1, CLAIM);
    assert_eq!(sent[1].1, NO_CODES);
    let silence = sent[1].0 - sent[0].0;
    assert!((250_000..260_000).contains(&silence), "{silence} us");
    assert!(sent[2].1.starts_with("0CF02980#"));
}

#[test]
fn image_without_recovery_stays_in_bus_off_also_while_claiming() {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x3100, 2, [0]);
    rig.change_to_j1939();
    rig.wait_until(100, 200, |rig| {
        let is_claim = |one: &&Logged| format!("{:?}", one.frame) == CLAIM;
        rig.log.iter().filter(is_claim).count() == 1
    });
    // A request makes the sensor send in its silence.
    rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
    rig.send_text("18EAFF21#00EE00");
    rig.wait_until(100, 200, is_off);
    rig.frames();
    assert_eq!(rig.wait_text(2000), [""; 0]);
    assert!(is_off(&rig));
    rig.power_cycle();
    assert_eq!(rig.wait_text(200), [CLAIM]);
}

#[test]
fn image_without_recovery_leaves_bus_off_at_a_restart() {
    let mut rig = Rig::ims360(tilt("ims360", 0.0, 0.0));
    rig.download(0x3100, 2, [0]);
    rig.change_to_j1939();
    rig.run(500);
    // 2010h:01: the restart is 100 ms after the reply, which is disturbed.
    rig.send_text("18EF8021#2F10200101000000");
    rig.run(1);
    rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
    rig.wait_until(100, 90, is_off);
    rig.frames();
    rig.run(600);
    assert!(!is_off(&rig));
    let sent = rig.sent_text();
    assert_eq!(sent[0].1, CLAIM);
    assert_eq!(sent[1].1, NO_CODES);
    assert!(sent[2].1.starts_with("0CF02980#"));
    assert_eq!(rig.parameter(0x80, "4002310000000000").len(), 16);
}
