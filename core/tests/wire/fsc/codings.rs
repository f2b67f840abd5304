//! The numbers of baud rate and filter type do what the manual says of them (9.10.3, 9.10.5).

use crate::tester::fsc::*;
use crate::tester::gemac::IS2;
use plumbline::can::BitRate;
use plumbline::measure::ONE_G;
use plumbline::model::gemac::is2::TwoAxes;
use plumbline::node::{Action, BitTime, BusEvent, BusMode};

#[test]
fn saved_baud_rate_is_used_after_a_power_cycle() {
    let rates = [
        (1, BitRate::K10),
        (2, BitRate::K20),
        (3, BitRate::K50),
        (4, BitRate::K100),
        (5, BitRate::K125),
        (6, BitRate::K250),
        (7, BitRate::K500),
        (8, BitRate::K800),
        (9, BitRate::M1),
        (10, BitRate::K62_5),
    ];
    for (code, rate) in rates {
        let mut tester = is2();
        assert_eq!(tester.ask(&[0x23, code])[0], 0x23);
        assert_eq!(tester.ask(b"\x50SAVE")[0], 0x50);
        tester.power_cycle();
        assert_eq!(tester.sent().len(), 2, "two boot-up messages");
        let online = Action::Bus(BusMode::Normal, rate);
        assert!(
            tester.actions.contains(&online),
            "{code}: {:?}",
            tester.actions
        );
    }
}

/// DefaultParam and AutobaudDetection stay set.
#[test]
fn detection_of_a_bit_rate_changes_no_parameter() {
    for rate in BitRate::ALL {
        let mut unit = IS2.power_up::<TwoAxes>();
        unit.tester.bus(BusEvent::BitTime(BitTime::of(rate)));
        unit.wake();
        let online = Action::Bus(BusMode::Normal, rate);
        assert!(unit.tester.actions.contains(&online), "{rate:?}");
        unit.keeps_values();
    }
}

/// The angle X in 0.01 deg after each of the samples that follow a step from 0 to 30 deg with this filter at 2 Hz.
fn step_response(filter_type: u8) -> Vec<i16> {
    let mut tester = is2();
    assert_eq!(tester.ask(&[0x27, 0xD0, 0x07, filter_type])[0], 0x27);
    tester.rest(0, 0, ONE_G);
    let (x, z) = (-0.5, 0.75_f64.sqrt());
    let [x, z] = [x, z].map(|component: f64| (component * f64::from(ONE_G)) as i32);
    let angles = (0..1000).map(|_| {
        tester.reading(x, 0, z, false);
        let reply = tester.ask(&[0x00]);
        i16::from_le_bytes([reply[2], reply[3]])
    });
    angles.collect()
}

#[test]
fn filter_type_selects_off_butterworth_and_critically_damped() {
    let off = step_response(0);
    // Second order at 20 Hz: 90 % after 21 ms, 4 % overshoot.
    assert!(off[0] < 900 && off[5] > 2700, "{:?}", &off[..6]);
    assert!((3050..3200).contains(off.iter().max().unwrap()));
    // A Butterworth filter of the 8th order overshoots, a critically damped one does not.
    let butterworth = step_response(1);
    let critically_damped = step_response(2);
    assert!(butterworth[20] < 1500 && critically_damped[20] < 1500);
    assert!(*butterworth.iter().max().unwrap() > 3100);
    assert_eq!(*critically_damped.iter().max().unwrap(), 3000);
    for response in [off, butterworth, critically_damped] {
        assert_eq!(response[999], 3000);
    }
}
