//! CANopen: a TPDO is switched on for the recording, or listened to if it is on already.

use super::{lost, millis, recorded, send, texts};
use crate::bus::files::file;
use crate::bus::rig::Rig;
use plumbline::can::{Frame, standard};
use serde_json::Value;

/// The products with their node-IDs, and the columns of the angles.
const NODES: [(&str, u8, &str); 2] = [
    ("jn2101", 10, "slope-long32_deg,slope-lateral32_deg"),
    ("ims360", 50, "slope-long32_deg,slope-lateral32_deg"),
];

/// Everything that can be read, without the angles.
fn settings(rig: &mut Rig, node: u8) -> Value {
    let mut read = rig.json(&format!("--node {node} get"));
    let entries = read.as_object_mut().unwrap();
    entries.retain(|name, _| name.contains("tpdo") || name.contains("heartbeat"));
    assert!(entries.len() > 8, "{entries:?}");
    read
}

/// The state in the heartbeat, which the node has meanwhile.
fn state(rig: &mut Rig, node: u8) -> String {
    send(rig, &[]);
    rig.done(&format!("--node {node} raw 1017:0=6400"));
    rig.witnessed();
    rig.run(250);
    let seen = texts(&rig.witnessed());
    rig.done(&format!("--node {node} raw 1017:0=0000"));
    let id = format!("{:03X}#", 0x700 + u16::from(node));
    let heartbeat = seen.iter().find_map(|frame| frame.strip_prefix(&id));
    heartbeat.expect("a heartbeat").to_owned()
}

/// The NMT commands and the writes of the tool.
fn changes(rig: &mut Rig, node: u8) -> Vec<String> {
    let mut seen = texts(&rig.witnessed());
    let request = format!("{:03X}#2", 0x600 + u16::from(node));
    seen.retain(|frame| frame.starts_with("000#") || frame.starts_with(&request));
    seen
}

#[test]
fn tpdo_at_1_khz_is_complete_and_everything_is_put_back() {
    for (product, node, columns) in NODES {
        for is_operational in [false, true] {
            let mut rig = Rig::with(product);
            rig.done(&format!(
                "--node {node} set tpdo2-event-timer=300ms tpdo1-inhibit-time=500us"
            ));
            if is_operational {
                send(&mut rig, &[(0, &[1, node])]);
            }
            let before = settings(&mut rig, node);
            let state_before = state(&mut rig, node);
            rig.witnessed();
            let name = format!("cyclic-{product}-{is_operational}.csv");
            let rows = recorded(&mut rig, &name, &format!("--node {node}"));
            let nmt: Vec<String> = changes(&mut rig, node);
            let nmt: Vec<&str> = nmt
                .iter()
                .filter_map(|frame| frame.strip_prefix("000#"))
                .collect();
            let commands = [format!("01{node:02X}"), format!("80{node:02X}")];
            let expected = if is_operational { &[][..] } else { &commands };
            assert_eq!(nmt, expected, "{product}");
            assert_eq!(rows[0], format!("time_s,{columns}"));
            let angles: Vec<&str> = rows[1000].split(',').collect();
            let time: f64 = angles[0].parse().unwrap();
            assert!((time - 0.999).abs() < 0.002, "{product} {time}");
            let polled = rig.json(&format!("--node {node} get slope-long32"));
            let polled = polled["slope-long32"]["value"].as_f64().unwrap();
            assert_eq!(angles[1].parse::<f64>().unwrap(), polled, "{product}");
            assert!(polled.abs() > 1.0, "{polled}");
            assert_eq!(settings(&mut rig, node), before, "{product}");
            assert_eq!(state(&mut rig, node), state_before, "{product}");
            assert_eq!(state_before, if is_operational { "05" } else { "7F" });
        }
    }
}

#[test]
fn cyclic_settings_are_not_stored() {
    for (product, node, _) in NODES {
        let mut rig = Rig::with(product);
        rig.witnessed();
        rig.done(&format!("--node {node} watch --cyclic --seconds 1"));
        let changes = changes(&mut rig, node);
        // Byte 1 and 2 of a write are the index: 1010h.
        assert!(changes.len() > 8, "{changes:?}");
        assert!(
            !changes.iter().any(|frame| frame[6..].starts_with("1010")),
            "{changes:?}"
        );
    }
}

