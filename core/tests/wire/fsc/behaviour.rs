//! Behaviour of the FSC sensors over time: saves, zero point, missing samples, bus-off, bursts (manual 9.2, 9.5.2, 9.8).
//!
//! Section and table numbers refer to the English manual of 2021.

use crate::tester::fsc::*;
use crate::tester::gemac::*;
use crate::tester::leds;
use plumbline::can::{Frame, standard};
use plumbline::fsc::Product;
use plumbline::measure::ONE_G;
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
fn zero_point_adjustment_adds_the_offset() {
    let mut tester = is2();
    // -30 deg about Y: X is asin(0.5) = 30 deg with g = (-ux, uy, uz).
    tester.rest(-ONE_G / 2, 0, 58_117_981);
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
fn burst_of_requests_is_answered_completely_and_in_order() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        let (mut expected, mut sent) = (Vec::new(), Vec::new());
        while expected.len() < 1000 {
            // Requests occupy the bus as long as the sensor accepts them.
            while unit.tester.node.ready() && expected.len() < 1000 {
                let number = expected.len() as u32;
                let request = match number % 4 {
                    0 => sheet.parameters[CYCLIC_TIME].write(number + 1),
                    1 => vec![0x15],
                    2 => vec![0x00],
                    _ => vec![0x02],
                };
                unit.tester.receive(unit.frame(0, &request));
                let reply = match number % 4 {
                    0 => {
                        unit.values[CYCLIC_TIME] = number + 1;
                        vec![0x25, unit.status()]
                    }
                    1 => unit.reading(CYCLIC_TIME),
                    2 => unit.inclination(None),
                    _ => vec![0x02, unit.status()],
                };
                expected.push(unit.frame(1, &reply));
            }
            sent.extend(unit.tester.sent());
        }
        assert!(sent == expected);
    }
    each_product!(check);
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

#[test]
fn filter_begins_again_after_missing_samples() {
    let mut tester = is2();
    tester.reading(0, 0, ONE_G, false);
    let level = tester.ask(&[0x00]);
    for _ in 0..100 {
        tester.reading(ONE_G, 0, ONE_G, false);
    }
    assert_ne!(tester.ask(&[0x00]), level);
    tester.wait_without_samples(200);
    tester.reading(0, 0, ONE_G, false);
    tester.reading(0, 0, ONE_G, false);
    assert_eq!(tester.ask(&[0x00]), level);
}
