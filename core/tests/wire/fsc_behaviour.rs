//! Behaviour of the FSC sensors over time and in motion: modes, zero point, sensor errors, bus-off (manual 9.2, 9.5.2, 9.9).
//!
//! Section and table numbers refer to the English manual of 2021.

use crate::tester::fsc::*;
use crate::tester::leds;
use plumbline::can::{Frame, standard};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::{Action, BusEvent, BusState, Node};
use plumbline::store::StoreError;

#[test]
fn save_delays_only_saves_and_resets() {
    let mut tester = is2();
    tester.memory_works = None;
    tester.silent(b"\x50SAVE");
    // Requests and sync frames are answered during the save.
    assert_eq!(tester.ask(&[0x00])[0], 0x00);
    tester.receive(Frame::data(standard(0x100), &[]).unwrap());
    assert_eq!(tester.sent().len(), 1);
    // A second save and a reset wait for the first save, and other requests are still answered.
    tester.silent(b"\x50SAVE");
    assert_eq!(tester.ask(&[0x00])[0], 0x00);
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent().len(), 1);
    tester.silent(b"\xFFRESET");
    assert_eq!(tester.ask(&[0x00])[0], 0x00);
    assert!(!tester.actions.contains(&Action::Restart));
    tester.finish_save(Err(StoreError));
    assert_eq!(tester.sent()[0].bytes()[0], 0x50);
    tester.wait(0);
    assert!(tester.actions.contains(&Action::Restart));
}

#[test]
fn three_modes_work_at_the_same_time() {
    let mut tester = is2();
    let s = AUTOBAUD;
    assert_eq!(tester.ask(&[0x25, 10, 0]), [0x25, s]);
    assert_eq!(tester.ask(&[0x26, 1]), [0x26, s]);
    // In cyclic mode each reply contains the counter, which starts at 0.
    assert_eq!(tester.ask(&[0x00]), [0, s, 0, 0, 0, 0, 0, 0]);
    let start = tester.now.ticks() / 1000;
    let frames = tester.wait(35);
    let expected = |period: u8| {
        (
            start + u64::from(period) * 10,
            vec![0, s, 0, 0, 0, 0, period, 0],
        )
    };
    let got: Vec<_> = frames
        .iter()
        .map(|(ms, frame)| (*ms, frame.bytes().to_vec()))
        .collect();
    assert_eq!(got, [expected(1), expected(2), expected(3)]);
    tester.receive(Frame::data(standard(0x100), &[]).unwrap());
    assert_eq!(tester.sent()[0].bytes(), [0, s, 0, 0, 0, 0, 3, 0]);
    // Switching on again has no effect. Switching off removes the counter. Then switching on restarts it at 0.
    tester.ask(&[0x26, 1]);
    assert_eq!(tester.ask(&[0x00])[6..], [3, 0]);
    tester.ask(&[0x26, 0]);
    assert_eq!(tester.ask(&[0x00]), [0, s, 0, 0, 0, 0]);
    tester.ask(&[0x26, 1]);
    assert_eq!(tester.ask(&[0x00])[6..], [0, 0]);
}

/// The times of the next frames, in ms from now, with their counters.
fn cyclic_values(tester: &mut FscTester<TwoAxes>, ms: u64) -> Vec<(u64, u16)> {
    let start = tester.now.ticks() / 1000;
    let frames = tester.wait(ms);
    frames
        .iter()
        .map(|(at, frame)| {
            let counter = [frame.bytes()[6], frame.bytes()[7]];
            (*at - start, u16::from_le_bytes(counter))
        })
        .collect()
}

#[test]
fn new_cyclic_time_acts_at_once_and_counter_continues() {
    let mut tester = is2();
    tester.ask(&[0x25, 10, 0]);
    tester.ask(&[0x26, 1]);
    assert_eq!(cyclic_values(&mut tester, 25), [(10, 1), (20, 2)]);
    // Half of a period has passed.
    tester.ask(&[0x25, 40, 0]);
    assert_eq!(cyclic_values(&mut tester, 90), [(40, 3), (80, 4)]);
}