#[test]
fn settings_and_state_are_put_back_after_ctrl_c() {
    for (product, node, _) in NODES {
        let before = settings(&mut Rig::with(product), node);
        let mut is_started = false;
        for looks in (1..).step_by(3) {
            let mut rig = Rig::with(product);
            rig.stop = Some(looks);
            let ended = rig.tool(&format!(
                "--node {node} watch --every 10 --cyclic --seconds 0.2"
            ));
            rig.stop = None;
            let changes = changes(&mut rig, node);
            let nmt: Vec<&str> = changes
                .iter()
                .filter_map(|frame| frame.strip_prefix("000#"))
                .map(|frame| &frame[..2])
                .collect();
            assert!(nmt.is_empty() || nmt == ["01", "80"], "{looks} {ended:?}");
            is_started |= !nmt.is_empty();
            let own = settings(&mut rig, node);
            assert_eq!(own, before, "{product} {looks} {ended:?}");
            if ended.out.lines().count() >= 18 {
                assert!(looks > 20 && is_started, "{looks}");
                break;
            }
        }
    }
}

#[test]
fn lost_adapter_is_reported_and_a_power_cycle_restores_the_settings() {
    for (product, node, _) in NODES {
        let before = settings(&mut Rig::with(product), node);
        let mut said = 0;
        for cut in (1..).step_by(2) {
            let mut rig = Rig::with(product);
            rig.cut = Some(cut);
            let ended = rig.tool(&format!(
                "--node {node} watch --every 10 --cyclic --seconds 0.05"
            ));
            rig.cut = None;
            if ended.code == 0 {
                break;
            }
            assert_eq!(ended.code, 4, "{ended:?}");
            let is_said = ended.notes.contains("switch the sensor off and on");
            said += u8::from(is_said);
            if !is_said {
                // Only the heartbeat for the question about the state can differ.
                let now = settings(&mut rig, node);
                let tpdos = |all: &Value| {
                    let mut all = all.as_object().unwrap().clone();
                    all.retain(|name, _| name.contains("tpdo"));
                    all
                };
                assert_eq!(tpdos(&now), tpdos(&before), "{product} {cut}");
            }
            let id = rig.first();
            rig.power_cycle(id);
            assert_eq!(settings(&mut rig, node), before, "{product} {cut}");
        }
        assert!(said > 3, "{product} {said}");
    }
}

#[test]
fn tpdo_that_is_sent_already_is_only_listened_to() {
    for (product, node, columns) in [
        // TPDO 1 has the angles with 16 bits.
        ("jn2101", 10, "slope-long16_deg,slope-lateral16_deg"),
        NODES[1],
    ] {
        let mut rig = Rig::with(product);
        rig.done(&format!(
            "--node {node} set tpdo1-transmission-type=254 tpdo1-event-timer=20ms"
        ));
        send(&mut rig, &[(0, &[1, node])]);
        let path = file(&format!("already-{product}.csv"));
        rig.witnessed();
        let ended = rig.tool(&format!(
            "--node {node} record {} --every 7 --cyclic --seconds 2",
            path.display()
        ));
        assert_eq!(changes(&mut rig, node), [""; 0], "{product}");
        let [missing, all] = lost(&ended);
        assert!(missing == 0 && (99..=101).contains(&all), "{ended:?}");
        assert!(
            ended.notes.contains("TPDO 1 already, every 20 ms"),
            "{ended:?}"
        );
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().next(), Some(&*format!("time_s,{columns}")));
        assert_eq!(state(&mut rig, node), "05");
    }
}

#[test]
fn tpdo_that_comes_with_sync_has_its_period() {
    let mut rig = Rig::with("jn2101");
    send(&mut rig, &[(0, &[1, 10])]);
    rig.cyclic = Some((25, Frame::data(standard(0x80), &[]).unwrap()));
    rig.witnessed();
    let ended = rig.tool("--node 10 watch --cyclic --seconds 2");
    assert_eq!(changes(&mut rig, 10), [""; 0]);
    let [missing, all] = lost(&ended);
    assert!(missing == 0 && (78..=81).contains(&all), "{ended:?}");
    assert!(ended.notes.contains("every 25"), "{ended:?}");
    // Without SYNC a TPDO with an event timer is switched on.
    rig.cyclic = None;
    let ended = rig.tool("--node 10 watch --cyclic --every 50 --seconds 2");
    assert_eq!(lost(&ended)[0], 0, "{ended:?}");
    let changes = changes(&mut rig, 10);
    let tpdo = changes
        .iter()
        .filter(|frame| frame[6..].starts_with("0118"));
    assert_eq!((tpdo.count(), changes.len()), (10, 12), "{changes:?}");
}

