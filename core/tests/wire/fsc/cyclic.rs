//! Cyclic mode of the FSC sensors, alone and together with polls and sync frames (manual 9.9.2, 9.9.3 and 9.10.1).

use crate::tester::fsc::*;
use crate::tester::gemac::*;
use plumbline::can::{Frame, standard};
use plumbline::fsc::Product;
use plumbline::model::gemac::is2::TwoAxes;
use plumbline::node::Node;

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

/// The time of the frames since power-up in ms.
fn now<P: Product>(unit: &Unit<P>) -> u64 {
    unit.tester.now.ticks() / 1000
}

#[test]
fn every_poll_sync_and_period_is_answered_once() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.accepts(CYCLIC_TIME, 20);
        unit.accepts(CYCLIC_MODE, 1);
        let start = now(&unit);
        for number in 1..400 {
            // Every 4 ms, so every fifth one is at the end of a period.
            let frames = unit.tester.wait(4);
            let counter = number / 5;
            let expected = unit.frame(1, &unit.inclination(Some(counter)));
            let due = (number % 5 == 0).then_some((start + 4 * u64::from(number), expected));
            assert!(frames.into_iter().eq(due), "{number}");
            let request = match number % 3 {
                0 => unit.frame(2, &[]),
                _ => unit.frame(0, &[0x00]),
            };
            unit.tester.receive(request);
            assert_eq!(unit.tester.sent(), [expected], "{number}");
        }
        unit.accepts(CYCLIC_MODE, 0);
        assert_eq!(unit.tester.wait(1000), []);
        unit.ask(&[0x00], &unit.inclination(None));
    }
    each_product!(check);
}

#[test]
fn counter_follows_shortest_period_and_wraps() {
    let mut unit = IS2.online::<TwoAxes>();
    unit.accepts(CYCLIC_TIME, 1);
    unit.accepts(CYCLIC_MODE, 1);
    let start = now(&unit);
    let frames = unit.tester.wait(66_000);
    assert_eq!(frames.len(), 66_000);
    for (number, (at, frame)) in (1_u64..).zip(frames) {
        let expected = unit.inclination(Some(number as u16));
        assert_eq!((at, frame.bytes()), (start + number, &expected[..]));
    }
}

/// With a fixed baud rate, the boot-up messages come first, then the first value after one period with counter 1.
#[test]
fn saved_cyclic_mode_with_fixed_baud_rate_begins_at_power_up() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for (place, value) in [(CYCLIC_TIME, 80), (CYCLIC_MODE, 1), (BAUD_RATE, 6)] {
            unit.accepts(place, value);
        }
        unit.saves();
        let values = unit.values.clone();
        unit.power_cycle(&values);
        let start = now(&unit);
        unit.boots();
        let frames = unit.tester.wait(400);
        let expected = (1..=5).map(|counter| {
            let frame = unit.frame(1, &unit.inclination(Some(counter)));
            (start + 80 * u64::from(counter), frame)
        });
        assert!(frames.iter().copied().eq(expected), "{frames:?}");
    }
    each_product!(check);
}

/// A write of the value in force moves no period and no counter (G23): a tool that repeats its settings does not silence the sensor.
#[test]
fn values_in_force_written_again_do_not_move_the_period() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        unit.accepts(CYCLIC_TIME, 250);
        unit.accepts(CYCLIC_MODE, 1);
        let start = now(&unit);
        let (mut counter, mut due) = (0, start + 250);
        for _ in 0..40 {
            // All parameters, every 200 ms.
            for place in 0..sheet.parameters.len() {
                let request = sheet.parameters[place].write(unit.values[place]);
                unit.acknowledges(&request);
            }
            let frames = unit.tester.wait(200);
            let mut expected = Vec::new();
            while due <= now(&unit) {
                counter += 1;
                expected.push((due, unit.frame(1, &unit.inclination(Some(counter)))));
                due += 250;
            }
            assert_eq!(frames, expected);
        }
        assert_eq!(counter, 32);
        unit.keeps_values();
    }
    each_product!(check);
}

/// Switching on while it is on changes neither counter nor period (G23). LOAD ends it.
#[test]
fn cyclic_mode_continues_until_off_or_load() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut unit = sheet.online::<P>();
        for end in [true, false] {
            unit.accepts(CYCLIC_TIME, 200);
            unit.accepts(CYCLIC_MODE, 1);
            let start = now(&unit);
            unit.tester.wait(90);
            unit.accepts(CYCLIC_MODE, 1);
            unit.ask(&[0x00], &unit.inclination(Some(0)));
            let first = unit.frame(1, &unit.inclination(Some(1)));
            assert_eq!(unit.tester.wait(110), [(start + 200, first)]);
            if end {
                unit.accepts(CYCLIC_MODE, 0);
            } else {
                unit.loads();
            }
            assert_eq!(unit.tester.wait(1000), []);
            unit.ask(&[0x00], &unit.inclination(None));
        }
    }
    each_product!(check);
}