#[test]
fn writes_of_other_parameters_do_not_change_the_cyclic_period() {
    let mut tester = is2();
    tester.ask(&[0x25, 10, 0]);
    tester.ask(&[0x26, 1]);
    cyclic_values(&mut tester, 5);
    for write in [
        &[0x20, 0x00, 0x04, 0, 0][..],
        &[0x23, 0],
        &[0x24, 1],
        &[0x28, 100, 0],
    ] {
        tester.ask(write);
    }
    assert_eq!(cyclic_values(&mut tester, 10), [(5, 1)]);
}

#[test]
fn queued_cyclic_value_is_replaced_by_newest() {
    let mut tester = is2();
    tester.ask(&[0x25, 10, 0]);
    tester.ask(&[0x26, 1]);
    for _ in 0..1000 {
        tester.now += plumbline::time::millis(10);
        assert_eq!(tester.node.poll(tester.now), None);
    }
    let sent = tester.sent();
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].bytes()[6..], 1000_u16.to_le_bytes());
}

#[test]
fn saved_cyclic_mode_begins_after_boot_up() {
    let mut tester = is2();
    tester.ask(&[0x26, 1]);
    tester.ask(b"\x50SAVE");
    tester.power_cycle();
    assert_eq!(
        tester.wait(5000),
        [],
        "no frame before the bit rate is detected"
    );
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    let start = tester.now.ticks() / 1000;
    let frames = tester.wait(260);
    let times: Vec<_> = frames
        .iter()
        .map(|(ms, frame)| (*ms - start, frame.bytes()[0]))
        .collect();
    assert_eq!(times, [(0, 0xFF), (0, 0xFF), (250, 0)]);
    assert_eq!(frames[2].1.bytes()[6..], [1, 0]);
}

#[test]
fn zero_point_adjustment_adds_the_offset() {
    let mut tester = is2();
    // -30 deg about Y: X is asin(0.5) = 30 deg with g = (-ux, uy, uz).
    tester.rest(-ONE_G / 2, 0, 232_471_924);
    assert_eq!(tester.ask(&[0x00])[2..], [0xB8, 0x0B, 0, 0]);
    tester.ask(&[0x28, 0x9C, 0xFF]); // -1.00 deg
    assert_eq!(tester.ask(&[0x00])[2..4], 2900_i16.to_le_bytes());
    // The sum is limited to +-90 deg.
    tester.ask(&[0x28, 0x28, 0x23]);
    assert_eq!(tester.ask(&[0x00])[2..4], 9000_i16.to_le_bytes());
    // Automatic: the negative measured value, independent of the previous offset.
    assert_eq!(tester.ask(&[0x28]), [0x28, AUTOBAUD]);
    assert_eq!(tester.ask(&[0x18])[2..], (-3000_i16).to_le_bytes());
    assert_eq!(tester.ask(&[0x00])[2..], [0, 0, 0, 0]);
    tester.ask(&[0x29]);
    assert_eq!(tester.ask(&[0x19])[2..], [0, 0]);
}

#[test]
fn one_axis_zero_offset_wraps() {
    let mut tester = is1();
    tester.rest(ONE_G, 0, 0); // 90 deg
    tester.ask(&[0x28, 0x9F, 0x8C]); // 359.99 deg
    assert_eq!(tester.ask(&[0x00])[2..], 8999_u16.to_le_bytes());
    assert_eq!(
        tester.ask(&[0x28, 0xA0, 0x8C])[1] & CMD_PARAM_ERROR,
        CMD_PARAM_ERROR
    );
    tester.ask(&[0x28]);
    assert_eq!(tester.ask(&[0x18])[2..], 27_000_u16.to_le_bytes());
    assert_eq!(tester.ask(&[0x00])[2..], [0, 0]);
}

