//! Angles that are not valid: numbers with too few bits, and angles that are not available. Their fields are empty.

use super::super::files::file;
use super::super::rig::Rig;
use super::{lost, send};
use bench::{BusRate, Device, Flash, Geometry, NodeType};
use plumbline::can::{CanId, Frame};
use plumbline::measure::{I32x3, ONE_G, Reading};
use serde_json::{Value, json};
use std::path::Path;

/// A JN2101 with an X angle of 45 deg, which is operational and sends 16 bits each 20 ms.
fn inclined(resolution: &str) -> Rig {
    let mut rig = Rig::new(BusRate::Follow);
    rig.rate = Some("250");
    rig.says_yes = true;
    let part = (f64::from(ONE_G) * 0.5_f64.sqrt()).round() as i32;
    let position = Reading {
        acceleration: I32x3 {
            x: -part,
            y: 0,
            z: part,
        },
        temperature: 25_00,
        ..Reading::default()
    };
    let node_type = NodeType::find("jn2101").unwrap();
    let flash = Flash::blank(Geometry::STM32F103);
    rig.attach_sensor(Device::new(&node_type, 1, flash, Box::new(position)));
    send(&mut rig, &[]);
    rig.run(5000);
    rig.done(&format!(
        "--node 10 set resolution={resolution} tpdo1-transmission-type=254 tpdo1-event-timer=20ms"
    ));
    send(&mut rig, &[(0, &[1, 10])]);
    rig
}

fn rows(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn angle_beyond_16_bits_is_an_empty_field_and_counted() {
    let path = file("clipped.csv");
    let record = |options: &str| {
        let path = path.display();
        format!("--node 10 --yes record {path} --every 20 --seconds 1 {options}")
    };
    let mut rig = inclined("0.001deg");
    // By polling, the angles have 32 bits.
    let ended = rig.tool(&record(""));
    assert!(
        rows(&path).iter().all(|row| row.contains("45.0")),
        "{ended:?}"
    );
    assert!(!ended.notes.contains("empty"), "{ended:?}");
    let ended = rig.tool(&record("--cyclic"));
    let [missing, all] = lost(&ended);
    assert_eq!((missing, all), (0, rows(&path).len() as u64), "{ended:?}");
    for row in rows(&path) {
        let fields: Vec<&str> = row.split(',').collect();
        assert_eq!((fields[1], fields[2]), ("", "0.000"), "{row}");
    }
    let note = format!("{all} samples with an empty value");
    assert!(ended.notes.contains(&note), "{ended:?}");
    let shown = rig.tool("--node 10 watch --cyclic --seconds 0.1");
    assert!(shown.out.contains("slope-long16           -"), "{shown:?}");
    let sample = rig
        .tool("--node 10 --json watch --cyclic --seconds 0.1")
        .out;
    let sample: Value = serde_json::from_str(sample.lines().next().unwrap()).unwrap();
    assert_eq!(sample["slope-long16"], json!(null));
    // With 0.01 deg, 16 bits have room for all angles.
    let mut rig = inclined("0.01deg");
    let ended = rig.tool(&record("--cyclic"));
    assert!(
        rows(&path).iter().all(|row| row.contains(",45.0")),
        "{ended:?}"
    );
    assert!(!ended.notes.contains("empty"), "{ended:?}");
}

/// The same frame; if it has the angles, they are not available.
fn unavailable(frame: Frame) -> Frame {
    // SSI2 of address 128: PGN F029h.
    match frame.can_id() == CanId::extended(0x0CF0_2980) {
        true => Frame::of(frame.can_id(), [0xFF; 8], 8),
        false => frame,
    }
}

#[test]
fn j1939_sensor_without_valid_angles_is_alive() {
    for cyclic in ["", "--cyclic"] {
        let mut rig = Rig::with("ims360");
        rig.done("--node 50 raw 3100:1=01");
        rig.done("--node 50 save");
        let id = rig.first();
        rig.power_cycle(id);
        rig.altered = Some((rig.later(1500), rig.later(5500), unavailable));
        let ended = rig.tool(&format!(
            "--address 128 watch --every 50 {cyclic} --seconds 8"
        ));
        let [missing, all] = lost(&ended);
        assert!(missing <= 2 && (155..=161).contains(&all), "{ended:?}");
        let empty = ended.out.lines().filter(|line| line.contains("     -"));
        let count = empty.count();
        assert!((76..=82).contains(&count), "{count} {ended:?}");
        let note = format!("{count} samples with an empty value");
        assert!(ended.notes.contains(&note), "{}", ended.notes);
    }
}

#[test]
fn j1939_sensor_without_valid_angles_at_first_has_all_its_angles_later() {
    let mut rig = Rig::with("ims360");
    rig.done("--node 50 raw 3100:1=01");
    rig.done("--node 50 save");
    let id = rig.first();
    rig.power_cycle(id);
    rig.altered = Some((rig.later(0), rig.later(3000), unavailable));
    let ended = rig.tool("--address 128 watch --every 50 --seconds 4");
    assert_eq!(ended.code, 0, "{ended:?}");
    let last = ended.out.lines().last().unwrap();
    for name in ["slope-long32", "slope-lateral32"] {
        assert!(ended.out.lines().all(|line| line.contains(name)), "{last}");
    }
    assert!(last.contains("deg"), "{last}");
}
