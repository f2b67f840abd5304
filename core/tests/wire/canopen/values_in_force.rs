//! The value in force is accepted in each state, and its write changes nothing: no period, timer or counter starts again. Configuration
//! tools write all settings back, some of them cyclically.

use crate::tester::Tester;
use crate::tester::canopen::{booted, write_request};
use crate::tester::{ims360, j1939};
use plumbline::canopen::dictionary::{Access, Object, Target};
use plumbline::model::catalog::{Product, Protocol, find};
use plumbline::node::{Action, Node};
use plumbline::param::Persistence;

/// An object that is written back: index, sub-index and size.
type Setting = (u16, u8, u8);

/// The objects of a product that can be read and written, except commands.
fn settings(product: &'static Product) -> Vec<Setting> {
    let Protocol::Canopen(tables) = &product.protocol else {
        panic!("CANopen")
    };
    let is_setting = |object: &&Object| match object.target {
        Target::Parameter(id) => {
            product.parameters[usize::from(id.0)].persistence != Persistence::AtOnce
        }
        Target::CobId(_) | Target::FreeCobId(_) => true,
        _ => false,
    };
    let writable = tables
        .objects
        .iter()
        .filter(|object| object.access == Access::Rw);
    let settings = writable.filter(is_setting).map(|object| {
        let data_type = object.data_type(product.parameters, product.quantities);
        (object.index, object.sub, data_type.size())
    });
    settings.collect()
}

/// Writes a setting back every ms for 1500 ms. Returns the other frames and their times.
fn written_back<N: Node>(t: &mut Tester<N>, settings: &[Setting]) -> Vec<(u64, String)> {
    let mut frames = Vec::new();
    for ms in 0..1500 {
        frames.extend(
            t.wait_text(1)
                .into_iter()
                .map(|(at, frame)| (ms + at, frame)),
        );
        let Some(&(index, sub, size)) = settings.get(ms as usize % settings.len().max(1)) else {
            continue;
        };
        let value = t.read(index, sub).unwrap();
        let written = t.write(index, sub, size, value);
        assert_eq!(written, Ok(()), "{index:04X}h:{sub:02X} = {value:X}h");
        assert_eq!(t.read(index, sub), Ok(value));
    }
    frames
}

/// Compares the frames with those of a sensor without writes, in each state that answers.
fn assert_nothing_moves<N: Node>(name: &str, configured: impl Fn() -> Tester<N>, least: usize) {
    let settings = settings(find(name).expect("a product"));
    for state in [0x80, 0x01] {
        let run = |settings: &[Setting]| {
            let mut t = configured();
            t.send(&format!("000#{state:02X}00"));
            t.sent_text();
            t.actions.clear();
            let frames = written_back(&mut t, settings);
            assert!(
                !t.actions
                    .iter()
                    .any(|action| matches!(action, Action::Save | Action::Bus { .. }))
            );
            frames
        };
        let undisturbed = run(&[]);
        assert!(undisturbed.len() >= least, "{undisturbed:?}");
        assert_eq!(run(&settings), undisturbed, "{name} in state {state:02X}");
    }
    // While a save is running.
    let mut t = configured();
    t.memory_works = None;
    t.send(&format!(
        "{:03X}#2310100173617665",
        0x600 + u32::from(t.node_id)
    ));
    written_back(&mut t, &settings);
}

#[test]
fn value_in_force_moves_no_period_of_the_jn2101() {
    let configured = || {
        let mut t = booted();
        for (index, sub, size, value) in [
            (0x1015, 0, 2, 100),
            (0x1017, 0, 2, 165),
            (0x1029, 1, 1, 1),
            (0x1800, 2, 1, 254),
            (0x1800, 3, 2, 300),
            (0x1800, 5, 2, 70),
            (0x1801, 2, 1, 255),
            (0x1801, 5, 2, 90),
            (0x2043, 0, 1, 3),
        ] {
            t.write(index, sub, size, value).unwrap();
        }
        t
    };
    assert_nothing_moves("jn2101", configured, 9);
}

#[test]
fn value_in_force_moves_no_period_of_the_ims360() {
    let configured = || {
        let mut t = ims360::booted();
        t.map(1, &[0x6511_0008]);
        for (index, sub, size, value) in [
            (0x1017, 0, 2, 165),
            (0x1800, 5, 2, 70),
            (0x1800, 3, 2, 300),
            (0x1801, 2, 1, 255),
            (0x1801, 5, 2, 90),
            (0x3110, 1, 1, 1),
            (0x3111, 0, 2, 500),
        ] {
            t.write(index, sub, size, value).unwrap();
        }
        t
    };
    assert_nothing_moves("ims360", configured, 9);
}

#[test]
fn value_in_force_does_not_extend_the_life_time() {
    let mut t = booted();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 3).unwrap();
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    for _ in 0..2 {
        assert_eq!(t.wait_text(149), []);
        for (index, sub, size) in [
            (0x100C, 0, 2),
            (0x100D, 0, 1),
            (0x1029, 1, 1),
            (0x1017, 0, 2),
        ] {
            let value = t.read(index, sub).unwrap();
            t.write(index, sub, size, value).unwrap();
        }
    }
    assert_eq!(t.wait_text(3), [(2, "08A#3081114000000000".to_string())]);
}

#[test]
fn value_in_force_counts_no_sync_again() {
    let mut t = booted();
    t.write(0x1800, 2, 1, 3).unwrap();
    t.write(0x1801, 2, 1, 253).unwrap();
    t.send("000#010A");
    for number in 1..=9 {
        assert_eq!(
            t.exchange("080#").len(),
            usize::from(number % 3 == 0),
            "{number}"
        );
        t.write(0x1800, 2, 1, 3).unwrap();
        t.write(0x1800, 1, 4, 0x18A).unwrap();
        t.write(0x1A00, 0, 1, 2).unwrap();
        t.write(0x1005, 0, 4, 0x80).unwrap();
    }
}

#[test]
fn value_in_force_is_accepted_in_j1939_and_moves_no_period() {
    let settings = settings(find("ims360").expect("a product"));
    let run = |settings: &[Setting]| {
        let mut t = j1939::claimed_with(&[(0x2104, 2, 2, 70), (0x2104, 3, 2, 90)]);
        let mut frames = Vec::new();
        for ms in 0..1500 {
            frames.extend(
                t.wait_text(1)
                    .into_iter()
                    .map(|(at, frame)| (ms + at, frame)),
            );
            let Some((index, sub, size)) = settings.get(ms as usize % settings.len().max(1)) else {
                continue;
            };
            let [low, high] = index.to_le_bytes();
            let read = t.parameter(&format!("40{low:02X}{high:02X}{sub:02X}00000000"));
            let value = u32::from_str_radix(&read[8..], 16).unwrap().swap_bytes();
            let written = t.parameter(&write_request(*index, *sub, *size, value));
            assert!(written.starts_with("60"), "{index:04X}h: {written}");
        }
        frames
    };
    let undisturbed = run(&[]);
    assert!(undisturbed.len() > 30);
    assert_eq!(run(&settings), undisturbed);
}
