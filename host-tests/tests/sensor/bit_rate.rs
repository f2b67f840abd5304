//! Bit rate detection of a sensor built for the PC (GEMAC manual, section 9.10.3). `images/detection.rs` has the same test of
//! the flashed image.

use bench::script::LEVEL;
use bench::{Bus, BusRate, Device, Flash, NodeType};
use host_tests::bit_rate::{check_detection, check_lone_master};
use host_tests::effort;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::node::BusMode;
use plumbline::time::Instant;

/// A level is2 with blank memory.
fn sensor() -> Device {
    let node_type = NodeType::find("is2").expect("a product");
    Device::new(&node_type, 1, Flash::default(), Box::new(LEVEL))
}

#[test]
fn each_rate_is_detected_within_2_frames_at_any_period_and_phase() {
    check_detection(sensor, 2, |rate, period| {
        // Within the frame and within the period.
        let count = effort::choose(4, 12);
        let step = period / count + 7_300_000 / u64::from(rate.bits_per_second());
        (0..count).map(|number| 60_000 + number * step).collect()
    });
}

#[test]
fn lone_master_is_acknowledged_within_36_attempts() {
    check_lone_master(sensor);
}

#[test]
fn silent_bus_changes_nothing() {
    let mut bus = Bus::new(BusRate::Wire);
    let device = bus.attach(sensor());
    bus.run_until(Instant::from_ticks(60_000_000));
    assert_eq!(bus.device(device).mode(), Some(BusMode::Listen));
    assert_eq!(bus.device(device).rate(), Some(BitRate::K250));
    assert_eq!(bus.take_log().len(), 0);
}

/// On a bus with one bit rate an assistant acknowledges, so that the virtual sensor works with one client.
#[test]
fn rate_is_detected_at_second_frame_of_lone_client() {
    for rate in BitRate::ALL {
        let mut bus = Bus::new(BusRate::Fixed(rate));
        let device = bus.attach(sensor());
        let client = bus.adapter();
        bus.open(client, Some(rate), false);
        for second in 1..=2 {
            bus.run_until(Instant::from_ticks(second * 100_000));
            assert_eq!(bus.device(device).mode(), Some(BusMode::Listen));
            let request = Frame::data(standard(0x123), &[]).expect("no data");
            bus.send(client, request);
            bus.run_until(Instant::from_ticks(second * 100_000 + 50_000));
            if rate == BitRate::K250 {
                break;
            }
        }
        assert_eq!(bus.device(device).mode(), Some(BusMode::Normal), "{rate:?}");
    }
}
