//! What a technician meets who exchanges a sensor: files of other sensors, supply that fails, traffic of unknown devices.

use super::decode::log;
use super::rig::{Rig, file};
use bench::{Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Duration, after};
use std::rc::Rc;

/// The output and the notes of `decode` for frames with these texts.
fn decode(name: &str, options: &str, frames: &[&str]) -> (String, String) {
    let frames = frames.iter().map(|text| can_wire::text::frame(text));
    let path = log(name, frames);
    let ended = Rig::with("is2").tool(&format!("{options} decode {}", path.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    (ended.out, ended.notes)
}

/// Node 10 is known to be of CANopen by its heartbeat, but has not told its product. Its TPDO has two values of 16 bits, -3 and 1.
#[test]
fn process_data_of_a_node_that_has_not_told_its_product_are_bytes() {
    let frames = ["70A#05", "18A#0100FDFF", "28A#0100FDFF", "38A#0100FDFF"];
    let (out, notes) = decode("untold", "", &frames);
    assert!(!out.contains("deg") && !out.contains("slope"), "{out}");
    for number in 1..=3 {
        let line = format!("canopen 10: TPDO {number}, data = 01 00 FD FF");
        assert!(out.contains(&line), "{out}");
    }
    for part in ["canopen 10", "--product", "--eds"] {
        assert!(notes.contains(part), "{notes}");
    }
    // With the product the values are those of its manual, and nothing is to be told.
    let (out, notes) = decode("told", "--product jn2101", &frames[..2]);
    assert!(
        out.contains("TPDO 1, slope-long16 = 0.01 deg, slope-lateral16 = -0.03 deg"),
        "{out}"
    );
    assert_eq!(notes, "");
}

#[test]
fn objects_of_a_device_that_is_in_no_table_are_numbers() {
    // 1018h:1 is the identity of another maker. 2001h is the bit rate of an IMS360, 6010h an angle of both.
    let frames = [
        "70A#00",
        "60A#4018100100000000",
        "58A#4318100199000000",
        "58A#4301200048E80100",
        "58A#4B10600001000000",
    ];
    let (out, notes) = decode("foreign-objects", "", &frames);
    for part in [
        "SDO answer 2001h:0, value = 0001E848h",
        "SDO answer 6010h:0, value = 0001h",
        "SDO answer 1018h:1 vendor-id, value = 00000099h",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    assert!(notes.contains("canopen 10"), "{notes}");
}

/// A slave of vendor 1 is no TILTIX, though its I/O messages have the size of two angles.
#[test]
fn process_data_of_a_foreign_devicenet_slave_are_bytes() {
    let frames = ["5FF#00010001000000", "5FD#", "3FF#E803F401"];
    let (out, notes) = decode("foreign-slave", "", &frames);
    assert!(out.contains("poll response, data = E8 03 F4 01"), "{out}");
    assert!(notes.contains("devicenet 63"), "{notes}");
}

#[test]
fn frames_that_no_table_has_are_counted_with_a_hint_at_the_end() {
    let frames = ["123#0102", "124#01", "300#02", "301#0203"];
    let (_, notes) = decode("no-table", "", &frames);
    for part in ["in no table: 2.", "--product", "--eds", "--dbc"] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    rig.cyclic = Some((40, Frame::data(standard(0x7A0), &[1]).unwrap()));
    let log = "--rate 250 log - --seconds 1";
    let ended = rig.tool(&format!("{log} --decode"));
    assert!(ended.notes.contains("in no table: "), "{ended:?}");
    // Nobody has asked what they are.
    assert!(!rig.tool(log).notes.contains("table"));
}

/// 2042h: the reference frame of the teach-in is in the sensor only (9.5). 2046h: the zero point.
#[test]
fn position_that_no_file_can_carry_is_told_by_backup_restore_and_diff() {
    let old = file("taught.toml");
    let old = old.display().to_string();
    let mut rig = Rig::with("jn2101");
    let told = |rig: &mut Rig, command: &str| rig.tool(command).notes;
    assert!(!told(&mut rig, &format!("backup {old}")).contains("teach"));
    assert!(!told(&mut rig, &format!("diff {old}")).contains("teach"));
    rig.done("teach");
    let notes = told(&mut rig, &format!("backup {old}"));
    assert!(notes.contains("has set teach from its position"), "{notes}");
    // The same sensor still has it.
    for command in ["diff", "restore"] {
        let notes = told(&mut rig, &format!("{command} {old}"));
        assert!(!notes.contains("position"), "{command}: {notes}");
    }
    let mut new = Rig::new(BusRate::Follow);
    (new.rate, new.says_yes) = (Some("250"), true);
    new.attach("jn2101", 2);
    new.run(3000);
    for is_taught in [false, true] {
        // It can have another reference frame.
        if is_taught {
            new.done("teach");
        }
        for command in ["diff", "restore"] {
            let notes = told(&mut new, &format!("{command} {old}"));
            assert!(notes.contains("cannot carry teach"), "{command}: {notes}");
            assert!(notes.contains("same position"), "{command}: {notes}");
        }
    }
    // A change in the file keeps it.
    new.done(&format!("set heartbeat=500ms --file {old}"));
    assert!(told(&mut new, &format!("diff {old}")).contains("cannot carry teach"));
}

/// The offset of the preset can only be read.
#[test]
fn preset_of_a_tiltix_is_told_as_a_position_too() {
    let path = file("preset.toml");
    let mut rig = Rig::with("tiltix080");
    rig.done("set slope-long16-preset-value=1deg slope-long16-preset-enable=on");
    let notes = rig.tool(&format!("backup {}", path.display())).notes;
    assert!(notes.contains("slope-long16-offset"), "{notes}");
}

#[test]
fn file_of_another_sensor_is_replaced_after_a_question_with_both_serial_numbers() {
    let path = file("other-sensor.toml");
    let backup = format!("backup {}", path.display());
    let mut rig = Rig::with("is2");
    rig.done(&backup);
    let old = std::fs::read_to_string(&path).unwrap();
    // The same sensor.
    rig.done(&backup);
    assert!(
        rig.questions[0].ends_with("exists. Replace it?"),
        "{:?}",
        rig.questions
    );
    let mut other = Rig::new(BusRate::Follow);
    other.rate = Some("250");
    other.attach("is2", 4711);
    other.run(3000);
    assert_eq!(
        other.fails(&format!("--id 300 {backup}")),
        (2, "file-exists".to_owned())
    );
    let question = other.questions.last().unwrap();
    for part in ["another sensor", "is2 1", "is2 4711"] {
        assert!(question.contains(part), "{question}");
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap(), old);
    other.says_yes = true;
    other.done(&format!("--id 300 {backup}"));
    assert!(
        std::fs::read_to_string(&path)
            .unwrap()
            .contains("serial = 4711")
    );
}

/// The supply fails at each fifth frame of the second half: requests and replies. The same command completes the restore.
#[test]
fn restore_that_loses_the_supply_says_what_is_written_and_that_it_is_to_be_repeated() {
    for (product, settings, kept) in [
        (
            "is2",
            "cyclic-time=100ms filter=1Hz,butterworth",
            "but not stored",
        ),
        (
            "jn2101",
            "heartbeat=500ms tpdo1-event-timer=20ms",
            "but not stored",
        ),
        (
            "ims360",
            "producer-heartbeat=500ms zero-x=1.5deg",
            "but not stored",
        ),
        (
            "tiltix080",
            "size-of=50 slope-long16-preset-value=1deg",
            "and the sensor keeps",
        ),
    ] {
        let path = file(&format!("supply-{product}.toml"));
        let mut rig = Rig::with(product);
        rig.done(&format!("set {settings}"));
        rig.done(&format!("backup {}", path.display()));
        let restore = format!("restore {}", path.display());
        let mut rig = Rig::with(product);
        rig.witnessed();
        let start = rig.bus.borrow().now();
        rig.done(&restore);
        let times = rig.witnessed_at().into_iter();
        let times: Vec<u64> = times.map(|(at, _)| at.ticks() - start.ticks()).collect();
        let mut partly = false;
        for passed in times[times.len() / 2..].iter().step_by(5) {
            let mut rig = Rig::with(product);
            let id = rig.first();
            let happens = move |bus: &mut Bus| {
                let now = bus.now();
                bus.device_mut(id).power_off(now);
            };
            let at = after(rig.bus.borrow().now(), Duration::from_ticks(*passed));
            rig.events.push((at, Rc::new(happens)));
            let ended = rig.tool(&restore);
            if ended.code != 0 {
                assert_eq!(ended.code, 3, "{product} {passed} {ended:?}");
            }
            if ended.notes.contains("interrupted") {
                for part in ["settings are written", kept, "repeat the same command"] {
                    assert!(ended.notes.contains(part), "{product} {part} {ended:?}");
                }
                partly |= !ended.notes.contains(" 0 of ");
            }
            rig.power_cycle(id);
            rig.done(&restore);
            let same = format!("diff {} --exit-code", path.display());
            assert_eq!(rig.tool(&same).code, 0, "{product} {passed}");
        }
        assert!(partly, "{product}");
    }
}

/// Its identifiers are not known, and it sends its angles all the time, so its first frame comes at once.
#[test]
fn scan_waits_until_a_sensor_in_cyclic_mode_is_switched_on() {
    for is_alone in [true, false] {
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
        rig.attach("is2", 5);
        let set =
            "set set-id=310h reply-id=311h baud-rate=250k cyclic-time=50ms cyclic-mode=on --save";
        rig.done(&format!("--rate 250 --id 300 {set}"));
        let id = rig.first();
        rig.bus.borrow_mut().power_cycle(id);
        rig.run(500);
        let other = rig.bus.borrow_mut().adapter();
        if !is_alone {
            rig.bus.borrow_mut().open(other, Some(BitRate::K250), false);
        }
        rig.power_cycle_at(rig.later(8000), id);
        let ended = rig.tool("--rate 250 scan");
        let has_row = ended
            .out
            .lines()
            .any(|line| line.contains("is2  address 310"));
        assert_eq!((ended.code, has_row), (0, true), "{is_alone} {ended:?}");
        assert!(rig.questions.is_empty(), "{:?}", rig.questions);
        assert!(
            ended.notes.contains("switch the sensor off and on now"),
            "{ended:?}"
        );
        // It asks at once if nobody switches it on.
        let start = rig.bus.borrow().now();
        rig.tool("--rate 250 scan --active");
        let time = rig.bus.borrow().now().ticks() - start.ticks();
        assert!(time < 3_000_000, "{time} us");
    }
}
