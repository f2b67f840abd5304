//! The sensor on a bus, in virtual time.

use bench::{Bus, BusRate, Device, Flash, NodeType};
use plumbline::can::{Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};

/// At rest at 30 deg. The accelerometer measures the force against gravity.
fn tilted() -> Reading {
    let (sine, cosine) = (-0.5, 0.75_f64.sqrt());
    Reading {
        acceleration: I32x3 {
            x: (sine * f64::from(ONE_G)) as i32,
            y: 0,
            z: (cosine * f64::from(ONE_G)) as i32,
        },
        ..Reading::default()
    }
}

#[test]
fn slope_is_the_measured_angle_minus_the_mounting_angle() {
    let mut bus = Bus::new(BusRate::Follow);
    let node_type = NodeType::from(&mast::LISTING);
    let device = Device::new(&node_type, 1, Flash::default(), Box::new(tilted()));
    bus.attach(device);
    let tester = bus.adapter();
    bus.open(tester, None, false);
    let mut exchange = |id, data: &[u8]| {
        let frame = Frame::data(standard(id), data).expect("at most eight bytes");
        bus.send(tester, frame);
        bus.run_until(after(bus.now(), millis(1_500)));
        let received = bus.take_received(tester).into_iter();
        let texts = received.map(|(_, frame)| format!("{frame:?}"));
        texts.collect::<Vec<_>>()
    };
    // This frame is for the bit rate detection. The sensor sends its boot-up message.
    assert_eq!(exchange(0x700, &[]), ["714#00"]);
    // Operational; -5.00 deg into 2100h; SYNC.
    exchange(0x000, &[1, 20]);
    let write = [0x2B, 0x00, 0x21, 0x00, 0x0C, 0xFE, 0, 0];
    assert_eq!(exchange(0x614, &write), ["594#6000210000000000"]);
    // 35.00 deg.
    assert_eq!(exchange(0x080, &[]), ["194#AC0D"]);
}