#[test]
fn sensor_errors_follow_measured_angle() {
    let status = |tester: &mut FscTester<TwoAxes>| tester.ask(&[0x02])[1];
    let mut tester = is2();
    // Up vector at 84.9 and 85.1 deg about each axis; sin and cos from a table.
    let (inside, outside) = ((267_373_000, 23_863_000), (267_454_000, 22_929_000));
    tester.rest(inside.0, 0, inside.1);
    assert_eq!(status(&mut tester), DELIVERED);
    tester.rest(outside.0, 0, outside.1);
    assert_eq!(status(&mut tester), DELIVERED | 0x10);
    tester.rest(0, -outside.0, outside.1);
    assert_eq!(status(&mut tester), DELIVERED | 0x20);
    // The zero offset has no effect.
    tester.ask(&[0x29]);
    assert_eq!(status(&mut tester) & 0x30, 0x20);
    tester.rest(0, 0, ONE_G);
    assert_eq!(status(&mut tester) & 0x30, 0);
    // The limit of a basic line sensor is 80 deg.
    let mut basic: FscTester<TwoAxes> = online(&is2::SP_BL);
    basic.rest(inside.0, 0, inside.1);
    assert_eq!(status(&mut basic), DELIVERED | 0x10);
    // Clipping sets the errors of both axes for 100 ms.
    tester.reading(0, 0, ONE_G, true);
    assert_eq!(status(&mut tester) & 0x30, 0x30);
    for _ in 0..20 {
        tester.reading(0, 0, ONE_G, false);
    }
    assert_eq!(status(&mut tester) & 0x30, 0);
}

#[test]
fn one_axis_cross_slope_above_45_deg_is_sensor_error() {
    let mut tester = is1();
    tester.rest(0, 190_000_000, 189_000_000);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
    tester.rest(0, 189_000_000, 190_000_000);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED | 0x10]);
    tester.rest(0, ONE_G, 0);
    assert_eq!(tester.ask(&[0x02]), [0x02, DELIVERED]);
}

#[test]
fn node_leaves_bus_off_only_with_automatic_recovery() {
    let mut tester = is2();
    tester.bus(BusEvent::State(BusState::Warning));
    assert_eq!(tester.leds, leds(true, true), "single flash");
    tester.wait(200);
    assert_eq!(tester.leds, leds(true, false));
    tester.bus(BusEvent::State(BusState::BusOff));
    assert_eq!(tester.leds, leds(true, true));
    tester.wait(10_000);
    assert_eq!(tester.leds, leds(true, true));
    assert!(!tester.actions.contains(&Action::Recover));
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.node.transmit(tester.now), None);

    let mut tester = is2();
    tester.ask(&[0x24, 1]);
    tester.receive(Frame::data(standard(0x300), &[0x02]).unwrap());
    tester.bus(BusEvent::State(BusState::BusOff));
    assert!(tester.actions.contains(&Action::Recover));
    assert_eq!(tester.sent(), [], "off the bus");
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.sent().len(), 1, "the reply is kept");
    assert_eq!(tester.leds, leds(true, false));
}

#[test]
fn burst_of_requests_loses_no_reply() {
    let mut tester = is2();
    let mut asked = 0_u32;
    let mut answered = 0;
    while asked < 1000 {
        // Requests occupy the bus as long as the sensor accepts them.
        while tester.node.ready() && asked < 1000 {
            tester.receive(Frame::data(standard(0x300), &[0x10]).unwrap());
            asked += 1;
        }
        answered += tester.sent().len();
    }
    assert_eq!(answered, 1000);
}

#[test]
fn missing_samples_set_sensor_errors() {
    let mut tester = is2();
    assert_eq!(tester.ask(&[0x02])[1], DELIVERED);
    tester.wait_without_samples(99);
    assert_eq!(tester.ask(&[0x02])[1], DELIVERED);
    tester.wait_without_samples(10_000);
    assert_eq!(tester.ask(&[0x02])[1], DELIVERED | 0x30);
    tester.reading(0, 0, ONE_G, false);
    assert_eq!(tester.ask(&[0x02])[1], DELIVERED);
    tester.wait_without_samples(200);
    assert_eq!(tester.ask(&[0x02])[1], DELIVERED | 0x30);
}