#[test]
fn slow_tpdo_of_an_operational_node_is_listened_to() {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 set tpdo1-event-timer=5s");
    send(&mut rig, &[(0, &[1, 50])]);
    rig.witnessed();
    let ended = rig.tool("--node 50 watch --cyclic --seconds 21");
    let [missing, all] = lost(&ended);
    assert!(missing == 0 && (4..=5).contains(&all), "{ended:?}");
    // Only the heartbeat (1017h) changed, for the question about the state.
    let changes = changes(&mut rig, 50);
    assert!(
        changes.len() == 2 && changes.iter().all(|frame| frame[6..].starts_with("1710")),
        "{changes:?}"
    );
}

#[test]
fn tpdos_that_are_missing_are_counted() {
    let mut rig = Rig::with("jn2101");
    let now = rig.bus.borrow().now();
    rig.deaf = Some((now + millis(3500), now + millis(4100)));
    let ended = rig.tool("--node 10 watch --every 20 --cyclic --seconds 4");
    let [missing, all] = lost(&ended);
    assert!((29..=31).contains(&missing), "{}", ended.notes);
    assert!((198..=201).contains(&all), "{}", ended.notes);
    assert_eq!(ended.out.lines().count() as u64, all - missing);
}

#[test]
fn sensor_stops_sending_after_a_power_cycle() {
    let mut rig = Rig::with("ims360");
    let id = rig.first();
    let before = settings(&mut rig, 50);
    // Another node resets it every 2.5 s, so it stays pre-operational.
    rig.cyclic = Some((2500, Frame::data(standard(0), &[129, 50]).unwrap()));
    let ended = rig.tool("--node 50 watch --every 20 --cyclic --seconds 20");
    assert_eq!(ended.code, 3, "{ended:?}");
    assert!(ended.notes.contains("does not send its angles any more"));
    rig.cyclic = None;
    assert!(rig.bus.borrow().device(id).boots() > 0);
    assert_eq!(settings(&mut rig, 50), before);
}

#[test]
fn angles_are_mapped_into_a_tpdo_that_is_off() {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 set tpdo1-number-of-mapped-objects=1 tpdo2-mapping-entry-1=raw:1628438560");
    let before = settings(&mut rig, 50);
    let rows = recorded(&mut rig, "mapped.csv", "--node 50");
    assert_eq!(rows[0], format!("time_s,{}", NODES[1].2));
    let seen = texts(&rig.witnessed());
    assert!(
        seen.iter()
            .filter(|frame| frame.starts_with("2B2#"))
            .count()
            > 2990
    );
    assert_eq!(settings(&mut rig, 50), before);
}

#[test]
fn sensor_without_a_free_tpdo_is_refused_and_nothing_is_written() {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 set tpdo1-number-of-mapped-objects=1 tpdo2-cob-id=2B2h tpdo3-cob-id=3B2h tpdo4-cob-id=4B2h");
    rig.witnessed();
    assert_eq!(
        rig.fails("--node 50 watch --cyclic --seconds 1"),
        (1, "not-offered".to_owned())
    );
    let mut changes = changes(&mut rig, 50);
    changes.retain(|frame| !frame[6..].starts_with("1710"));
    assert_eq!(changes, [""; 0]);
}

#[test]
fn device_with_a_data_sheet_sends_its_slopes() {
    let mut rig = Rig::with("jn2101");
    let path = file("cyclic.eds");
    let product = plumbline::model::catalog::find("jn2101").unwrap();
    std::fs::write(&path, descriptors::describe(product).text).unwrap();
    let options = format!("--node 10 --eds {}", path.display());
    let before = settings(&mut rig, 10);
    let rows = recorded(&mut rig, "cyclic-eds.csv", &options);
    assert!(rows[0].starts_with("time_s,slope-long32"), "{}", rows[0]);
    assert_eq!(settings(&mut rig, 10), before);
}

