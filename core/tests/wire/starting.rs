//! Before the first measurement: a node answers, but does not send angles that it has not measured.

use crate::tester::canopen::frame;
use plumbline::can::{Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is1::{self, Is1};
use plumbline::model::gemac::is2::{self, Is2};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::{Boot, Node};
use plumbline::time::Instant;

/// The frames that the node sends at this time, in ms, after all its actions.
fn sent(node: &mut impl Node, ms: u64) -> Vec<String> {
    let now = Instant::from_ticks(1000 * ms);
    while node.poll(now).is_some() {}
    let frames = std::iter::from_fn(|| node.transmit(now));
    frames.map(|frame| format!("{frame:?}")).collect()
}

/// The frames that the node sends in reply to a frame.
fn reply(node: &mut impl Node, ms: u64, text: &str) -> Vec<String> {
    node.receive(Instant::from_ticks(1000 * ms), &frame(text));
    sent(node, ms)
}

fn level() -> Reading {
    Reading {
        acceleration: I32x3 {
            x: 0,
            y: 0,
            z: ONE_G,
        },
        temperature: 25_00,
        ..Reading::default()
    }
}

/// A GEMAC sensor that has detected the bit rate; the first two frames are the boot-up messages.
fn on_the_bus(node: &mut impl Node) -> Vec<String> {
    let now = Instant::from_ticks(1000);
    node.receive(now, &Frame::data(standard(0x7FF), &[]).unwrap());
    sent(node, 1)
}

#[test]
fn boot_up_message_before_first_measurement_has_no_sensor_error() {
    let mut is2 = Is2::new(&is2::BP_CL, Instant::from_ticks(0), &Boot::default());
    assert_eq!(on_the_bus(&mut is2), ["301#FF03000300004403"; 2]);
    assert_eq!(reply(&mut is2, 2, "300#02"), ["301#0203"]);
}

/// Tables 14 and 15: SensorError (bit 4), or SensorErrorX and SensorErrorY (bits 4 and 5).
#[test]
fn angles_before_first_measurement_have_sensor_errors() {
    let now = Instant::from_ticks(0);
    let mut is1 = Is1::new(&is1::BP_CL, now, &Boot::default());
    let mut is2 = Is2::new(&is2::BP_CL, now, &Boot::default());
    on_the_bus(&mut is1);
    on_the_bus(&mut is2);
    assert_eq!(reply(&mut is1, 2, "300#00"), ["301#00130000"]);
    assert_eq!(reply(&mut is2, 2, "300#00"), ["301#003300000000"]);
    assert_eq!(reply(&mut is2, 3, "100#"), ["301#003300000000"]);
    is2.sample(Instant::from_ticks(5000), &level());
    assert_eq!(reply(&mut is2, 5, "300#00"), ["301#000300000000"]);
}

/// Without measurements for 100 ms, the accelerometer has failed.
#[test]
fn missing_measurements_are_sensor_errors_in_every_reply_after_100_ms() {
    let mut is2 = Is2::new(&is2::BP_CL, Instant::from_ticks(0), &Boot::default());
    on_the_bus(&mut is2);
    sent(&mut is2, 100);
    assert_eq!(reply(&mut is2, 101, "300#02"), ["301#0233"]);
    let mut jn2101 = Jn2101::new(Instant::from_ticks(0), &Boot::default());
    assert_eq!(sent(&mut jn2101, 1), ["70A#00"]);
    assert_eq!(sent(&mut jn2101, 100), ["08A#0010010100000000"]);
}

/// 08000024h: no data available (CiA 301, 7.2.4.3.17).
#[test]
fn jn2101_does_not_send_angles_before_first_measurement() {
    let mut node = Jn2101::new(Instant::from_ticks(0), &Boot::default());
    assert_eq!(sent(&mut node, 1), ["70A#00"]);
    assert_eq!(
        reply(&mut node, 2, "60A#4010600000000000"),
        ["58A#8010600024000008"]
    );
    // Other objects can be read: the error register.
    assert_eq!(
        reply(&mut node, 3, "60A#4001100000000000"),
        ["58A#4F01100000000000"]
    );
    assert!(reply(&mut node, 4, "000#010A").is_empty());
    assert!(reply(&mut node, 5, "080#").is_empty());
    node.sample(Instant::from_ticks(6000), &level());
    assert_eq!(
        reply(&mut node, 6, "60A#4010600000000000"),
        ["58A#4B10600000000000"]
    );
    assert_eq!(reply(&mut node, 7, "080#").len(), 2);
}
