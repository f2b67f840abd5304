//! Another program for a sensor, by the requests of the page: a product of each protocol, and several sensors. The images of the firmware
//! are in the test `images`.

use super::client::Running;
use super::plugged::{body, server_at};
use crate::bus::rig::{Rig, tilted};
use bench::{BusRate, Device, Flash, Geometry, NodeType, Updatable};
use plumbline::model::catalog::find;
use plumbline::update::header::{PAGE, PLACE, SIZE};
use plumbline::update::layout::BLUEPILL;
use plumbline::update::{Contents, Element, Header};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

/// The image file of a program for a device behind the bootloader of the core.
fn program(product: &str, version: u32) -> Vec<u8> {
    let mut body = vec![version as u8; PAGE + 512];
    body[PLACE..PLACE + SIZE].fill(0xFF);
    let contents = Contents {
        product: find(product).expect("a product").image.number(),
        element: Element::Ism330dhcx,
        board: BLUEPILL.board,
        layout: BLUEPILL.number,
        key: 0,
        version,
        hash: [0; 32],
    };
    let header = Header::new(&contents, &body).expect("a first page");
    [header.bytes(), &body[..]].concat()
}

/// The same as a file.
fn file(product: &str, version: u32) -> PathBuf {
    let name = format!("page-{}-{version}.plu", product);
    let path = crate::bus::rig::file(&name);
    fs::write(&path, program(product, version)).expect("the file");
    path
}

/// Adds a sensor as delivered with the program of version 1.
fn attach(rig: &mut Rig, product: &str, serial: u32) {
    let node_type = NodeType::find(product).expect("a product");
    let flash = Flash::blank(Geometry::STM32F103);
    let device = Device::new(&node_type, serial, flash, tilted());
    rig.attach_sensor(Updatable::new(device, &program(product, 1)));
    rig.run(3000);
}

/// A bus with another node, which acknowledges.
fn empty() -> Rig {
    let mut rig = Rig::new(BusRate::Follow);
    (rig.rate, rig.says_yes) = (Some("250"), true);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    rig
}

#[track_caller]
fn connect(server: &Running, protocol: &str, address: &str, rate: u32) {
    let quiet = server.post("/api/samples", r#"{"perSecond":0}"#);
    assert_eq!(quiet.status, 200);
    let place = json!({
        "port": "bench", "mode": "active", "rate": rate, "protocol": protocol, "address": address,
    });
    let answer = server.post("/api/connect", &place.to_string());
    assert_eq!(answer.status, 200, "{protocol}: {answer:?}");
}

fn update(server: &Running, product: &str, version: u32) -> Value {
    let body = body(&file(product, version), json!({}));
    server.post("/api/update", &body).json()
}

#[test]
fn sensor_of_each_protocol_is_updated_and_connected_again() {
    let all = [
        ("is2", "fsc", "300", 250),
        ("jn2101", "canopen", "10", 125),
        ("ims360", "j1939", "128", 125),
        ("tiltix080", "devicenet", "63", 125),
    ];
    for (product, protocol, address, rate) in all {
        let (server, _) = server_at(move || {
            let mut rig = empty();
            attach(&mut rig, product, 1);
            if protocol == "j1939" {
                rig.json("--node 50 set can-protocol=j1939 --save");
                let id = rig.first();
                rig.bus.borrow_mut().power_cycle(id);
                rig.run(3000);
            }
            rig
        });
        connect(&server, protocol, address, rate);
        let done = update(&server, product, 2);
        let told = [&done["loaded"], &done["before"], &done["version"]];
        assert_eq!(
            told,
            [&json!(true), &json!("0.0.1"), &json!("0.0.2")],
            "{protocol}: {done}"
        );
        let mut tab = server.tab();
        tab.wait("device", |device| {
            device["protocol"] == protocol && device["address"] == address
        });
    }
}

#[test]
fn update_changes_only_the_connected_one_of_two_sensors() {
    let (server, _) = server_at(|| {
        let mut rig = empty();
        attach(&mut rig, "jn2101", 1);
        rig.json("--node 10 node-id 11");
        attach(&mut rig, "jn2101", 2);
        rig
    });
    connect(&server, "canopen", "11", 125);
    assert_eq!(update(&server, "jn2101", 2)["loaded"], true);
    connect(&server, "canopen", "10", 125);
    assert_eq!(
        update(&server, "jn2101", 1)["loaded"],
        false,
        "it has its program"
    );
    assert_eq!(update(&server, "jn2101", 2)["loaded"], true);
    connect(&server, "canopen", "11", 125);
    assert_eq!(
        update(&server, "jn2101", 2)["loaded"],
        false,
        "it has the new one"
    );
}