/// The changes, without the changes of the heartbeat. The tool uses the heartbeat to ask for the state.
fn changes_of_tpdos(rig: &mut Rig, node: u8) -> Vec<String> {
    let mut changes = changes(rig, node);
    changes.retain(|frame| !frame[6..].starts_with("1710"));
    changes
}

#[test]
fn tpdo_of_an_operational_node_is_changed_only_after_a_yes() {
    let sync = Frame::data(standard(0x80), &[]).unwrap();
    for (kind, cyclic) in [(255, None), (1, Some((2000, sync))), (240, None)] {
        let mut rig = Rig::with("jn2101");
        rig.done(&format!(
            "--node 10 set tpdo1-transmission-type={kind} tpdo1-event-timer=0ms tpdo2-transmission-type={kind} tpdo2-event-timer=0ms"
        ));
        send(&mut rig, &[(0, &[1, 10])]);
        let before = settings(&mut rig, 10);
        rig.cyclic = cyclic;
        rig.says_yes = false;
        rig.witnessed();
        let watch = "--node 10 watch --cyclic --every 20 --seconds 1";
        let failed = rig.fails(watch);
        assert_eq!(failed, (2, "not-confirmed".to_owned()), "{kind}");
        assert_eq!(changes_of_tpdos(&mut rig, 10), [""; 0], "{kind}");
        assert!(rig.questions.iter().any(|text| text.contains("TPDO 2")));
        rig.says_yes = true;
        rig.done(watch);
        assert_eq!(changes_of_tpdos(&mut rig, 10).len(), 10, "{kind}");
        rig.cyclic = None;
        assert_eq!(settings(&mut rig, 10), before, "{kind}");
    }
}

#[test]
fn slow_tpdo_that_also_sends_changes_is_listened_to_without_a_period() {
    let mut rig = Rig::with("jn2101");
    rig.done("--node 10 set tpdo1-transmission-type=255 tpdo1-event-timer=2s");
    send(&mut rig, &[(0, &[1, 10])]);
    rig.says_yes = false;
    rig.witnessed();
    let ended = rig.tool("--node 10 watch --cyclic --seconds 9");
    let [missing, all] = lost(&ended);
    assert!(missing == 0 && (4..=5).contains(&all), "{ended:?}");
    assert!(ended.notes.contains("without a period"), "{ended:?}");
    assert_eq!(changes_of_tpdos(&mut rig, 10), [""; 0]);
}

#[test]
fn tpdo_on_change_that_rests_after_a_regular_motion_is_no_failure() {
    let mut rig = Rig::with("jn2101");
    rig.done("--node 10 set tpdo1-transmission-type=255 tpdo1-event-timer=0ms");
    send(&mut rig, &[(0, &[1, 10])]);
    rig.cyclic = Some((5, Frame::data(standard(0x18A), &[0; 8]).unwrap()));
    let now = rig.bus.borrow().now();
    rig.deaf = Some((now + millis(2500), now + millis(5500)));
    let ended = rig.tool("--node 10 watch --cyclic --seconds 6");
    assert_eq!(lost(&ended)[0], 0, "{}", ended.notes);
    assert!(ended.notes.contains("without a period"), "{}", ended.notes);
    let rows = &ended.times;
    let is_pause = |pair: &[_]| plumbline::time::after(pair[0], millis(2900)) <= pair[1];
    assert!(rows.windows(2).any(is_pause), "no rest");
}

#[test]
fn tpdo_that_is_off_is_switched_on_only_with_an_identifier_that_nobody_sends() {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 set tpdo1-number-of-mapped-objects=1 tpdo2-mapping-entry-1=raw:1628438560 tpdo3-cob-id=3B2h tpdo4-cob-id=4B2h");
    let watch = "--node 50 watch --cyclic --every 20 --seconds 1";
    rig.done(watch);
    rig.cyclic = Some((100, Frame::data(standard(0x2B2), &[1, 2]).unwrap()));
    rig.witnessed();
    assert_eq!(rig.fails(watch), (1, "not-offered".to_owned()));
    assert_eq!(changes_of_tpdos(&mut rig, 50), [""; 0]);
}
