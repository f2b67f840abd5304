//! A J1939 sensor that is not in the catalogue, the example `new_j1939_sensor` of core, on the simulated bus, and its CAN database.

use bench::{Bus, BusRate, Device, Flash, NodeType};
use plumbline::can::{BitRate, Frame, extended};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};

#[path = "../../../core/examples/new_j1939_sensor.rs"]
mod example;

/// At rest at 30 deg.
fn tilted() -> Reading {
    Reading {
        acceleration: I32x3 {
            x: -ONE_G / 2,
            y: 0,
            z: (0.75_f64.sqrt() * f64::from(ONE_G)) as i32,
        },
        ..Reading::default()
    }
}

/// A bus with the sensor, and an exchange: the frames that follow a frame of 21h within a time in ms.
fn exchange(bus: &mut Bus, tester: bench::AdapterId, id: u32, data: &[u8], ms: u32) -> Vec<String> {
    bus.take_received(tester);
    let frame = Frame::data(extended(id), data).expect("at most eight bytes");
    bus.send(tester, frame);
    bus.run_until(after(bus.now(), millis(ms)));
    let received = bus.take_received(tester).into_iter();
    received.map(|(_, frame)| format!("{frame:?}")).collect()
}

#[test]
fn program_of_the_example_ends() {
    example::main();
}

#[test]
fn own_group_and_command_of_a_j1939_sensor_work_on_the_bus() {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
    let node_type = NodeType::from(&example::LISTING);
    let device = Device::new(&node_type, 1, Flash::default(), Box::new(tilted()));
    bus.attach(device);
    let tester = bus.adapter();
    bus.open(tester, None, false);
    // The claim with the identity number 1; 250 ms later the first group, 30.00 deg + 300 deg.
    bus.run_until(after(bus.now(), millis(600)));
    let begin = bus.take_received(tester).into_iter();
    let begin: Vec<_> = begin.map(|(_, frame)| format!("{frame:?}")).collect();
    assert_eq!(
        begin.first().map(String::as_str),
        Some("18EEFF90#0100E0FF00910080")
    );
    assert!(
        begin.contains(&"0CFF2090#E880FCFFFFFFFFFF".to_owned()),
        "{begin:?}"
    );
    // Mounting angle 5.00 deg: the next group has 25.00 deg.
    let sent = exchange(
        &mut bus,
        tester,
        0x18EF_9021,
        &[1, 0xF4, 1, 0, 0, 0, 0, 0],
        120,
    );
    let expected = ["18EF2190#0100FFFFFFFFFFFF", "0CFF2090#F47EFCFFFFFFFFFF"];
    assert_eq!(sent[..2], expected);
}

#[test]
fn database_of_a_j1939_sensor_has_its_own_signals() {
    let files = descriptors::describe_all(&example::LISTING);
    let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["mast.dbc"]);
    let text = &files[0].text;
    for part in [
        "BO_ 2365530256 SLOPE: 8 ",
        "SG_ Slope : 0|16@1+ (0.01,-300) [-300|342.55",
        "SG_ SlopeStatus : 16|2@1+ (1,0) [0|3] \"\"",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}
